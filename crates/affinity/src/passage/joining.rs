//! Pieces of walls joined into walls.

use std::f64::consts::PI;

use super::gap::Judge;
use super::pieces::Pieces;
use super::ring::Ring;

/// Pieces of fewer returns are no wall.
pub(super) const LEAST_RETURNS: usize = 3;
/// A wall that turns left by this much, seen over [`PEAK_STRETCH_M`] on both sides of a gap, is two. In a narrow place it is
/// seen over so many times its size: the end of a narrow tunnel turns as much within a few metres.
const PEAK_RAD: std::ops::Range<f64> = 140.0 * PI / 180.0..250.0 * PI / 180.0;
const PEAK_STRETCH_M: f64 = 4.0;
const PEAK_STRETCH_SHARE: f64 = 2.0;

/// Writes the ring of the `kept` returns into `pieces`, cut where two that follow each other are a passage apart.
pub(super) fn cut_ring(ring: &Ring, kept: impl Iterator<Item = usize>, passage_m: f64, pieces: &mut Pieces) {
    pieces.clear();
    let is_apart = |from: usize, to: usize| ring.are_apart(from, to, passage_m);
    for i in kept {
        let starts_piece = pieces.returns().last().is_none_or(|&last| is_apart(last, i));
        pieces.push(i, starts_piece);
    }
    if let [first, .., last] = *pieces.returns()
        && pieces.len() > 1
        && ring.full_turn
        && !is_apart(last, first)
    {
        pieces.join(pieces.len() - 1);
    }
}

/// Joins neighbours at the least cost first, until a vehicle could pass between any two. What is then too small to be a
/// wall is taken out, smallest first, and what is beside it is looked at again; how large a wall is that the end of the
/// view cuts is not known, so it counts from [`LEAST_RETURNS`] on. Returns what was taken out.
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
        let changed = if let Some(at) = cheapest {
            let next = (at + 1) % n;
            pieces.join(at);
            costs.remove(next);
            if next < at { at - 1 } else { at }
        } else {
            let Some(at) = smallest(ring, pieces, least_returns) else { return left_over };
            left_over.extend(pieces.remove(at));
            costs.remove(at);
            at % pieces.len()
        };
        let before = (changed + pieces.len() - 1) % pieces.len();
        costs[changed] = gap(pieces, changed);
        costs[before] = gap(pieces, before);
    }
}

/// Takes out what is too small to be a wall, smallest first, and does not join what is beside it.
pub(super) fn drop_small(ring: &Ring, pieces: &mut Pieces, least_returns: usize, left_over: &mut Vec<usize>) {
    while let Some(at) = smallest(ring, pieces, least_returns) {
        left_over.extend(pieces.remove(at));
    }
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

/// Cuts walls that go out on one side of a way and come back on the other: at an opening a wall turns around, whatever
/// a stray return in it suggests. It does so at a dead end as well if its end wall is hidden, or short: where lost beams
/// or islands hide what there is, or nothing is hidden, it is not cut.
pub(super) fn cut_at_peaks(judge: &Judge<'_>, walls: &mut Pieces) {
    cut(walls, |wall| sharpest_peak(judge, wall));
}

/// Cuts walls where a vehicle can pass between all that is before a gap and all that is behind it: the gap was closed
/// while one side of it was too short to have a direction, or to have the right one. Whether any was cut.
pub(super) fn cut_at_ways(judge: &Judge<'_>, walls: &mut Pieces) -> bool {
    let before = walls.len();
    cut(walls, |wall| widest_way(judge, wall));
    walls.len() > before
}

/// Cuts walls where `place` says, until it finds no more.
fn cut(walls: &mut Pieces, place: impl Fn(&[usize]) -> Option<usize>) {
    let mut at = 0;
    while at < walls.len() {
        match place(&walls[at]) {
            Some(cut) => walls.cut(at, cut),
            None => at += 1,
        }
    }
}

/// Where a wall has a gap, with enough returns for a wall on both sides.
fn gaps(judge: &Judge<'_>, wall: &[usize]) -> impl Iterator<Item = usize> {
    let places = LEAST_RETURNS..wall.len().saturating_sub(LEAST_RETURNS - 1);
    places.filter(|&at| judge.is_gap(wall[at - 1], wall[at]))
}

fn widest_way(judge: &Judge<'_>, wall: &[usize]) -> Option<usize> {
    let ways = gaps(judge, wall).filter_map(|at| Some((judge.room_ratio_of_way(&wall[..at], &wall[at..])?, at)));
    ways.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at)
}

fn sharpest_peak(judge: &Judge<'_>, wall: &[usize]) -> Option<usize> {
    let stretch_m = PEAK_STRETCH_M.min(PEAK_STRETCH_SHARE * judge.size_m);
    let mut sharpest = None;
    let mut least_rad = PEAK_RAD.start;
    for cut in gaps(judge, wall) {
        let (a, b) = wall.split_at(cut);
        if judge.is_hidden((a[cut - 1], b[0])) || !judge.may_turn_around(a, b) {
            continue;
        }
        let turn_rad = judge.turns_over_rad(a, b, stretch_m).iter().sum();
        if (least_rad..PEAK_RAD.end).contains(&turn_rad) {
            (least_rad, sharpest) = (turn_rad, Some(cut));
        }
    }
    sharpest
}
