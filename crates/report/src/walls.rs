//! Clusters -> walls.

use std::f64::consts::TAU;

use crosscut_stage::NoteCode::N083;
use crosscut_stage::{Junction, Notes, Partition, Revolution, Wall, counted};

/// Writes `out.walls` and `out.wall_of_return`: one wall per cluster of at least `min_returns` returns, numbered by
/// its first return.
pub(crate) fn from_partition(
    revolution: &Revolution,
    partition: &Partition,
    min_returns: usize,
    out: &mut Junction,
    notes: &mut Notes,
) {
    let mut returns_of_cluster = vec![0usize; partition.clusters];
    for label in partition.labels.iter().flatten() {
        returns_of_cluster[*label as usize] += 1;
    }
    // Clusters are numbered by their first return, so walls numbered in the order of clusters are too.
    out.walls.clear();
    let mut wall_of_cluster = vec![None; partition.clusters];
    for (cluster, &returns) in returns_of_cluster.iter().enumerate() {
        if returns >= min_returns {
            let id = out.walls.len() as u32;
            wall_of_cluster[cluster] = Some(id);
            out.walls.push(Wall { id, returns, bearing_rad: [0.0; 2], island: false });
        }
    }
    out.wall_of_return.clear();
    out.wall_of_return.extend(partition.labels.iter().map(|label| label.and_then(|c| wall_of_cluster[c as usize])));
    let dropped: usize = returns_of_cluster.iter().filter(|&&returns| returns < min_returns).sum();
    if dropped > 0 {
        let clusters = counted((partition.clusters - out.walls.len()) as u64, "cluster");
        let dropped = counted(dropped as u64, "return");
        notes.add(
            N083,
            format!("report: {clusters} too small to be a wall, of {dropped}; report.min_returns is {min_returns}"),
        );
    }
    set_bearings(revolution, out);
}

/// Gives each wall the smallest arc that holds all its returns, anticlockwise.
fn set_bearings(revolution: &Revolution, out: &mut Junction) {
    let returns = || revolution.points_m.iter().zip(&out.wall_of_return);
    for wall in &mut out.walls {
        let of_wall = returns().filter(|(_, of)| **of == Some(wall.id));
        wall.bearing_rad = arc(of_wall.map(|(point, _)| point.y.atan2(point.x)).collect());
    }
}

/// The arc is what remains of the circle when the widest gap between neighbouring bearings is left out.
fn arc(mut bearings_rad: Vec<f64>) -> [f64; 2] {
    bearings_rad.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (bearings_rad.first(), bearings_rad.last()) else { return [0.0; 2] };
    let mut widest = (first + TAU - last, [first, last]);
    for pair in bearings_rad.windows(2) {
        if pair[1] - pair[0] > widest.0 {
            widest = (pair[1] - pair[0], [pair[1], pair[0]]);
        }
    }
    widest.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    fn ring(bearings_deg: &[f64]) -> Revolution {
        let point = |deg: &f64| Point::new(deg.to_radians().cos(), deg.to_radians().sin(), 0.0);
        Revolution { points_m: bearings_deg.iter().map(point).collect(), ..Default::default() }
    }

    fn walls(bearings_deg: &[f64], labels: &[Option<u32>], min_returns: usize) -> (Junction, Notes) {
        let clusters = labels.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        let partition = Partition { clusters, labels: labels.to_vec(), ..Default::default() };
        let (mut junction, mut notes) = (Junction::default(), Notes::default());
        from_partition(&ring(bearings_deg), &partition, min_returns, &mut junction, &mut notes);
        (junction, notes)
    }

    #[test]
    fn bearings_run_anticlockwise_and_cross_pi_when_the_wall_does() {
        let labels = [Some(0), Some(1), Some(1), Some(0)];
        let (junction, _) = walls(&[-170.0, -20.0, 20.0, 170.0], &labels, 1);
        let degrees = |w: usize| junction.walls[w].bearing_rad.map(|b| b.to_degrees().round());
        assert_eq!(degrees(0), [170.0, -170.0], "crosses ±π: from > to");
        assert_eq!(degrees(1), [-20.0, 20.0]);
    }

    #[test]
    fn small_clusters_are_dropped_with_a_note_and_the_others_renumbered() {
        let labels = [Some(0), Some(1), Some(1), None];
        let (junction, notes) = walls(&[0.0, 90.0, 91.0, 180.0], &labels, 2);
        assert_eq!(junction.walls.len(), 1);
        assert_eq!(junction.wall_of_return, [None, Some(0), Some(0), None]);
        assert_eq!(
            notes.iter().collect::<Vec<_>>(),
            ["report: 1 cluster too small to be a wall, of 1 return; report.min_returns is 2"]
        );
        let (_, notes) = walls(&[0.0, 90.0, 180.0], &[Some(0), Some(1), Some(2)], 2);
        assert_eq!(
            notes.iter().collect::<Vec<_>>(),
            ["report: 3 clusters too small to be a wall, of 3 returns; report.min_returns is 2"]
        );
    }

    #[test]
    fn no_returns_no_walls() {
        assert!(walls(&[], &[], 1).0.walls.is_empty());
    }
}
