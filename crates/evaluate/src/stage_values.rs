//! What each stage made of a revolution, as named numbers and words: to find the first stage and value that differ.

use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, Step};
use serde::{Deserialize, Serialize};

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Values {
    /// Numbers; a missing one is NaN in memory and null in JSON.
    Numbers(#[serde(deserialize_with = "numbers")] Vec<f64>),
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

/// The values of every stage, in the order of the stages. `whole`: W, U and the points entry by entry; else a few numbers
/// for each, in which any other entry shows, so that files of them stay small.
pub fn stage_values(frame: &Frame, whole: bool) -> Vec<StageValue> {
    let mut values = Vec::new();
    let mut add = |step, field, value| values.push(StageValue { step, field, value });
    let number = |x: f64| Values::Numbers(vec![x]);
    let count = |n: usize| number(n as f64);
    let Frame { revolution, affinity, spectrum, partition, .. } = frame;

    let points = revolution.points_m.iter().flat_map(|point| [point.x, point.y, point.z]);
    add(Step::Ingest, "returns", count(revolution.len()));
    add(Step::Ingest, "points_m", if whole { Values::Numbers(points.collect()) } else { summed(points) });

    let mut weights = Vec::new();
    affinity.weights.for_each(|_, _, weight| weights.push(weight));
    add(Step::Affinity, "edges", count(affinity.weights.stored()));
    add(Step::Affinity, "W", if whole { Values::Numbers(weights) } else { summed_weights(&weights) });
    let degrees = affinity.degrees.iter().copied();
    let extremes = || vec![degrees.clone().fold(f64::INFINITY, f64::min), degrees.clone().fold(0.0, f64::max)];
    add(Step::Affinity, "degrees", Values::Numbers(if whole { degrees.clone().collect() } else { extremes() }));
    let rooms = affinity.verdicts.iter().map(|verdict| verdict.room_ratio);
    add(Step::Affinity, "verdicts", count(affinity.verdicts.len()));
    add(Step::Affinity, "room_ratio", Values::Numbers(rooms.collect()));

    add(Step::Spectral, "k", count(spectrum.k));
    add(Step::Spectral, "tolerance", number(spectrum.tolerance));
    let kept = if whole { usize::MAX } else { spectrum.k + 1 };
    add(Step::Spectral, "eigenvalues", Values::Numbers(spectrum.eigenvalues.iter().copied().take(kept).collect()));

    let labels = partition.labels.iter().map(|label| label.map_or(-1.0, f64::from));
    add(Step::Kmeans, "clusters", count(partition.clusters));
    add(Step::Kmeans, "labels", Values::Numbers(labels.collect()));

    let line = ResultsLine::of(frame);
    add(Step::Report, "walls", count(line.junctions));
    add(Step::Report, "place", Values::Words(vec![line.place]));
    add(
        Step::Report,
        "wall_bearings_rad",
        Values::Numbers(line.walls.iter().flat_map(|wall| wall.bearing_rad).collect()),
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

/// The sum, and a sum in which each place counts differently: two values that changed places show.
fn summed(values: impl Iterator<Item = f64>) -> Values {
    let (mut sum, mut by_place) = (0.0, 0.0);
    for (place, value) in values.enumerate() {
        sum += value;
        by_place += value / (1.0 + place as f64);
    }
    Values::Numbers(vec![sum, by_place])
}

/// The sums of weights, and that of their logarithms, in which the weak ones show: they decide counts.
fn summed_weights(weights: &[f64]) -> Values {
    const NO_WEIGHT: f64 = 1e-16;
    let logarithms = weights.iter().map(|weight| (weight + NO_WEIGHT).ln()).sum();
    match summed(weights.iter().copied()) {
        Values::Numbers(sums) => Values::Numbers(sums.into_iter().chain([logarithms]).collect()),
        words => words,
    }
}

/// The first value that differs by more than `tolerance` of its field: |a - b| is more than that share of the larger, and more
/// than a thousandth of it.
pub fn first_difference(
    a: &[StageValue],
    b: &[StageValue],
    tolerance: impl Fn(&'static str) -> f64,
) -> Option<Difference> {
    a.iter().zip(b).find_map(|(a, b)| {
        let (place, values) = difference(&a.value, &b.value, tolerance(a.field))?;
        Some(Difference { step: a.step.name().to_owned(), field: format!("{}{place}", a.field), values })
    })
}

/// Values below this are compared as if they were as large: zeros come with rounding errors of any relative size.
const ABSOLUTE: f64 = 1e-3;

/// The place of the first difference, and both values there.
fn difference(a: &Values, b: &Values, tolerance: f64) -> Option<(String, [String; 2])> {
    match (a, b) {
        (Values::Numbers(a), Values::Numbers(b)) => {
            let is_same = |a: f64, b: f64| {
                let allowed = tolerance * a.abs().max(b.abs()).max(ABSOLUTE);
                a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= allowed
            };
            let number = |x: f64| format!("{x:?}").trim_end_matches(".0").to_owned();
            let name = |x: f64| if x.is_nan() { "none".to_owned() } else { number(x) };
            if a.len() != b.len() {
                let many = |of: &[f64]| format!("{} values", of.len());
                return Some((String::new(), [many(a), many(b)]));
            }
            let at = (0..a.len()).find(|&at| !is_same(a[at], b[at]))?;
            let place = if a.len() == 1 { String::new() } else { format!("[{at}]") };
            Some((place, [name(a[at]), name(b[at])]))
        }
        (Values::Words(a), Values::Words(b)) if a != b => {
            let at = (0..a.len().max(b.len())).find(|&at| a.get(at) != b.get(at))?;
            let name = |of: &[String]| of.get(at).map_or_else(|| "none".to_owned(), |word| format!("{word:?}"));
            Some((if a.len().max(b.len()) == 1 { String::new() } else { format!("[{at}]") }, [name(a), name(b)]))
        }
        (Values::Words(_), Values::Words(_)) => None,
        // Read from JSON, no words are no numbers either.
        (Values::Numbers(none), words) if none.is_empty() => difference(&Values::Words(Vec::new()), words, tolerance),
        (words, Values::Numbers(none)) if none.is_empty() => difference(words, &Values::Words(Vec::new()), tolerance),
        (a, b) => difference(&Values::Words(vec![format!("{a:?}")]), &Values::Words(vec![format!("{b:?}")]), 0.0),
    }
}

/// Numbers in which null stands for a missing one.
fn numbers<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let numbers = Vec::<Option<f64>>::deserialize(from)?;
    Ok(numbers.into_iter().map(|number| number.unwrap_or(f64::NAN)).collect())
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
        let of = |whole| first_difference(&stage_values(&frame(3), whole), &stage_values(&other, whole), |_| 1e-9);
        assert_eq!(
            difference(&Values::Numbers(vec![3.0]), &Values::Numbers(vec![0.03]), 0.0).expect("differs").1,
            ["3", "0.03"]
        );
        assert_eq!(of(true).expect("differs").to_string(), "affinity: W[5] is 0.5 and 0.25");
        assert_eq!(of(false).expect("differs").to_string(), "affinity: W[0] is 4.5 and 4.25");
    }

    #[test]
    fn a_tolerance_is_relative_above_a_thousandth_and_absolute_below() {
        let value = |x| vec![StageValue { step: Step::Report, field: "widths", value: Values::Numbers(vec![x]) }];
        let differ = |a, b| first_difference(&value(a), &value(b), |_| 0.01).is_some();
        assert!(!differ(100.0, 100.9) && differ(100.0, 102.0));
        assert!(!differ(1e-9, 9e-6) && differ(1e-9, 2e-5));
        assert!(!differ(f64::NAN, f64::NAN) && differ(f64::NAN, 1.0), "a missing value is one of its own");
    }

    #[test]
    fn values_read_back_also_where_one_is_missing() {
        for value in [Values::Numbers(vec![0.1 + 0.2, 3.0]), Values::Words(vec!["tee".into()]), Values::Numbers(vec![])]
        {
            let text = serde_json::to_string(&value).expect("JSON");
            assert_eq!(serde_json::from_str::<Values>(&text).expect("JSON"), value);
        }
        let missing = serde_json::to_string(&Values::Numbers(vec![f64::NAN])).expect("JSON");
        assert_eq!(missing, "[null]");
        let Values::Numbers(read) = serde_json::from_str(&missing).expect("JSON") else { panic!("numbers") };
        assert!(read[0].is_nan());
    }
}
