//! Clusters: the label of each return, and the centres among the rows of U.

use crosscut_stage::{Embedding, Frame, Partition};
use rerun::{AsComponents, LineStrips2D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::BeamOrder;
use crate::colors::class_of;
use crate::spectrum::drawn_row;
use crate::tensors::{entries, f64_matrix, i32_vector, rows_of};

/// A bar goes on over fewer beams without a return than this.
const GAP: usize = 4;

/// Look of the entities.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static("kmeans/labels", &LineStrips2D::update_fields().with_radii([ui(4.0)]))?;
    rec.log_static("kmeans/centroids", &Points3D::update_fields().with_radii([ui(7.0)]))
}

/// Labels and centroids of one revolution, the centroids drawn at the embedding's `scale`.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame, order: &BeamOrder, scale: f64) -> RecordingStreamResult<()> {
    let partition = &frame.partition;
    log_labels(rec, partition, order)?;
    let centroids = &partition.centroids;
    let (clusters, k) = (centroids.nrows(), centroids.ncols());
    let points = Points3D::new((0..clusters).map(|c| drawn_row(centroids, c, scale)))
        .with_class_ids((0..clusters).map(|c| class_of(u32::try_from(c).ok())))
        .with_show_labels(false);
    let exact = match centroids {
        Embedding::Sparse { .. } => entries(centroids, "cluster, eigenvector, value"),
        dense => f64_matrix(rows_of(dense).collect(), [clusters, k], ["cluster", "eigenvector"]),
    };
    rec.log("kmeans/centroids", &[&exact as &dyn AsComponents, &points])
}

/// The labels, -1 for a return that was left out, and the clusters as bars along the edges of W.
fn log_labels(rec: &RecordingStream, partition: &Partition, order: &BeamOrder) -> RecordingStreamResult<()> {
    let labels = &partition.labels;
    let margin = -0.02 * order.used as f32;
    let runs = runs(labels, &order.places);
    let along = |&(_, from, to): &(u16, usize, usize)| {
        let (from, to) = (from as f32, to as f32);
        [[[from, margin], [to, margin]], [[margin, from], [margin, to]]]
    };
    let bars = LineStrips2D::new(runs.iter().flat_map(along))
        .with_class_ids(runs.iter().flat_map(|&(class, ..)| [class; 2]))
        .with_show_labels(false);
    let exact = i32_vector(labels.iter().map(|label| label.map_or(-1, u32::cast_signed)), "return");
    rec.log("kmeans/labels", &[&exact as &dyn AsComponents, &bars])
}

/// Class, first place and place after the last of each run of equal labels, broken where places are left out.
fn runs(labels: &[Option<u32>], places: &[usize]) -> Vec<(u16, usize, usize)> {
    let placed: Vec<_> = labels.iter().zip(places).collect();
    let joined = |a: &(&Option<u32>, &usize), b: &(&Option<u32>, &usize)| a.0 == b.0 && b.1 - a.1 <= GAP;
    let runs = placed.chunk_by(joined);
    runs.map(|run| (class_of(*run[0].0), *run[0].1, run[run.len() - 1].1 + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::NO_WALL;

    #[test]
    fn runs_end_where_the_label_changes_and_where_beams_came_back_without_a_return() {
        let (a, b) = (Some(0), Some(1));
        assert_eq!(runs(&[a, a, b, None, a], &[2, 3, 4, 5, 6]), [(0, 2, 4), (1, 4, 5), (NO_WALL, 5, 6), (0, 6, 7)]);
        assert_eq!(runs(&[a, a, a], &[0, 2, 30]), [(0, 0, 3), (0, 30, 31)]);
        assert_eq!(runs(&[], &[]), []);
        assert_eq!(runs(&[a], &[]), [], "labels that do not fit the returns break nothing");
    }
}
