//! Ways on, from the clusters of directions; and the walls that a level vehicle sees between the level ones.

use crosscut_stage::{
    Beam, Dual, Measured, Partition, Point, Revolution, StageError, Sweep, Verdict, Way, WayKind, wrap_angle_rad,
};
use nalgebra::Vector3;

/// The ways, one of each cluster of directions, by bearing ascending. Where a cluster is not a way as the affinity joined it,
/// the direction is that of its rows, and the rest is that of the way of its first one.
///
/// # Errors
/// When there is not one label for each direction.
pub(crate) fn of_clusters(dual: &Dual, partition: &Partition) -> Result<Vec<Way>, StageError> {
    let (rows, labels): (Vec<_>, _) = (dual.rows().collect(), &partition.labels);
    if labels.len() != rows.len() {
        return Err(StageError::Mismatch(format!("labels: {}, directions: {}", labels.len(), rows.len())));
    }
    let clusters = labels.iter().flatten().max().map_or(0, |last| last + 1);
    let way = |cluster: u32| {
        let labelled = rows.iter().zip(labels).filter(|(_, label)| **label == Some(cluster));
        let of_cluster: Vec<(Vector3<f64>, u32)> = labelled.map(|(row, _)| *row).collect();
        let (_, of_row) = *of_cluster.first()?;
        let way = *dual.ways.get(of_row as usize)?;
        let whole = rows.iter().filter(|(_, of)| *of == of_row).count();
        if of_cluster.len() == whole && of_cluster.iter().all(|(_, of)| *of == of_row) {
            return Some(way);
        }
        let sum: Vector3<f64> = of_cluster.iter().map(|(towards, _)| towards).sum();
        Some(Way { direction: sum.try_normalize(0.0).unwrap_or(way.direction), ..way })
    };
    let mut ways: Vec<Way> = (0..clusters).filter_map(way).collect();
    ways.sort_by(|a, b| a.bearing_rad().total_cmp(&b.bearing_rad()));
    Ok(ways)
}

/// Where the level ways leave gaps among the returns of a sweep, and the clusters of returns between these gaps: the walls
/// that the report takes from here on.
pub(crate) fn level(
    ways: &[Way],
    dual: &Dual,
    revolution: &Revolution,
    sweep: Option<&Sweep>,
    vehicle_width_m: f64,
) -> (Vec<Verdict>, Partition) {
    let (n, view) = (revolution.len(), sweep.map(Sweep::view));
    let mut partition = Partition { clusters: n.min(1), labels: vec![Some(0); n], ..Partition::default() };
    let Some((sweep, view)) = sweep.zip(view) else { return (Vec::new(), partition) };
    let returns: Vec<u32> = sweep
        .anticlockwise(view)
        .filter_map(|beam| if let Beam::Return(number) = beam { Some(number) } else { None })
        .collect();
    let last = if view.full_turn { returns.len() } else { returns.len().saturating_sub(1) };
    let place_m = |at: usize| revolution.points_m[returns[at % returns.len()] as usize];
    let mut gaps: Vec<(usize, &Way)> = ways
        .iter()
        .filter(|way| way.kind() == WayKind::Level)
        .filter_map(|way| {
            let half_rad = half_width_rad(way, dual);
            let widest = (0..last).filter(|at| looks_at(way.bearing_rad(), half_rad, place_m(*at), place_m(at + 1)));
            let width_m = |at: &usize| (place_m(*at) - place_m(at + 1)).norm();
            let at = widest.max_by(|a, b| width_m(a).total_cmp(&width_m(b)))?;
            (width_m(&at) >= vehicle_width_m).then_some((at, way))
        })
        .collect();
    gaps.sort_by_key(|(at, _)| *at);
    gaps.dedup_by_key(|(at, _)| *at);
    let starts: Vec<usize> = gaps.iter().map(|(at, _)| at + 1).collect();
    for (at, number) in returns.iter().enumerate() {
        let before = starts.iter().filter(|start| **start <= at).count();
        // In a full turn, what follows the last gap is the wall before the first one.
        let wraps = view.full_turn && before == starts.len();
        partition.labels[*number as usize] = Some(if wraps { 0 } else { before as u32 });
    }
    // Clusters are numbered by their first return, whatever the order of the beams.
    let mut numbers: Vec<u32> = Vec::new();
    for label in partition.labels.iter_mut().flatten() {
        let number = numbers.iter().position(|known| known == label).unwrap_or_else(|| {
            numbers.push(*label);
            numbers.len() - 1
        });
        *label = number as u32;
    }
    partition.clusters = numbers.len();
    let verdicts = gaps.iter().map(|(at, way)| Verdict {
        returns: [*at, at + 1].map(|at| returns[at % returns.len()]),
        is_opening: true,
        room_ratio: way.clearance_m / vehicle_width_m,
        p: Some(way.p),
        reason: "way on",
        measured: Some(Measured::metres(
            "the largest ball that passes is",
            way.clearance_m,
            "the vehicle needs",
            vehicle_width_m,
        )),
    });
    (verdicts.collect(), partition)
}

/// Half of the angle that the rows of a way take up, seen from above.
fn half_width_rad(way: &Way, dual: &Dual) -> f64 {
    let of_way = dual.rows().filter(|(_, of)| dual.ways.get(*of as usize) == Some(way)).map(|(towards, _)| towards);
    let off_rad = of_way.map(|towards| wrap_angle_rad(towards.y.atan2(towards.x) - way.bearing_rad()).abs());
    off_rad.fold(0.05, f64::max).min(1.2)
}

/// Whether the gap between two returns reaches into a sector.
fn looks_at(bearing_rad: f64, half_rad: f64, from_m: Point, to_m: Point) -> bool {
    let [from_rad, to_rad] = [from_m, to_m].map(|end_m| wrap_angle_rad(end_m.y.atan2(end_m.x) - bearing_rad));
    let gap_rad = (to_rad - from_rad).rem_euclid(std::f64::consts::TAU);
    from_rad.abs() <= half_rad || to_rad.abs() <= half_rad || (from_rad < 0.0 && from_rad + gap_rad > 0.0)
}
