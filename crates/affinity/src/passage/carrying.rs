//! The walls of a cloud: those that a level vehicle sees, carried on to the returns that it does not see.

use crosscut_stage::{Affinity, LevelView, Point, Revolution, Weights};
use nalgebra::distance;

use crate::columns::Columns;

/// Unseen returns are coarsened to so much of a vehicle's width.
const SPACING: f64 = 0.25;

/// W of a cloud, from that of what is seen of it; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Carrying {
    /// The level returns at z = 0; those that are seen first, in beam order.
    level_m: Vec<Point>,
    /// Their numbers in the cloud.
    numbers: Vec<u32>,
    columns: Columns,
    near: Vec<u32>,
    /// The representative of each level return, among them all: the nearest that is no farther than the spacing.
    representative: Vec<u32>,
    /// The level return from which a wall was carried on to a representative that is not seen.
    carried_from: Vec<Option<u32>>,
    open: Vec<u32>,
    /// Of what each representative is tied to the two nearest, and their weights.
    nearest: Vec<[Option<(u32, f64)>; 2]>,
    rows: Vec<Vec<(u32, f64)>>,
}

impl Carrying {
    /// Writes W and D of `cloud` into `out`. `seen` is the graph of `view.seen()`.
    ///
    /// 1. The level returns are coarsened: each has a representative within a quarter of `passage_m`, and all that are seen
    ///    represent themselves.
    /// 2. From what is seen of a wall, the wall is carried on to representatives within `passage_m`, nearest in steps first:
    ///    each is tied to the one that it was reached from, so that nothing unseen joins two walls.
    /// 3. Each other level return is tied to its representative, and to the two nearest of those that this one is tied to.
    ///    So what ties the parts of a wall grows with its number of returns as the parts do, and the second eigenvalue of its
    ///    block does not fall with it.
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
        self.take_level(cloud, view);
        self.coarsen(view.numbers().len(), SPACING * passage_m);
        self.carry(seen, passage_m);
        self.tie_all(cloud.len(), seen);
        self.write_rows(cloud.len(), out);
    }

    fn take_level(&mut self, cloud: &Revolution, view: &LevelView) {
        let mut is_seen = vec![false; cloud.len()];
        view.numbers().iter().for_each(|&number| is_seen[number as usize] = true);
        self.numbers.clear();
        self.numbers.extend_from_slice(view.numbers());
        self.numbers.extend(view.level().iter().filter(|&&number| !is_seen[number as usize]));
        let from_above = |&number: &u32| {
            let point = cloud.points_m[number as usize];
            Point::new(point.x, point.y, 0.0)
        };
        self.level_m.clear();
        self.level_m.extend(self.numbers.iter().map(from_above));
    }

    /// Fills `representative`: a level return that none before it represents is one.
    fn coarsen(&mut self, seen: usize, spacing_m: f64) {
        let Self { level_m, columns, near, representative, .. } = self;
        columns.fill(level_m, spacing_m);
        representative.clear();
        representative.resize(level_m.len(), u32::MAX);
        (0..seen).for_each(|i| representative[i] = i as u32);
        for i in 0..level_m.len() {
            if i >= seen && representative[i] != u32::MAX {
                continue;
            }
            representative[i] = i as u32;
            columns.near(level_m, &level_m[i], spacing_m, near);
            for j in near.iter().map(|&j| j as usize).filter(|&j| j >= seen) {
                let now = representative[j] as usize;
                let is_nearer = |at: usize| distance(&level_m[j], &level_m[i]) < distance(&level_m[j], &level_m[at]);
                if now != j && level_m.get(now).is_none_or(|_| is_nearer(now)) {
                    representative[j] = i as u32;
                }
            }
        }
    }

    /// Fills `carried_from`, breadth first from the seen returns that have an edge.
    fn carry(&mut self, seen: &Affinity, passage_m: f64) {
        let Self { level_m, columns, near, representative, carried_from, open, .. } = self;
        let representatives = (0..level_m.len() as u32).filter(|&j| representative[j as usize] == j);
        columns.fill_with(level_m, representatives, passage_m);
        carried_from.clear();
        carried_from.resize(level_m.len(), None);
        let is_of_wall = |i: usize| seen.degrees.get(i).is_some_and(|degree| *degree > 1.0);
        open.clear();
        open.extend((0..seen.degrees.len() as u32).filter(|&i| is_of_wall(i as usize)));
        let mut next = 0;
        while let Some(&from) = open.get(next) {
            next += 1;
            columns.near(level_m, &level_m[from as usize], passage_m, near);
            for &j in near.iter() {
                let at = j as usize;
                if !is_of_wall(at) && carried_from[at].is_none() {
                    carried_from[at] = Some(from);
                    open.push(j);
                }
            }
        }
    }

    /// Fills `rows`, by numbers of the cloud.
    fn tie_all(&mut self, n: usize, seen: &Affinity) {
        let Self { level_m, numbers, representative, carried_from, nearest, rows, .. } = self;
        rows.iter_mut().for_each(Vec::clear);
        rows.resize_with(n.max(rows.len()), Vec::new);
        (0..n).for_each(|i| rows[i].push((i as u32, 1.0)));
        // What a representative is tied to.
        let ties_of = |at: u32| {
            let along = row(seen, at as usize).filter(move |&(j, _)| j != at);
            along.chain(carried_from[at as usize].map(|from| (from, 1.0)))
        };
        nearest.clear();
        nearest.extend((0..).zip(&*representative).map(|(i, &at)| match at == i {
            true => nearest_two(level_m, at, ties_of(at)),
            false => [None; 2],
        }));
        let mut tie = |i: usize, j: u32, weight: f64| {
            let (i, j) = (numbers[i], numbers[j as usize]);
            rows[i as usize].push((j, weight));
            rows[j as usize].push((i, weight));
        };
        for (i, &at) in representative.iter().enumerate() {
            if at as usize == i {
                let once = |j: u32| j > at || carried_from[i].is_some();
                ties_of(at).filter(|&(j, _)| once(j)).for_each(|(j, weight)| tie(i, j, weight));
                continue;
            }
            let nearest = nearest[at as usize];
            if nearest[0].is_some() {
                tie(i, at, 1.0);
            }
            nearest.into_iter().flatten().for_each(|(j, weight)| tie(i, j, weight));
        }
    }

    fn write_rows(&mut self, n: usize, out: &mut Affinity) {
        let csr = out.weights.make_sparse();
        out.degrees.clear();
        for row in &mut self.rows[..n] {
            row.sort_unstable_by_key(|&(column, _)| column);
            row.iter().for_each(|&(column, weight)| csr.push(column, weight));
            csr.end_row();
            out.degrees.push(row.iter().map(|(_, weight)| weight).sum());
        }
    }
}

/// The entries of row `i` of the seen graph; none of what is not seen.
fn row(seen: &Affinity, i: usize) -> impl Iterator<Item = (u32, f64)> {
    let (columns, weights) = match &seen.weights {
        Weights::Sparse(w) if i < w.n() => w.row(i),
        _ => (&[][..], &[][..]),
    };
    columns.iter().copied().zip(weights.iter().copied())
}

/// The two of `ties` that are nearest to the return at `at`, the first of equals.
fn nearest_two(level_m: &[Point], at: u32, ties: impl Iterator<Item = (u32, f64)>) -> [Option<(u32, f64)>; 2] {
    let mut nearest = [(f64::INFINITY, None); 2];
    for tie in ties {
        let found = (distance(&level_m[tie.0 as usize], &level_m[at as usize]), Some(tie));
        if found.0 < nearest[0].0 {
            nearest = [found, nearest[0]];
        } else if found.0 < nearest[1].0 {
            nearest[1] = found;
        }
    }
    nearest.map(|(_, tie)| tie)
}
