//! The map of the mine that a recorded flight went through.

use serde::{Deserialize, Serialize};

use crate::TruthKind;

/// Name of the schema of [`TruthMap`] in an MCAP file.
pub const TRUTH_MAP_SCHEMA_NAME: &str = "crosscut.TruthMap";

/// JSON schema of [`TruthMap`].
pub const TRUTH_MAP_SCHEMA_TEXT: &str = include_str!("truth_map.schema.json");

/// The mine of a flight in the form of a flight's map: junctions and dead ends, and the passages between them, also those
/// that the flight does not come to. Its frame is that of the first true pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthMap {
    /// Junctions and dead ends; each has its index as `id`.
    pub nodes: Vec<TruthNode>,
    /// Passages; each has its index as `id`.
    pub edges: Vec<TruthEdge>,
}

/// A junction or a dead end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthNode {
    /// Its number.
    pub id: usize,
    /// [`TruthKind::Junction`] or [`TruthKind::DeadEnd`].
    pub kind: TruthKind,
    /// Where it is, m.
    pub x_m: f64,
    /// Where it is, m.
    pub y_m: f64,
    /// Its ways, by bearing ascending.
    pub ways: Vec<TruthWay>,
}

/// A way of a junction or a dead end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthWay {
    /// Its direction where it leaves the place, rad in the map's frame.
    pub bearing_rad: f64,
    /// Its width at the place, m.
    pub width_m: f64,
    /// Number of its passage.
    pub edge: usize,
}

/// A passage between two places.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruthEdge {
    /// Its number.
    pub id: usize,
    /// The place at one end.
    pub from: usize,
    /// The place at the other end.
    pub to: usize,
    /// Length of its centreline, m.
    pub length_m: f64,
    /// Its mean width, m.
    pub width_m: f64,
}

/// Why the bytes of a map could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TruthMapError {
    /// Not JSON, or not of the schema.
    #[error("the message is no map of a mine: {0}")]
    Json(#[from] serde_json::Error),
    /// An edge joins a node that is not there.
    #[error("edge {edge} of the map joins node {node}; there are {nodes} nodes")]
    NoNode {
        /// Index of the edge.
        edge: usize,
        /// Number of the node.
        node: usize,
        /// How many nodes there are.
        nodes: usize,
    },
}

impl TruthMap {
    /// Reads a map. Fields that the schema does not know are ignored.
    ///
    /// # Errors
    /// When it is not of the schema, or an edge joins a node that is not there.
    pub fn from_json(message: &[u8]) -> Result<Self, TruthMapError> {
        let map: Self = serde_json::from_slice(message)?;
        let nodes = map.nodes.len();
        for (edge, ends) in map.edges.iter().map(|edge| [edge.from, edge.to]).enumerate() {
            if let Some(node) = ends.into_iter().find(|&node| node >= nodes) {
                return Err(TruthMapError::NoNode { edge, node, nodes });
            }
        }
        Ok(map)
    }

    /// The message.
    pub fn to_json(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("no map keys and no writer that could fail")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{"nodes":[{"id":0,"kind":"dead_end","x_m":0.5,"y_m":0.0,"ways":[{"bearing_rad":0.1,"width_m":3.5,"edge":0}]},{"id":1,"kind":"dead_end","x_m":20.5,"y_m":0.0,"ways":[{"bearing_rad":-3.0,"width_m":3.5,"edge":0}]}],"edges":[{"id":0,"from":0,"to":1,"length_m":20.0,"width_m":3.5}]}"#;

    #[test]
    fn the_message_is_read_and_written_as_it_stands() {
        let map = TruthMap::from_json(TEXT.as_bytes()).expect("of the schema");
        assert_eq!(map.nodes[0].kind, TruthKind::DeadEnd);
        assert_eq!(map.to_json(), TEXT.as_bytes());
    }

    #[test]
    fn an_edge_to_a_node_that_is_not_there_is_refused() {
        let text = TEXT.replace(r#""to":1"#, r#""to":2"#);
        let error = TruthMap::from_json(text.as_bytes()).expect_err("refused").to_string();
        assert_eq!(error, "edge 0 of the map joins node 2; there are 2 nodes");
    }

    #[test]
    fn the_schema_names_every_field_and_requires_it() {
        let schema: serde_json::Value = serde_json::from_str(TRUTH_MAP_SCHEMA_TEXT).expect("JSON");
        let written: serde_json::Value = serde_json::from_str(TEXT).expect("JSON");
        let all_named = |written: &serde_json::Value, schema: &serde_json::Value| {
            for field in written.as_object().expect("an object").keys() {
                assert!(schema["properties"].get(field).is_some(), "{field} is not in the schema");
                assert!(schema["required"].as_array().expect("a list").iter().any(|name| name == field), "{field}");
            }
        };
        let [nodes, edges] = ["nodes", "edges"].map(|list| &schema["properties"][list]["items"]);
        all_named(&written, &schema);
        all_named(&written["nodes"][0], nodes);
        all_named(&written["nodes"][0]["ways"][0], &nodes["properties"]["ways"]["items"]);
        all_named(&written["edges"][0], edges);
    }
}
