//! The walls of a cloud: those that a level vehicle sees, carried on to the returns that it does not see.

use std::f64::consts::TAU;
use std::ops::Range;

use crosscut_stage::{Affinity, LevelReturn, LevelView, Revolution, Weights};
use nalgebra::Vector2;

/// Unseen returns are coarsened to so much of a vehicle's width.
const SPACING: f64 = 0.25;
/// Of a return that is not level.
const NONE: u32 = u32::MAX;

/// A return and what it weighs to be tied to it.
type Tie = (u32, f64);

/// W of a cloud, from that of what is seen of it; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Carrying {
    /// By beam, those of a beam by range.
    representatives: Vec<Representative>,
    /// Where those of each beam start, and the end.
    starts: Vec<usize>,
    /// The representative of each return of the cloud.
    of_return: Vec<u32>,
    /// That of each return that is seen.
    of_seen: Vec<u32>,
    open: Vec<u32>,
    /// The rows of the representatives, columns by numbers of the cloud.
    rows: Vec<Vec<Tie>>,
}

/// A level return that stands for those near it.
#[derive(Clone, Copy, Debug)]
struct Representative {
    place_m: Vector2<f64>,
    level: LevelReturn,
    /// Its number among those that are seen.
    seen: Option<u32>,
    /// The representative from which a wall was carried on to it, in how many steps from what is seen of that.
    carried_from: Option<u32>,
    steps: u32,
    /// The two nearest of the representatives that it is tied to, if there are any.
    nearest: [Option<Tie>; 2],
}

impl Carrying {
    /// Writes W of `cloud` into `out`. `seen` is the graph of `view.seen()`.
    ///
    /// 1. The level returns of each beam are coarsened: walking outward, each is represented by the last representative
    ///    that is no more than a quarter of `passage_m` before it, and is one if there is none. All that are seen
    ///    represent themselves.
    /// 2. From what is seen of a wall, the wall is carried on to representatives within `passage_m`, nearest in steps
    ///    first: each is tied to the one that it was reached from, of several the nearest, so that nothing unseen joins
    ///    two walls.
    /// 3. Each other level return is tied to its representative, and to the two nearest of those that this one is tied
    ///    to. So what ties the parts of a wall grows with its number of returns as the parts do, and the second
    ///    eigenvalue of its block does not fall with it.
    ///
    /// What is not level, or not reached, is tied to nothing.
    pub(super) fn write(
        &mut self,
        cloud: &Revolution,
        view: &LevelView,
        seen: &Affinity,
        passage_m: f64,
        out: &mut Affinity,
    ) {
        self.coarsen(cloud, view, SPACING * passage_m);
        self.carry(seen, view.beams(), passage_m);
        self.tie_representatives(seen);
        self.tie_others();
        self.write_rows(out);
    }

    fn coarsen(&mut self, cloud: &Revolution, view: &LevelView, spacing_m: f64) {
        let Self { representatives, starts, of_return, of_seen, .. } = self;
        representatives.clear();
        starts.clear();
        of_return.clear();
        of_return.resize(cloud.len(), NONE);
        of_seen.clear();
        for level in view.level() {
            let is_seen = view.numbers().get(of_seen.len()) == Some(&level.number);
            let stands_for = |last: &Representative| {
                last.level.beam == level.beam && level.range_m <= last.level.range_m + spacing_m
            };
            if is_seen || !representatives.last().is_some_and(stands_for) {
                starts.resize(level.beam as usize + 1, representatives.len());
                representatives.push(Representative {
                    place_m: cloud.points_m[level.number as usize].coords.xy(),
                    level: *level,
                    seen: is_seen.then_some(of_seen.len() as u32),
                    carried_from: None,
                    steps: 0,
                    nearest: [None; 2],
                });
            }
            let representative = representatives.len() as u32 - 1;
            of_return[level.number as usize] = representative;
            if is_seen {
                of_seen.push(representative);
            }
        }
        starts.resize(view.beams() + 1, representatives.len());
    }

    /// Sets `carried_from`, breadth first from the seen returns that have an edge; of those that reach it in as few steps,
    /// the nearest, so that the mirror image of a cloud has the same walls.
    fn carry(&mut self, seen: &Affinity, beams: usize, passage_m: f64) {
        let Self { representatives, starts, of_seen, open, .. } = self;
        let is_of_wall = |one: &Representative| one.seen.is_some_and(|seen_at| seen.degrees[seen_at as usize] > 1.0);
        open.clear();
        open.extend(of_seen.iter().filter(|&&at| is_of_wall(&representatives[at as usize])));
        let mut next = 0;
        while let Some(&from) = open.get(next) {
            next += 1;
            let Representative { place_m, level, steps, .. } = representatives[from as usize];
            for stretch in beams_within(passage_m, level, beams).map(|beams| starts[beams.start]..starts[beams.end]) {
                for at in stretch {
                    let to = representatives[at];
                    let squared = (to.place_m - place_m).norm_squared();
                    let is_nearer = |other: u32| {
                        let other_squared = (to.place_m - representatives[other as usize].place_m).norm_squared();
                        to.steps == steps + 1 && squared < other_squared
                    };
                    if squared <= passage_m * passage_m && to.seen.is_none() && to.carried_from.is_none_or(is_nearer) {
                        representatives[at].carried_from = Some(from);
                        representatives[at].steps = steps + 1;
                        if to.carried_from.is_none() {
                            open.push(at as u32);
                        }
                    }
                }
            }
        }
    }

