//! What each stage made of a revolution, as named numbers and words: to find the first stage and value that differ.

use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, Step};

/// A value that a stage made.
#[derive(Clone, Debug, PartialEq)]
pub struct StageValue {
    /// The stage.
    pub step: Step,
    /// Its name: `degrees`, `eigenvalues`.
    pub field: &'static str,
    /// The value.
    pub value: Values,
}

/// Numbers or words, in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; a missing one is NaN.
    Numbers(Vec<f64>),
    /// Words.
    Words(Vec<String>),
}

/// The first value that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The stage.
    pub step: String,
    /// The value, with the place within it: `degrees[17]`.
    pub field: String,
    /// Both values, as text.
    pub values: [String; 2],
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b] = &self.values;
        write!(f, "{}: {} is {a} and {b}", self.step, self.field)
    }
}

/// The values of every stage, in the order of the stages: W, U and the points entry by entry.
pub fn stage_values(frame: &Frame) -> Vec<StageValue> {
    let mut values = Vec::new();
    let mut add = |step, field, value| values.push(StageValue { step, field, value });
    let number = |x: f64| Values::Numbers(vec![x]);
    let count = |n: usize| number(n as f64);
    let Frame { revolution, affinity, spectrum, partition, .. } = frame;

    let points = revolution.points_m.iter().flat_map(|point| [point.x, point.y, point.z]);
    add(Step::Ingest, "returns", count(revolution.len()));
    add(Step::Ingest, "points_m", Values::Numbers(points.collect()));

    let mut weights = Vec::new();
    affinity.weights.for_each(|_, _, weight| weights.push(weight));
    add(Step::Affinity, "edges", count(affinity.weights.stored()));
    add(Step::Affinity, "W", Values::Numbers(weights));
    add(Step::Affinity, "degrees", Values::Numbers(affinity.degrees.to_vec()));
    let rooms = affinity.verdicts.iter().map(|verdict| verdict.room_ratio);
    add(Step::Affinity, "verdicts", count(affinity.verdicts.len()));
    add(Step::Affinity, "room_ratio", Values::Numbers(rooms.collect()));

    add(Step::Spectral, "k", count(spectrum.k));
    add(Step::Spectral, "tolerance", number(spectrum.tolerance));
    add(Step::Spectral, "eigenvalues", Values::Numbers(spectrum.eigenvalues.clone()));

    let labels = partition.labels.iter().map(|label| label.map_or(-1.0, f64::from));
    add(Step::Kmeans, "clusters", count(partition.clusters));
    add(Step::Kmeans, "labels", Values::Numbers(labels.collect()));

    let line = ResultsLine::of(frame);
    add(Step::Report, "walls", count(line.junctions));
    add(Step::Report, "place", Values::Words(vec![line.place]));
    add(
        Step::Report,
        "wall_bearings_rad",
        Values::Numbers(line.walls.iter().flat_map(|of| of.wall.bearing_rad).collect()),
    );
    let of_openings =
        |of: fn(&crosscut_report::OpeningLine) -> f64| Values::Numbers(line.openings.iter().map(of).collect());
    add(Step::Report, "openings", count(line.openings.len()));
    add(Step::Report, "opening_bearings_rad", of_openings(|opening| opening.bearing_rad));
    add(Step::Report, "opening_widths_m", of_openings(|opening| opening.width_m));
    add(Step::Report, "confidence", number(line.confidence.unwrap_or(f64::NAN)));
    add(Step::Report, "notes", Values::Words(line.notes));
    values
}

/// The first value that differs at all.
pub fn first_difference(a: &[StageValue], b: &[StageValue]) -> Option<Difference> {
    a.iter().zip(b).find_map(|(a, b)| {
        let (place, values) = difference(&a.value, &b.value)?;
        Some(Difference { step: a.step.name().to_owned(), field: format!("{}{place}", a.field), values })
    })
}

/// The place of the first difference, and both values there.
fn difference(a: &Values, b: &Values) -> Option<(String, [String; 2])> {
    let differ = match (a, b) {
        (Values::Numbers(a), Values::Numbers(b)) => {
            let is_same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan());
            if a.len() != b.len() {
                return Some((String::new(), [a, b].map(|of| format!("{} values", of.len()))));
            }
            let number = |x: f64| format!("{x:?}").trim_end_matches(".0").to_owned();
            let name = |x: f64| if x.is_nan() { "none".to_owned() } else { number(x) };
            let at = (0..a.len()).find(|&at| !is_same(a[at], b[at]))?;
            (at, a.len(), [name(a[at]), name(b[at])])
        }
        (Values::Words(a), Values::Words(b)) => {
            let most = a.len().max(b.len());
            let at = (0..most).find(|&at| a.get(at) != b.get(at))?;
            let name = |of: &[String]| of.get(at).map_or_else(|| "none".to_owned(), |word| format!("{word:?}"));
            (at, most, [name(a), name(b)])
        }
        _ => unreachable!("a value is numbers in every frame, or words in every frame"),
    };
    let (at, of, values) = differ;
    Some((if of == 1 { String::new() } else { format!("[{at}]") }, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(points: usize) -> Frame {
        let mut frame = Frame::default();
        frame.revolution.points_m = vec![crosscut_stage::Point::new(1.0, 2.0, 0.0); points];
        frame.affinity.weights.make_dense(points).fill(0.5);
        frame.affinity.sum_degrees();
        frame
    }

    #[test]
    fn the_first_stage_that_differs_is_named_with_both_values() {
        let mut other = frame(3);
        let crosscut_stage::Weights::Dense(w) = &mut other.affinity.weights else { panic!("dense") };
        w[(2, 1)] = 0.25;
        other.spectrum.k = 7;
        let first = first_difference(&stage_values(&frame(3)), &stage_values(&other));
        assert_eq!(first.expect("differs").to_string(), "affinity: W[5] is 0.5 and 0.25");
    }

    #[test]
    fn values_differ_if_they_differ_at_all_and_a_missing_one_is_one_of_its_own() {
        let values = |a: f64, b: f64| difference(&Values::Numbers(vec![a]), &Values::Numbers(vec![b]));
        assert_eq!(values(3.0, 0.03).expect("differs").1, ["3", "0.03"]);
        assert!(values(1.0, 1.0 + f64::EPSILON).is_some());
        assert!(values(f64::NAN, f64::NAN).is_none() && values(f64::NAN, 1.0).is_some());
    }
}
