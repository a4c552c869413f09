//! Clusters: the label of each return, and the centroids among the rows of U.

use crosscut_stage::{Frame, Partition, Weights};
use rerun::{LineStrips2D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::beam_order::BeamOrder;
use crate::colors::NO_WALL;
use crate::rows::Rows;
use crate::schema::{KMEANS_BLOCKS, KMEANS_CENTROIDS, KMEANS_LABELS};
use crate::spectrum::drawn_row;
use crate::tensors::{f64_rows, i32_vector};
use crate::tracks::Classes;

/// A bar is drawn across gaps of fewer beams without a return than this.
const GAP: usize = 4;
/// Blocks of W that cover a smaller share of its side have no frame.
const BLOCK_SHARE: f64 = 0.03;

/// Lines of a hatched block, if it covers the whole side.
const HATCHES: usize = 60;

/// Look of the entities.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let lines = |radius| LineStrips2D::update_fields().with_radii([ui(radius)]).with_show_labels(false);
    rec.log_static(KMEANS_LABELS.path, &lines(4.0))?;
    rec.log_static(KMEANS_BLOCKS.path, &lines(1.0))?;
    rec.log_static(KMEANS_CENTROIDS.path, &Points3D::update_fields().with_radii([ui(7.0)]).with_show_labels(false))
}

/// Labels and centroids of one revolution, the centroids drawn at the embedding's `scale`.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, order: &BeamOrder, classes: &Classes, scale: f64) {
    let partition = &frame.partition;
    log_labels(rows, partition, order, classes);
    let centroids = &partition.centroids;
    let clusters = centroids.nrows();
    let points = Points3D::new((0..clusters).map(|c| drawn_row(centroids, c, scale)))
        .with_class_ids((0..clusters).map(|c| classes.of_cluster(u32::try_from(c).ok())));
    let exact = f64_rows(centroids, KMEANS_CENTROIDS.dims);
    rows.log_tensor(&KMEANS_CENTROIDS, exact, &[&points]);
}

/// The labels, -1 for a return that was left out, and the clusters as bars along the sides of W.
fn log_labels(rows: &mut Rows, partition: &Partition, order: &BeamOrder, classes: &Classes) {
    let margin = -0.025 * order.used as f32;
    let clusters: Vec<u16> = partition.labels.iter().map(|label| classes.of_cluster(*label)).collect();
    let runs = runs(&clusters, &order.places, order.pixels);
    let along = |&(_, from, to): &(u16, usize, usize)| {
        let (from, to) = (from as f32, to as f32);
        [[[from, margin], [to, margin]], [[margin, from], [margin, to]]]
    };
    let bars =
        LineStrips2D::new(runs.iter().flat_map(along)).with_class_ids(runs.iter().flat_map(|&(class, ..)| [class; 2]));
    let exact = i32_vector(partition.labels.iter().map(|label| label.map_or(-1, u32::cast_signed)), KMEANS_LABELS.dims);
    rows.log_tensor(&KMEANS_LABELS, exact, &[&bars]);
}

/// Frames around the blocks of the walls on the diagonal of W. Those of a sparse W are hatched: its entries are too few to
/// be seen.
pub(crate) fn log_blocks(rows: &mut Rows, frame: &Frame, order: &BeamOrder, classes: &Classes) {
    let large = |&&(class, from, to): &&(u16, usize, usize)| {
        class != NO_WALL && (to - from) as f64 >= BLOCK_SHARE * order.used as f64
    };
    let is_sparse = matches!(frame.affinity.weights, Weights::Sparse(_));
    let runs = runs(classes.of_rows(), &order.places, order.pixels);
    let (frames, colors): (Vec<_>, Vec<_>) = (runs.iter().filter(large))
        .map(|&(class, from, to)| {
            let (from, to) = (from as f32, to as f32);
            let mut block = vec![[from, from], [to, from], [to, to], [from, to], [from, from]];
            if is_sparse {
                let teeth = (from as usize..to as usize).step_by(order.used.div_ceil(HATCHES).max(1));
                block.extend(
                    teeth
                        .flat_map(|x| [x as f32; 2].map(|x| [x, from]))
                        .enumerate()
                        .map(|(at, [x, top])| if matches!(at % 4, 1 | 2) { [x, x] } else { [x, top] }),
                );
            }
            (block, class)
        })
        .unzip();
    rows.log(&KMEANS_BLOCKS, &LineStrips2D::new(frames).with_class_ids(colors));
}

/// Class, first place and place after the last of each run of equal classes; each class takes `pixels` places. Gaps of [`GAP`]
/// places or more end a run.
pub(crate) fn runs(classes: &[u16], places: &[usize], pixels: usize) -> Vec<(u16, usize, usize)> {
    let placed: Vec<(u16, usize)> = classes.iter().copied().zip(places.iter().copied()).collect();
    let joined = |a: &(u16, usize), b: &(u16, usize)| a.0 == b.0 && b.1 - a.1 <= GAP.max(pixels);
    placed.chunk_by(joined).map(|run| (run[0].0, run[0].1, run[run.len() - 1].1 + pixels)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_end_at_another_class_and_at_gaps() {
        let (a, b) = (0, 1);
        let runs = |classes: &[u16], places: &[usize]| runs(classes, places, 1);
        let expected = [(0, 2, 4), (1, 4, 5), (NO_WALL, 5, 6), (0, 6, 7)];
        assert_eq!(runs(&[a, a, b, NO_WALL, a], &[2, 3, 4, 5, 6]), expected);
        assert_eq!(runs(&[a, a, a], &[0, 2, 30]), [(0, 0, 3), (0, 30, 31)]);
        assert_eq!(runs(&[], &[]), []);
        assert_eq!(runs(&[a], &[]), [], "classes without returns make no run");
    }
}
