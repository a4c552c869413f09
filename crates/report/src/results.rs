//! The line of results: one JSON object per scan message.

use std::io::{self, Write};

use crosscut_stage::Frame;
use serde::{Deserialize, Serialize};

/// At most this many eigenvalues stand in a line.
pub const MAX_EIGENVALUES: usize = 16;

/// What one revolution becomes in the results. No clock times: the same scan gives the same line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultsLine {
    /// The message's index in its topic.
    pub seq: u64,
    /// The sensor's stamp.
    pub stamp_ns: u64,
    /// Number of returns, n.
    pub returns: usize,
    /// What is reported: the number of walls, islands left out.
    pub junctions: usize,
    /// What the eigenvalues say.
    pub k: usize,
    /// Decades by which the zero tolerance could be moved before `k` changes; null if no eigenvalue is known but exact
    /// zeros, as from `components`, or at n = 0.
    pub margin: Option<f64>,
    /// 0 to 1.
    pub confidence: f64,
    /// `closed`, `dead_end`, `corridor`, `bend`, `tee`, `cross`, `junction_5`..., `partial_view`.
    pub place: String,
    /// The smallest eigenvalues, ascending; at most [`MAX_EIGENVALUES`], so with as many zeros the next is not there.
    pub eigenvalues: Vec<f64>,
    /// Walls, by id.
    pub walls: Vec<WallLine>,
    /// Openings, by bearing ascending.
    pub openings: Vec<OpeningLine>,
    /// Per beam, in message order: wall id, [`Frame::NO_RETURN`] or [`Frame::NO_WALL`]. Per point for a cloud.
    pub labels: Vec<i32>,
    /// What was dropped, repaired or fallen back to.
    pub notes: Vec<String>,
}

/// A wall in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallLine {
    /// Its number.
    pub id: u32,
    /// How many returns it has.
    pub returns: usize,
    /// Anticlockwise from the first to the last return (from > to crosses ±π).
    pub bearing_rad: [f64; 2],
    /// A pillar: in `k`, not in `junctions`.
    pub island: bool,
}

/// An opening in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpeningLine {
    /// Direction towards the branch.
    pub bearing_rad: f64,
    /// Clear width across the branch.
    pub width_m: f64,
    /// The walls on its clockwise and anticlockwise side.
    pub walls: [u32; 2],
    /// `seen_through` or `no_return`.
    pub evidence: String,
    /// The end of a limited view cuts it: bearing and width are those of the part in view.
    #[serde(default)]
    pub cut_by_view: bool,
}

impl ResultsLine {
    /// The line of a finished frame.
    pub fn of(frame: &Frame) -> Self {
        let (spectrum, junction) = (&frame.spectrum, &frame.junction);
        Self {
            seq: frame.revolution.seq,
            stamp_ns: frame.revolution.stamp_ns,
            returns: frame.revolution.len(),
            junctions: junction.junctions,
            k: spectrum.k,
            margin: spectrum.margin_decades,
            confidence: junction.confidence,
            place: junction.place.to_string(),
            eigenvalues: spectrum.eigenvalues.iter().copied().take(MAX_EIGENVALUES).collect(),
            walls: junction
                .walls
                .iter()
                .map(|w| WallLine { id: w.id, returns: w.returns, bearing_rad: w.bearing_rad, island: w.island })
                .collect(),
            openings: junction
                .openings
                .iter()
                .map(|o| OpeningLine {
                    bearing_rad: o.bearing_rad,
                    width_m: o.width_m,
                    walls: o.walls,
                    evidence: o.evidence.to_string(),
                    cut_by_view: o.cut_by_view,
                })
                .collect(),
            labels: frame.labels(),
            notes: frame.notes.iter().map(str::to_owned).collect(),
        }
    }

    /// Writes the line as JSON, with its line end.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut *out, self)?;
        out.write_all(b"\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_revolution_has_a_line_with_every_field_of_the_contract() {
        let mut out = Vec::new();
        ResultsLine::of(&Frame::default()).write(&mut out).expect("memory");
        assert_eq!(
            String::from_utf8(out).expect("text"),
            concat!(
                r#"{"seq":0,"stamp_ns":0,"returns":0,"junctions":0,"k":0,"margin":null,"confidence":0.0,"#,
                r#""place":"partial_view","eigenvalues":[],"walls":[],"openings":[],"labels":[],"notes":[]}"#,
                "\n"
            )
        );
    }

    #[test]
    fn a_line_reads_back_bit_for_bit() {
        let mut frame = Frame::default();
        frame.spectrum.eigenvalues = vec![-1.2345678901234567e-16, 0.1 + 0.2, 2.0];
        let line = ResultsLine::of(&frame);
        let mut text = Vec::new();
        line.write(&mut text).expect("memory");
        assert_eq!(serde_json::from_slice::<ResultsLine>(&text).expect("JSON"), line);
    }
}
