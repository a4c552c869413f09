//! Clusters: the label of each return, and the centres among the rows of U.

use crosscut_stage::{Frame, Partition};
use rerun::{AsComponents, LineStrips2D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::class_of;
use crate::tensors::{f64_matrix, i32_vector, rows_of};

/// Look of the entities.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static("kmeans/labels", &LineStrips2D::update_fields().with_radii([ui(4.0)]))?;
    rec.log_static("kmeans/centroids", &Points3D::update_fields().with_radii([ui(7.0)]))
}

/// Labels and centroids of one revolution.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    let partition = &frame.partition;
    log_labels(rec, partition)?;
    let centroids = &partition.centroids;
    let (clusters, k) = (centroids.nrows(), centroids.ncols());
    let points = (0..clusters).map(|c| std::array::from_fn(|j| if j < k { centroids[(c, j)] as f32 } else { 0.0 }));
    let points = Points3D::new(points.map(|p: [f32; 3]| p))
        .with_class_ids((0..clusters).map(|c| class_of(u32::try_from(c).ok())))
        .with_show_labels(false);
    let exact = f64_matrix(rows_of(centroids).collect(), [clusters, k], ["cluster", "eigenvector"]);
    rec.log("kmeans/centroids", &[&exact as &dyn AsComponents, &points])
}

/// The labels, -1 for a return that was left out, and each run of equal labels as a bar along the edges of W.
fn log_labels(rec: &RecordingStream, partition: &Partition) -> RecordingStreamResult<()> {
    let labels = &partition.labels;
    let margin = -0.02 * labels.len() as f32;
    let runs: Vec<(usize, usize)> = runs(labels);
    let along = |&(from, to): &(usize, usize)| {
        let (from, to) = (from as f32, to as f32);
        [[[from, margin], [to, margin]], [[margin, from], [margin, to]]]
    };
    let bars = LineStrips2D::new(runs.iter().flat_map(along))
        .with_class_ids(runs.iter().flat_map(|&(from, _)| [class_of(labels[from]); 2]))
        .with_show_labels(false);
    let exact = i32_vector(labels.iter().map(|label| label.map_or(-1, u32::cast_signed)), "return");
    rec.log("kmeans/labels", &[&exact as &dyn AsComponents, &bars])
}

/// Where each run of equal labels starts, and where the next one does.
fn runs(labels: &[Option<u32>]) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = 0;
    for run in labels.chunk_by(|a, b| a == b) {
        runs.push((start, start + run.len()));
        start += run.len();
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_all_labels_without_overlap() {
        let (a, b) = (Some(0), Some(1));
        assert_eq!(runs(&[a, a, b, None, None, a]), [(0, 2), (2, 3), (3, 5), (5, 6)]);
        assert_eq!(runs(&[]), []);
    }
}