    /// Writes what representatives are tied to among themselves into `rows`, and sets `nearest`.
    fn tie_representatives(&mut self, seen: &Affinity) {
        let Self { representatives, of_seen, rows, .. } = self;
        rows.iter_mut().for_each(Vec::clear);
        rows.resize_with(representatives.len().max(rows.len()), Vec::new);
        let mut ties: Vec<Tie> = Vec::new();
        for at in 0..representatives.len() {
            let Representative { level, seen: seen_at, carried_from, .. } = representatives[at];
            ties.clear();
            let along = seen_at.into_iter().flat_map(|i| row(seen, i as usize));
            ties.extend(along.map(|(j, weight)| (of_seen[j as usize], weight)).filter(|&(j, _)| j as usize != at));
            if let Some(from) = carried_from {
                ties.push((from, 1.0));
                rows[from as usize].push((level.number, 1.0));
            }
            rows[at].push((level.number, 1.0));
            rows[at].extend(ties.iter().map(|&(j, weight)| (representatives[j as usize].level.number, weight)));
            representatives[at].nearest = nearest_two(representatives, at, &ties);
        }
    }

    /// Adds the returns that are represented by another one to `rows`.
    fn tie_others(&mut self) {
        let Self { representatives, of_return, rows, .. } = self;
        for (i, &at) in (0..).zip(&*of_return) {
            let Some(one) = representatives.get(at as usize).filter(|one| one.level.number != i) else { continue };
            for (j, weight) in ties_through(at, one) {
                rows[j as usize].push((i, weight));
            }
        }
    }

    fn write_rows(&mut self, out: &mut Affinity) {
        let Self { representatives, of_return, rows, .. } = self;
        let csr = out.weights.make_sparse();
        let mut other: Vec<Tie> = Vec::new();
        for (i, &at) in (0..).zip(&*of_return) {
            let row = match representatives.get(at as usize) {
                Some(one) if one.level.number == i => &mut rows[at as usize],
                represented => {
                    let ties = represented.into_iter().flat_map(|one| ties_through(at, one));
                    other.clear();
                    other.push((i, 1.0));
                    other.extend(ties.map(|(j, weight)| (representatives[j as usize].level.number, weight)));
                    &mut other
                }
            };
            // Those that were added last, most of all, ascend already.
            row.sort_by_key(|&(column, _)| column);
            row.iter().for_each(|&(column, weight)| csr.push(column, weight));
            csr.end_row();
        }
    }
}

/// What a return is tied to that is represented by the one at `at`: nothing, if that is not of a wall.
fn ties_through(at: u32, representative: &Representative) -> impl Iterator<Item = Tie> {
    let nearest = representative.nearest;
    let itself = nearest[0].map(|_| (at, 1.0));
    itself.into_iter().chain(nearest.into_iter().flatten())
}

/// The beams in which all places lie that are no farther than `reach_m` from a return; in two stretches over the last
/// beam.
fn beams_within(reach_m: f64, of: LevelReturn, beams: usize) -> [Range<usize>; 2] {
    let (beam, step_rad) = (of.beam as usize, TAU / beams as f64);
    let spread_rad = if of.range_m > reach_m { (reach_m / of.range_m).asin() } else { TAU };
    let spread = (spread_rad / step_rad) as usize + 1;
    match (beam.checked_sub(spread), beam + spread + 1) {
        _ if 2 * spread >= beams => [0..beams, 0..0],
        (None, end) => [0..end, beam + beams - spread..beams],
        (Some(start), end) if end > beams => [0..end - beams, start..beams],
        (Some(start), end) => [start..end, 0..0],
    }
}

/// The entries of row `i` of the seen graph.
fn row(seen: &Affinity, i: usize) -> impl Iterator<Item = Tie> {
    let (columns, weights) = match &seen.weights {
        Weights::Sparse(w) => w.row(i),
        _ => (&[][..], &[][..]),
    };
    columns.iter().copied().zip(weights.iter().copied())
}

/// The two of `ties` that are nearest to the representative at `at`, the first of equals.
fn nearest_two(representatives: &[Representative], at: usize, ties: &[Tie]) -> [Option<Tie>; 2] {
    let place_m = |at: usize| representatives[at].place_m;
    let mut nearest = [(f64::INFINITY, None); 2];
    for &tie in ties {
        let found = ((place_m(tie.0 as usize) - place_m(at)).norm_squared(), Some(tie));
        if found.0 < nearest[0].0 {
            nearest = [found, nearest[0]];
        } else if found.0 < nearest[1].0 {
            nearest[1] = found;
        }
    }
    nearest.map(|(_, tie)| tie)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_within_reach_lies_in_another_beam() {
        let reach_m = 0.6;
        for (beams, range_m) in [1, 2, 3, 50, 720].into_iter().flat_map(|beams| [0.4, 0.7, 5.0].map(|m| (beams, m))) {
            for beam in 0..beams {
                let stretches = beams_within(reach_m, LevelReturn { number: 0, beam: beam as u32, range_m }, beams);
                assert!(stretches.iter().map(Range::len).sum::<usize>() <= beams, "none twice");
                for other in (0..beams).filter(|other| !stretches.iter().any(|stretch| stretch.contains(other))) {
                    // From the end of one beam to the nearest place in that of the other.
                    let least_apart = other.abs_diff(beam).min(beams - other.abs_diff(beam)) - 1;
                    let (sin, cos) = (TAU * least_apart as f64 / beams as f64).sin_cos();
                    let least_m = if cos > 0.0 { range_m * sin } else { range_m };
                    assert!(least_m > reach_m, "{beam} and {other} of {beams} at {range_m} m");
                }
            }
        }
    }
}
