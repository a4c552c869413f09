//! Pieces of walls joined into walls.

use crosscut_scan::{LEAST_WALL_RETURNS, Pieces, Ring, mixed};

use super::judge::Judge;

/// A mixed return in an opening is off the lines of both walls by at least this.
const OFF_LINE_M: f64 = 0.2;

/// Joins neighbours at the least cost first, until a vehicle could pass between any two. Then the smallest piece that
/// is too small for a wall is taken out, its neighbours are joined if they can be, and so on. A wall that the end of
/// the view cuts may be longer than is seen, so [`LEAST_WALL_RETURNS`] are enough for it. A mixed return in an opening is
/// taken out before it would join the walls beside it. Returns what was taken out.
pub(super) fn join(judge: &mut Judge<'_>, pieces: &mut Pieces, least_returns: usize) -> Vec<usize> {
    let ring = &judge.context.scan.ring;
    let mut costs: Vec<f64> = (0..pieces.len()).map(|at| cost(judge, pieces, at)).collect();
    let mut left_over = Vec::new();
    loop {
        let (mut cheapest, mut least) = (None, f64::INFINITY);
        for (at, &cost) in costs.iter().enumerate() {
            if cost < least {
                (cheapest, least) = (Some(at), cost);
            }
        }
        let out = match cheapest {
            Some(at) => mixed_beside(judge, pieces, at),
            None => smallest(ring, pieces, least_returns),
        };
        let changed = if let Some(at) = out {
            left_over.extend(pieces.remove(at));
            costs.remove(at);
            at % pieces.len()
        } else if let Some(at) = cheapest {
            let next = pieces.next(at);
            pieces.join(at);
            costs.remove(next);
            if next < at { at - 1 } else { at }
        } else {
            return left_over;
        };
        costs[changed] = cost(judge, pieces, changed);
        let before = (changed + pieces.len() - 1) % pieces.len();
        costs[before] = cost(judge, pieces, before);
    }
}

/// The cost of joining a piece with the next; infinite where they cannot be joined.
fn cost(judge: &mut Judge<'_>, pieces: &Pieces, at: usize) -> f64 {
    let next = pieces.next(at);
    let is_gap = next != at && (judge.context.scan.ring.full_turn || next != 0);
    let cost = if is_gap { judge.cost(&pieces[at], &pieces[next]) } else { None };
    cost.unwrap_or(f64::INFINITY)
}

/// Of the two pieces at a gap, one that is a mixed return in an opening between its neighbours.
fn mixed_beside(judge: &mut Judge<'_>, pieces: &Pieces, gap: usize) -> Option<usize> {
    let (n, full_turn) = (pieces.len(), judge.context.scan.ring.full_turn);
    [gap, pieces.next(gap)].into_iter().find(|&at| {
        let is_amid = n > 2 && (full_turn || (at > 0 && at + 1 < n));
        let [lone] = pieces[at] else { return false };
        is_amid && is_mixed_in_opening(judge, &pieces[(at + n - 1) % n], lone, &pieces[pieces.next(at)])
    })
}

/// Whether a return between two pieces is a mixed one in an opening: by bearing, range and the lines of both pieces it is
/// of neither, and without it a vehicle could pass.
fn is_mixed_in_opening(judge: &mut Judge<'_>, a: &[usize], lone: usize, b: &[usize]) -> bool {
    let ring = &judge.context.scan.ring;
    let (p, q) = (a[a.len() - 1], b[0]);
    let [p_m, lone_m, q_m] = [p, lone, q].map(|i| ring.range_m(i));
    if ring.beams_from(p, q) != 2 || !mixed::is_between(p_m.min(q_m), lone_m, p_m.max(q_m)) {
        return false;
    }
    let [Some(before), Some(after)] = judge.directions(a, b) else { return false };
    let off_m = |from: usize, line| (ring.position_m(lone) - ring.position_m(from)).perp(&line).abs();
    off_m(p, before).min(off_m(q, after)) >= OFF_LINE_M && judge.room_ratio_of_opening(a, b).is_some()
}

/// The smallest of the pieces that are too small for a wall, of equal ones the farthest; `None` if it is the only
/// piece.
fn smallest(ring: &Ring, pieces: &Pieces, least_returns: usize) -> Option<usize> {
    let least = |piece: &[usize]| if ring.ends_with_view(piece) { LEAST_WALL_RETURNS } else { least_returns };
    let farther_end_m = |piece: &[usize]| ring.range_m(piece[0]).max(ring.range_m(piece[piece.len() - 1]));
    let small = (0..pieces.len()).filter(|&at| pieces.len() > 1 && pieces[at].len() < least(&pieces[at]));
    small.min_by(|&a, &b| {
        let farther_first = || farther_end_m(&pieces[b]).total_cmp(&farther_end_m(&pieces[a]));
        pieces[a].len().cmp(&pieces[b].len()).then_with(farther_first)
    })
}

/// Cuts walls where a vehicle can pass between all that is before a gap and all that is behind it: when the gap was
/// closed, one side of it was too short to have a direction, or to have the right one. Returns whether any was cut.
pub(super) fn cut_at_openings(judge: &mut Judge<'_>, walls: &mut Pieces) -> bool {
    let before = walls.len();
    let mut at = 0;
    while at < walls.len() {
        match widest_opening(judge, &walls[at]) {
            Some(cut) => walls.cut(at, cut),
            None => at += 1,
        }
    }
    walls.len() > before
}

/// Where in a wall there is the most room for an opening, with enough returns for a wall on both sides.
fn widest_opening(judge: &mut Judge<'_>, wall: &[usize]) -> Option<usize> {
    let context = judge.context;
    let places = LEAST_WALL_RETURNS..wall.len().saturating_sub(LEAST_WALL_RETURNS - 1);
    let gaps = places.filter(|&at| context.is_gap(wall[at - 1], wall[at]));
    let ways = gaps.filter_map(|at| Some((judge.room_ratio_of_opening(&wall[..at], &wall[at..])?, at)));
    ways.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at)
}
