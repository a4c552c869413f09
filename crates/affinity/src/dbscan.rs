//! `dbscan`: density-based clustering as a graph, a baseline (Ester, Kriegel, Sander and Xu 1996).
//!
//! W_ij = 1 between any two cores within `eps`, and between a border return and one core. A core has at least
//! `min_points` returns within `eps`, itself included; a border return is no core, but has one within `eps`. All others
//! are noise and have no edge.
//!
//! A border return has an edge to the core that reaches it first when clusters are grown one after the other, depth
//! first, from their first core in beam order: so it joins the cluster in which scikit-learn puts it.

use crosscut_stage::{Affinity, AffinityStage, Count, Invariance, Kind, Notes, Number, Point, Revolution, StageError};

use crate::columns::Columns;
use crate::edges::write_edges;

const EPS_M: Number =
    Number::new("eps_m", "m", 2.5).above(0.0).to(1e6).doc("returns no farther apart than this are neighbours");

const MIN_POINTS: Count = Count::new("min_points", "returns", 3)
    .from(1)
    .to(1_000_000)
    .doc("a return with at least this many neighbours, itself included, is a core");

/// DBSCAN.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "dbscan",
    "a 0/1 graph whose components are DBSCAN's clusters; noise is alone (baseline)",
    |params| Box::new(Dbscan { eps_m: params.get(EPS_M), min_points: params.get(MIN_POINTS), ..Dbscan::default() }),
)
.params(&[EPS_M.spec, MIN_POINTS.spec])
// The order of the returns decides to which of two clusters a border return goes.
.blind_to(&[Invariance::Translation, Invariance::Rotation, Invariance::Turn, Invariance::Mirror]);

#[derive(Default)]
struct Dbscan {
    eps_m: f64,
    min_points: usize,
    neighbours: Neighbours,
    /// The core that reached a return first; none for noise and as long as it is not reached.
    reached_by: Vec<Option<u32>>,
    open: Vec<u32>,
}

impl Dbscan {
    fn is_core(&self, i: usize) -> bool {
        self.neighbours.of(i).len() >= self.min_points
    }

    /// Fills `reached_by`.
    fn grow_clusters(&mut self, n: usize) {
        self.reached_by.clear();
        self.reached_by.resize(n, None);
        for first in 0..n {
            if !self.is_core(first) || self.reached_by[first].is_some() {
                continue;
            }
            self.reached_by[first] = Some(first as u32);
            self.open.push(first as u32);
            while let Some(core) = self.open.pop() {
                for &j in self.neighbours.of(core as usize) {
                    if self.reached_by[j as usize].is_none() {
                        self.reached_by[j as usize] = Some(core);
                        if self.is_core(j as usize) {
                            self.open.push(j);
                        }
                    }
                }
            }
        }
    }

    /// The returns that return i has an edge with, ascending.
    fn row(&self, i: usize) -> impl Iterator<Item = u32> {
        self.neighbours.of(i).iter().copied().filter(move |&j| self.edge(i, j as usize))
    }

    /// Whether neighbours i and j have an edge; every return is its own neighbour.
    fn edge(&self, i: usize, j: usize) -> bool {
        match (self.is_core(i), self.is_core(j)) {
            (true, true) => true,
            (true, false) => self.reached_by[j] == Some(i as u32),
            (false, true) => self.reached_by[i] == Some(j as u32),
            (false, false) => i == j,
        }
    }
}

impl AffinityStage for Dbscan {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        self.neighbours.find(points_m, self.eps_m);
        self.grow_clusters(points_m.len());
        let grown: &Self = self;
        write_edges(out, points_m.len(), |i, row| row.extend(grown.row(i)));
        Ok(())
    }
}

/// The returns within a distance of each return, itself included, ascending.
#[derive(Default)]
struct Neighbours {
    start: Vec<usize>,
    all: Vec<u32>,
    columns: Columns,
    near: Vec<u32>,
}

impl Neighbours {
    fn find(&mut self, points_m: &[Point], reach_m: f64) {
        self.columns.fill(points_m, reach_m);
        self.start.clear();
        self.all.clear();
        for point in points_m {
            self.start.push(self.all.len());
            self.columns.near(points_m, point, reach_m, &mut self.near);
            self.all.extend_from_slice(&self.near);
        }
        self.start.push(self.all.len());
    }

    /// Those of return i.
    fn of(&self, i: usize) -> &[u32] {
        &self.all[self.start[i]..self.start[i + 1]]
    }
}
