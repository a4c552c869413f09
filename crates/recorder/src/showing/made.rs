//! What the stages made of each revolution of two flights, and the first stage at which they part.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use rerun::log::Chunk;
use rerun::{ComponentDescriptor, EncodedDepthImage, Scalars, Tensor, TensorBuffer, TextDocument, components};

use super::grouping::{Grouping, Wall, runs, weakest_edges};
use crate::schema;

/// What the recording has of the output of the stages for a revolution: numbers that are equal where the outputs are equal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Made {
    /// Number of returns, by ingest.
    returns: Option<f64>,
    /// Of the picture of W; a light recording has none.
    w: Option<u64>,
    k: Option<f64>,
    /// Of the clusters, whatever their numbers.
    clusters: Option<u64>,
    /// The walls of the beams.
    pub(super) grouping: Grouping,
}

impl Made {
    /// The first stage that made something else, and of what: `("affinity", "W")`. What either does not have counts as the
    /// same.
    pub(super) fn parts_from(&self, other: &Self) -> [&'static str; 2] {
        fn differ<T: PartialEq>(one: Option<T>, other: Option<T>) -> bool {
            one.zip(other).is_some_and(|(one, other)| one != other)
        }
        let stages = [
            (["ingest", "returns"], differ(self.returns, other.returns)),
            (["affinity", "W"], differ(self.w, other.w)),
            (["spectral", "k"], differ(self.k, other.k)),
            (["kmeans", "clusters"], differ(self.clusters, other.clusters)),
        ];
        stages.into_iter().find(|(_, differ)| *differ).map_or(["report", "walls"], |(stage, _)| stage)
    }

    /// Whether k is the same.
    pub(super) fn has_k_of(&self, other: &Self) -> bool {
        self.k == other.k
    }
}

/// Adds what a chunk of the recording has.
pub(super) fn learn(made: &mut BTreeMap<i64, Made>, entity: &str, chunk: &Chunk) {
    const SCAN_COUNT: &str = schema::SCAN_COUNT.path;
    const AFFINITY_W: &str = schema::AFFINITY_W.path;
    const SPECTRAL_K: &str = schema::SPECTRAL_K.path;
    const KMEANS_LABELS: &str = schema::KMEANS_LABELS.path;
    const REPORT_LABELS: &str = schema::REPORT_LABELS.path;
    const REPORT_WALLS: &str = schema::REPORT_WALLS.path;
    const REPORT_WHY: &str = schema::REPORT_WHY.path;
    let tensor = Tensor::descriptor_data();
    match entity {
        REPORT_LABELS => {
            let labels = values(chunk, &tensor, |labels: &components::TensorData| match &labels.buffer {
                TensorBuffer::I32(labels) => Some(runs(labels)),
                _ => None,
            });
            labels.into_iter().for_each(|(seq, of)| made.entry(seq).or_default().grouping.labels = of);
        }
        REPORT_WALLS => {
            let walls = values(chunk, &tensor, |walls: &components::TensorData| match &walls.buffer {
                TensorBuffer::F64(rows) => Some(rows.chunks_exact(6).map(Wall::of).collect()),
                _ => None,
            });
            walls.into_iter().for_each(|(seq, of)| made.entry(seq).or_default().grouping.walls = of);
        }
        REPORT_WHY => {
            let text = TextDocument::descriptor_text();
            let weakest = values(chunk, &text, |text: &components::Text| Some(weakest_edges(text)));
            weakest.into_iter().for_each(|(seq, of)| made.entry(seq).or_default().grouping.weakest = of);
        }
        SCAN_COUNT => numbers(chunk).into_iter().for_each(|(seq, of)| made.entry(seq).or_default().returns = Some(of)),
        SPECTRAL_K => numbers(chunk).into_iter().for_each(|(seq, of)| made.entry(seq).or_default().k = Some(of)),
        AFFINITY_W => {
            let prints = values(chunk, &EncodedDepthImage::descriptor_blob(), |blob: &components::Blob| {
                Some(print(blob.0.0.as_ref()))
            });
            prints.into_iter().for_each(|(seq, of)| made.entry(seq).or_default().w = Some(of));
        }
        KMEANS_LABELS => {
            let prints = values(chunk, &tensor, |labels: &components::TensorData| {
                let TensorBuffer::I32(labels) = &labels.buffer else { return None };
                Some(print(&renumbered(labels)))
            });
            prints.into_iter().for_each(|(seq, of)| made.entry(seq).or_default().clusters = Some(of));
        }
        _ => {}
    }
}

/// What is made of the first value of a component at each revolution, where there is one.
fn values<C: rerun::Component, T>(
    chunk: &Chunk,
    component: &ComponentDescriptor,
    make: impl Fn(&C) -> Option<T>,
) -> Vec<(i64, T)> {
    let revolutions = chunk.timelines().get(&"revolution".into()).map_or(&[][..], |column| column.times_raw());
    let value = |row: usize| chunk.component_batch::<C>(component.component, row)?.ok()?.into_iter().next();
    revolutions.iter().enumerate().filter_map(|(row, &seq)| Some((seq, make(&value(row)?)?))).collect()
}

fn print<T: std::hash::Hash>(values: &[T]) -> u64 {
    let mut hasher = DefaultHasher::new();
    values.hash(&mut hasher);
    hasher.finish()
}

/// Labels in the order in which they first appear, so that the same clusters have the same labels; negative ones stay.
fn renumbered(labels: &[i32]) -> Vec<i32> {
    let mut new = BTreeMap::new();
    labels
        .iter()
        .map(|&label| {
            let next = new.len() as i32;
            if label < 0 { label } else { *new.entry(label).or_insert(next) }
        })
        .collect()
}

/// The number at each revolution, where there is one.
pub(super) fn numbers(chunk: &Chunk) -> Vec<(i64, f64)> {
    let revolutions = chunk.timelines().get(&"revolution".into()).map_or(&[][..], |column| column.times_raw());
    let number = |row: usize| {
        let scalars = chunk.component_batch::<components::Scalar>(Scalars::descriptor_scalars().component, row);
        Some(scalars?.ok()?.first()?.0.0)
    };
    revolutions.iter().enumerate().filter_map(|(row, &seq)| Some((seq, number(row)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flights_part_at_the_first_stage_that_made_something_else() {
        let made = Made { returns: Some(340.0), w: Some(1), k: Some(3.0), clusters: Some(7), ..Made::default() };
        let from = |other: Made| made.parts_from(&other)[0];
        assert_eq!(from(Made { returns: Some(339.0), w: Some(2), ..made.clone() }), "ingest");
        assert_eq!(from(Made { w: Some(2), k: Some(4.0), ..made.clone() }), "affinity");
        assert_eq!(
            from(Made { w: None, k: Some(4.0), ..made.clone() }),
            "spectral",
            "a light recording has no picture of W"
        );
        assert_eq!(from(Made { clusters: Some(8), ..made.clone() }), "kmeans");
        assert_eq!(from(made.clone()), "report");
    }

    #[test]
    fn the_numbers_of_clusters_do_not_tell_them_apart() {
        assert_eq!(renumbered(&[2, 2, -1, 0, 2]), renumbered(&[1, 1, -1, 3, 1]));
        assert_ne!(print(&renumbered(&[0, 0, 1])), print(&renumbered(&[0, 1, 1])));
    }
}
