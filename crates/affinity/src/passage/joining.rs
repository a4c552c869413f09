//! Pieces of walls joined into walls.

use super::gap::Judge;
use super::mixed;
use super::pieces::Pieces;
use super::ring::Ring;

/// Pieces of fewer returns are no wall, and no island.
pub(super) const LEAST_RETURNS: usize = 3;

/// Joins neighbours at the least cost first, until a vehicle could pass between any two. What is then too small to be a
/// wall is taken out, smallest first, and what is beside it is looked at again; how large a wall is that the end of the
/// view cuts is not known, so it counts from [`LEAST_RETURNS`] on. A mixed return in a way on is taken out before it joins
/// the walls beside it. Returns what was taken out.
pub(super) fn join(ring: &Ring, judge: &Judge<'_>, pieces: &mut Pieces, least_returns: usize) -> Vec<usize> {
    let gap = |pieces: &Pieces, at: usize| {
        let next = (at + 1) % pieces.len();
        let is_gap = next != at && (ring.full_turn || next != 0);
        let cost = if is_gap { judge.cost(&pieces[at], &pieces[next]) } else { None };
        cost.unwrap_or(f64::INFINITY)
    };
    let mut costs: Vec<f64> = (0..pieces.len()).map(|at| gap(pieces, at)).collect();
    let mut left_over = Vec::new();
    loop {
        let n = pieces.len();
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
            let next = (at + 1) % n;
            pieces.join(at);
            costs.remove(next);
            if next < at { at - 1 } else { at }
        } else {
            return left_over;
        };
        let before = (changed + pieces.len() - 1) % pieces.len();
        costs[changed] = gap(pieces, changed);
        costs[before] = gap(pieces, before);
    }
}

/// Of the two pieces at a gap, one that is a mixed return in a way on between those beside it.
fn mixed_beside(judge: &Judge<'_>, pieces: &Pieces, gap: usize) -> Option<usize> {
    let n = pieces.len();
    [gap, (gap + 1) % n].into_iter().find(|&at| {
        let is_amid = n > 2 && (judge.ring.full_turn || (at > 0 && at + 1 < n));
        let [lone] = pieces[at] else { return false };
        is_amid && mixed::is_in_way(judge, &pieces[(at + n - 1) % n], lone, &pieces[(at + 1) % n])
    })
}

/// The smallest of the pieces that are too small to be a wall, of equal ones the farthest; none if it is the only piece.
fn smallest(ring: &Ring, pieces: &Pieces, least_returns: usize) -> Option<usize> {
    let least = |piece: &[usize]| if ring.ends_with_view(piece) { LEAST_RETURNS } else { least_returns };
    let farther_end_m = |piece: &[usize]| ring.range_m(piece[0]).max(ring.range_m(piece[piece.len() - 1]));
    let small = (0..pieces.len()).filter(|&at| pieces.len() > 1 && pieces[at].len() < least(&pieces[at]));
    small.min_by(|&a, &b| {
        let farther_first = || farther_end_m(&pieces[b]).total_cmp(&farther_end_m(&pieces[a]));
        pieces[a].len().cmp(&pieces[b].len()).then_with(farther_first)
    })
}

/// Cuts walls where a vehicle can pass between all that is before a gap and all that is behind it: the gap was closed
/// while one side of it was too short to have a direction, or to have the right one. Whether any was cut.
pub(super) fn cut_at_ways(judge: &Judge<'_>, walls: &mut Pieces) -> bool {
    let before = walls.len();
    let mut at = 0;
    while at < walls.len() {
        match widest_way(judge, &walls[at]) {
            Some(cut) => walls.cut(at, cut),
            None => at += 1,
        }
    }
    walls.len() > before
}

/// Where in a wall there is the most room for a way on, with enough returns for a wall on both sides.
fn widest_way(judge: &Judge<'_>, wall: &[usize]) -> Option<usize> {
    let places = LEAST_RETURNS..wall.len().saturating_sub(LEAST_RETURNS - 1);
    let gaps = places.filter(|&at| judge.is_gap(wall[at - 1], wall[at]));
    let ways = gaps.filter_map(|at| Some((judge.room_ratio_of_way(&wall[..at], &wall[at..])?, at)));
    ways.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at)
}
