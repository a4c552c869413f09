//! The walls of a cloud: those that a level vehicle sees, carried on to the returns that it does not see.

use std::f64::consts::TAU;
use std::ops::Range;

use crosscut_scan::{LevelReturn, LevelView};
use crosscut_stage::{Affinity, Revolution, Weights};
use nalgebra::Vector2;

/// The spacing to which unseen returns are coarsened, as a share of the vehicle's width.
const SPACING_SHARE: f64 = 0.25;
/// Stands for the representative of a return that is not level.
const NONE: u32 = u32::MAX;

/// A return at the other end of an edge, and the weight of the edge.
type Edge = (u32, f64);

/// Makes W of a cloud from W of the returns that are seen; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Carrying {
    /// Sorted by beam, those of a beam by range.
    representatives: Vec<Representative>,
    /// Where the representatives of each beam start, and the end of the last.
    starts: Vec<usize>,
    /// The representative of each return of the cloud.
    of_return: Vec<u32>,
    /// The representative of each return that is seen.
    of_seen: Vec<u32>,
    /// Those from which walls are still carried on.
    open: Vec<u32>,
    /// The rows of the representatives, columns by numbers of the cloud.
    rows: Vec<Vec<Edge>>,
}

/// A level return that represents those near it.
#[derive(Clone, Copy, Debug)]
struct Representative {
    place_m: Vector2<f64>,
    level: LevelReturn,
    /// Its number among the returns that are seen.
    seen: Option<u32>,
    /// The representative from which a wall was carried on to it.
    carried_from: Option<u32>,
    /// In how many steps from a return that is seen.
    steps: u32,
    /// The edges to the two nearest of the representatives that it has edges to.
    nearest: [Option<Edge>; 2],
}

impl Carrying {
    /// Writes W of `cloud` into `out`. `seen` is the graph of `view.seen()`.
    ///
    /// 1. The level returns of each beam are coarsened. Walking outward, a return is represented by the last
    ///    representative if that is no more than a quarter of `passage_m` before it; otherwise it becomes one. All
    ///    returns that are seen represent themselves.
    /// 2. Walls are carried on, from the returns of them that are seen, to representatives within `passage_m`, in the
    ///    fewest steps. Each has an edge to the one that it was reached from, the nearest of several, so that nothing
    ///    unseen joins two walls.
    /// 3. Each other level return has edges to its representative, and to the two nearest of those that this one has
    ///    edges to. So the edges between the parts of a wall grow in number as the parts do, and the second eigenvalue
    ///    of its block does not fall with the number of returns.
    ///
    /// A return that is not level, or not reached, has no edge.
    pub(super) fn write(
        &mut self,
        cloud: &Revolution,
        view: &LevelView,
        seen: &Affinity,
        passage_m: f64,
        out: &mut Affinity,
    ) {
        self.coarsen(cloud, view, SPACING_SHARE * passage_m);
        self.carry(seen, view.beams(), passage_m);
        self.connect_representatives(seen);
        self.connect_others();
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

    /// Sets `carried_from`, breadth first from the seen returns that have an edge. Of those that reach a representative
    /// in equally many steps the nearest is taken, so that the mirror image of a cloud has the same walls.
    fn carry(&mut self, seen: &Affinity, beams: usize, passage_m: f64) {
        let Self { representatives, starts, of_seen, open, .. } = self;
        let has_edge = |one: &Representative| one.seen.is_some_and(|seen_at| seen.degrees[seen_at as usize] > 1.0);
        open.clear();
        open.extend(of_seen.iter().filter(|&&at| has_edge(&representatives[at as usize])));
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

    /// Writes the edges between representatives into `rows`, and sets `nearest`.
    fn connect_representatives(&mut self, seen: &Affinity) {
        let Self { representatives, of_seen, rows, .. } = self;
        rows.iter_mut().for_each(Vec::clear);
        rows.resize_with(representatives.len().max(rows.len()), Vec::new);
        let mut edges: Vec<Edge> = Vec::new();
        for at in 0..representatives.len() {
            let Representative { level, seen: seen_at, carried_from, .. } = representatives[at];
            edges.clear();
            let along = seen_at.into_iter().flat_map(|i| row(seen, i as usize));
            edges.extend(along.map(|(j, weight)| (of_seen[j as usize], weight)).filter(|&(j, _)| j as usize != at));
            if let Some(from) = carried_from {
                edges.push((from, 1.0));
                rows[from as usize].push((level.number, 1.0));
            }
            rows[at].push((level.number, 1.0));
            rows[at].extend(edges.iter().map(|&(j, weight)| (representatives[j as usize].level.number, weight)));
            representatives[at].nearest = nearest_two(representatives, at, &edges);
        }
    }

    /// Adds to `rows` the edges to returns that another one represents.
    fn connect_others(&mut self) {
        let Self { representatives, of_return, rows, .. } = self;
        for (i, &at) in (0..).zip(&*of_return) {
            let Some(one) = representatives.get(at as usize).filter(|one| one.level.number != i) else { continue };
            for (j, weight) in edges_through(at, one) {
                rows[j as usize].push((i, weight));
            }
        }
    }

    fn write_rows(&mut self, out: &mut Affinity) {
        let Self { representatives, of_return, rows, .. } = self;
        let csr = out.weights.make_sparse();
        let mut other: Vec<Edge> = Vec::new();
        for (i, &at) in (0..).zip(&*of_return) {
            let row = match representatives.get(at as usize) {
                Some(one) if one.level.number == i => &mut rows[at as usize],
                represented => {
                    let edges = represented.into_iter().flat_map(|one| edges_through(at, one));
                    other.clear();
                    other.push((i, 1.0));
                    other.extend(edges.map(|(j, weight)| (representatives[j as usize].level.number, weight)));
                    &mut other
                }
            };
            // Most entries are of `connect_others` and ascend already.
            row.sort_by_key(|&(column, _)| column);
            row.iter().for_each(|&(column, weight)| csr.push(column, weight));
            csr.end_row();
        }
    }
}

/// The edges of a return that the representative at `at` represents; none if that is not of a wall.
fn edges_through(at: u32, representative: &Representative) -> impl Iterator<Item = Edge> {
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
fn row(seen: &Affinity, i: usize) -> impl Iterator<Item = Edge> {
    let (columns, weights) = match &seen.weights {
        Weights::Sparse(w) => w.row(i),
        _ => (&[][..], &[][..]),
    };
    columns.iter().copied().zip(weights.iter().copied())
}

/// The two of `edges` that are nearest to the representative at `at`, the first of equals.
fn nearest_two(representatives: &[Representative], at: usize, edges: &[Edge]) -> [Option<Edge>; 2] {
    let place_m = |at: usize| representatives[at].place_m;
    let mut nearest = [(f64::INFINITY, None); 2];
    for &edge in edges {
        let found = ((place_m(edge.0 as usize) - place_m(at)).norm_squared(), Some(edge));
        if found.0 < nearest[0].0 {
            nearest = [found, nearest[0]];
        } else if found.0 < nearest[1].0 {
            nearest[1] = found;
        }
    }
    nearest.map(|(_, edge)| edge)
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
