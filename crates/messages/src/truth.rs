//! What is really there, beside each scan of a simulated or labelled recording.

use serde::{Deserialize, Serialize};

/// Name of the truth schema in an MCAP file.
pub const TRUTH_SCHEMA_NAME: &str = "crosscut.Truth";

/// JSON schema of [`Truth`].
pub const TRUTH_SCHEMA_TEXT: &str = include_str!("truth.schema.json");

/// Truth of one scan: what its noise-free view shows, never what lies beyond sight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Number of walls, islands left out: the paper's count. A plain tunnel has 2, a dead end 1.
    pub walls: u32,
    /// Number of pillars. They have wall ids too.
    pub islands: u32,
    /// The ways on, by bearing ascending.
    pub openings: Vec<TruthOpening>,
    /// One entry a beam, in message order: the id of the wall that it hits, [`Truth::NO_RETURN`] or
    /// [`Truth::NO_WALL`]. Walls and islands are numbered together from 0, by their smallest beam index.
    pub labels: Vec<i32>,
    /// Where the scan was taken; only on flights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<TruthPose>,
    /// What kind of place that is; only on flights, and only where it is clear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub here: Option<TruthPlace>,
    /// The vehicle touched rock during the scan; only on missions.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub contact: bool,
}

/// The pose of the sensor at the first beam of a scan, in the frame of that of the flight's first scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthPose {
    /// Ahead of the first pose, m.
    pub x_m: f64,
    /// To the left of the first pose, m.
    pub y_m: f64,
    /// Anticlockwise from the heading of the first pose, rad.
    pub yaw_rad: f64,
}

/// What lies at the place of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TruthPlace {
    /// Kind of the place.
    pub kind: TruthKind,
    /// Number of its ways.
    pub ways: u32,
}

/// A kind of place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TruthKind {
    /// Three or more ways.
    Junction,
    /// Two ways.
    Passage,
    /// One way.
    DeadEnd,
    /// Much wider than its one or two ways.
    Chamber,
}

/// One way on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthOpening {
    /// Towards the branch, rad in the body frame.
    pub bearing_rad: f64,
    /// Clear width across the branch, m.
    pub width_m: f64,
}

/// Why the bytes of a truth message could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TruthError {
    /// Not JSON, or not of the schema.
    #[error("the message is no truth: {0}")]
    Json(#[from] serde_json::Error),
    /// A label that means nothing.
    #[error("the label of beam {beam} is {label}; it must be -2, -1 or the number of one of {walls} walls and islands")]
    Label {
        /// Which beam.
        beam: usize,
        /// Its label.
        label: i32,
        /// Walls and islands.
        walls: u64,
    },
}

impl Truth {
    /// Label of a beam that comes back with nothing.
    pub const NO_RETURN: i32 = -1;
    /// Label of a beam that hits something which is no wall, such as dust.
    pub const NO_WALL: i32 = -2;

    /// Reads a truth message. Fields that the schema does not know are ignored.
    ///
    /// # Errors
    /// When it is not of the schema, or a label names no wall.
    pub fn from_json(message: &[u8]) -> Result<Self, TruthError> {
        let truth: Self = serde_json::from_slice(message)?;
        let walls = u64::from(truth.walls) + u64::from(truth.islands);
        let known = |label: i32| label >= Self::NO_WALL && i64::from(label) < walls as i64;
        match truth.labels.iter().position(|&label| !known(label)) {
            Some(beam) => Err(TruthError::Label { beam, label: truth.labels[beam], walls }),
            None => Ok(truth),
        }
    }

    /// The truth message.
    pub fn to_json(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("no map keys and no writer that could fail")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_of_the_contract_is_read_and_written_as_it_stands() {
        let text = br#"{"walls":1,"islands":1,"openings":[{"bearing_rad":0.5,"width_m":3.5}],"labels":[0,-1,1,-2]}"#;
        let truth = Truth::from_json(text).expect("of the schema");
        assert_eq!((truth.pose, truth.here), (None, None));
        assert_eq!(truth.openings, [TruthOpening { bearing_rad: 0.5, width_m: 3.5 }]);
        assert_eq!((truth.walls, truth.islands, &truth.labels[..]), (1, 1, &[0, -1, 1, -2][..]));
        assert_eq!(truth.to_json(), text);
        let flown = br#"{"walls":2,"islands":0,"openings":[],"labels":[],"pose":{"x_m":1.5,"y_m":0.0,"yaw_rad":-0.5},"here":{"kind":"dead_end","ways":1},"contact":true}"#;
        let truth = Truth::from_json(flown).expect("of the schema");
        assert!(truth.contact);
        assert_eq!(truth.here, Some(TruthPlace { kind: TruthKind::DeadEnd, ways: 1 }));
        assert_eq!(truth.to_json(), flown);
    }

    #[test]
    fn labels_that_name_no_wall_and_missing_fields_are_refused() {
        let refused = |text: &str| Truth::from_json(text.as_bytes()).expect_err("must be refused").to_string();
        assert!(refused(r#"{"walls":2,"islands":0,"openings":[],"labels":[0,2]}"#).contains("beam 1 is 2"));
        assert!(refused(r#"{"walls":2,"islands":0,"openings":[],"labels":[-3]}"#).contains("beam 0 is -3"));
        assert!(refused(r#"{"walls":2,"islands":0,"openings":[]}"#).contains("labels"));
        assert!(refused("walls").contains("no truth"));
    }

    #[test]
    fn the_schema_names_every_field_that_is_written_and_requires_it() {
        let schema: serde_json::Value = serde_json::from_str(TRUTH_SCHEMA_TEXT).expect("JSON");
        let written: serde_json::Value = serde_json::from_slice(&Truth::default().to_json()).expect("JSON");
        for field in written.as_object().expect("an object").keys() {
            assert!(schema["properties"].get(field).is_some(), "{field} is not in the schema");
            assert!(schema["required"].as_array().expect("a list").iter().any(|name| name == field));
        }
    }
}
