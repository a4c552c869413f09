//! The graph of walls: edges along each wall, weaker across gaps, and weak ones from wall to wall.

use std::ops::Range;

use crosscut_scan::{Pieces, Ring};
use crosscut_stage::{Affinity, Verdict};

use super::decision::Decision;
use super::judge::Judge;
use super::odds::{self, Measures};

/// A return of no wall has an edge to the nearer of the walls beside it, if that is no farther than this.
const NEAR_M: f64 = 3.0;
/// The weight of that edge, and of one across a gap that is within a wall although a vehicle could pass.
const WEAK: f64 = 0.1;
/// Odds assumed for an opening that cannot be measured.
const UNKNOWN_ODDS: f64 = 81.0;
/// An opening that is surer than this leaves no smaller eigenvalue: it stays far above what rounding makes of a zero.
const MOST_ODDS: f64 = 1e4;

/// Each return has edges to this many of its chain on either side.
const NEIGHBOURS: usize = 2;
/// Entries of `Chains::weights` for one return.
const WIDTH: usize = 2 * NEIGHBOURS + 1;

/// Writes W; holds its buffers. Walls and islands are chains of returns.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    /// The numbers of the returns of all chains, one chain after the other.
    numbers: Vec<u32>,
    /// For each of those, the weights of its edges to the [`NEIGHBOURS`] before it in its chain, to itself, and to those
    /// after it; 0 beyond the ends.
    weights: Vec<f64>,
    chains: Vec<Chain>,
    /// The weights of one chain's edges from each return to the next.
    links: Vec<f64>,
    /// The chain of each return, and its place in `numbers`.
    places: Vec<Option<(u32, u32)>>,
    /// Edges from one chain to another, and of returns of no chain, in both directions.
    others: Vec<(u32, u32, f64)>,
    /// What the odds of each verdict rest on.
    pub(super) measures: Vec<Option<Measures>>,
    /// A row whose entries are not in order along its chain, or not all on it.
    row: Vec<(u32, f64)>,
}

/// A wall or an island.
#[derive(Clone, Debug)]
struct Chain {
    /// Its places in `numbers`.
    places: Range<usize>,
    /// Σ D_ii over its edges to itself; each edge counts at both of its ends.
    volume: f64,
}

impl Chains {
    /// Writes W and the verdicts of `walls`, in the order in which they follow each other around the sensor, and of
    /// the islands of the scan. `left_over` are returns of no wall. An opening that could as well be none has an
    /// eigenvalue of `leak`.
    pub(super) fn write(
        &mut self,
        judge: &mut Judge<'_>,
        walls: &Pieces,
        left_over: &[usize],
        leak: f64,
        out: &mut Affinity,
    ) {
        self.numbers.clear();
        self.weights.clear();
        self.chains.clear();
        self.others.clear();
        self.measures.clear();
        out.verdicts.clear();
        let scan = judge.context.scan;
        for chain in walls.iter().chain(scan.islands.pieces.iter()) {
            self.connect_along(judge, chain, &mut out.verdicts);
        }
        self.connect_across_openings(judge, walls, leak, &mut out.verdicts);
        if !left_over.is_empty() {
            self.connect_left_over(&scan.ring, walls.iter().chain(scan.islands.pieces.iter()), left_over);
        }
        self.write_rows(&scan.ring, out);
    }

    /// An edge from each return that is left over to the nearest return of the next chain clockwise or anticlockwise. A
    /// chain farther around the sensor is hidden by those two.
    fn connect_left_over<'a>(&mut self, ring: &Ring, chains: impl Iterator<Item = &'a [usize]>, left_over: &[usize]) {
        let mut chain_of_return = vec![None; ring.len()];
        for chain in chains {
            chain.iter().for_each(|&i| chain_of_return[i] = Some(chain));
        }
        for &i in left_over {
            let next = |direction: isize| {
                let mut onward = (1..ring.len() as isize).map_while(|steps| ring.after(i, direction * steps));
                onward.find_map(|j| chain_of_return[j])
            };
            let (mut nearest, mut least) = (None, NEAR_M * NEAR_M);
            for &j in [next(-1), next(1)].into_iter().flatten().flatten() {
                let squared = (ring.position_m(j) - ring.position_m(i)).norm_squared();
                if squared < least {
                    (nearest, least) = (Some(j), squared);
                }
            }
            if let Some(j) = nearest {
                self.connect(ring, i, j, WEAK);
            }
        }
    }

    /// Edges along a chain, the stronger the cheaper its gaps were to close.
    fn connect_along(&mut self, judge: &mut Judge<'_>, chain: &[usize], verdicts: &mut Vec<Verdict>) {
        let (ring, measures) = (&judge.context.scan.ring, &mut self.measures);
        let link = |(at, pair): (usize, &[usize])| {
            if !judge.context.is_gap(pair[0], pair[1]) {
                return 1.0;
            }
            let joint = judge.joint(&chain[..at], &chain[at..]);
            if let Some((decision, measured)) = judge.verdict(&joint) {
                measures.push(measured);
                verdicts.push(verdict(ring, [pair[0], pair[1]], false, decision, measured));
            }
            joint.cost.map_or(WEAK, |cost| (-cost).exp())
        };
        self.links.clear();
        self.links.extend((1..).zip(chain.windows(2)).map(link));
        let start = self.weights.len();
        self.weights.resize(start + chain.len() * WIDTH, 0.0);
        let mut ahead_of_all = 0.0;
        for at in 0..chain.len() {
            // From the return itself on: the next entries are those of its edges ahead, and `WIDTH - 1` farther each is
            // that of the same edge from its other end.
            let row = &mut self.weights[start + at * WIDTH + NEIGHBOURS..];
            let (mut product, mut ahead) = (1.0, 0.0);
            row[0] = product;
            for (step, link) in (1..=NEIGHBOURS).zip(&self.links[at..]) {
                product *= link;
                ahead += product;
                row[step] = product;
                row[step * (WIDTH - 1)] = product;
            }
            ahead_of_all += ahead;
        }
        let volume = chain.len() as f64 + 2.0 * ahead_of_all;
        let start = self.numbers.len();
        self.numbers.extend(chain.iter().map(|&i| ring.returns[i].number));
        self.chains.push(Chain { places: start..self.numbers.len(), volume });
    }

    /// A weak edge over each opening from one wall to the next. An edge of weight w between walls A and B makes an
    /// eigenvalue w / vol A + w / vol B on its own. That is made half of `leak`, divided by the odds that a vehicle can
    /// pass; half, because two edges at one wall may add up. Where the odds are against what the rules decide it is
    /// half of `leak`. The gap between the two ends of an only wall has no edge.
    fn connect_across_openings(
        &mut self,
        judge: &mut Judge<'_>,
        walls: &Pieces,
        leak: f64,
        verdicts: &mut Vec<Verdict>,
    ) {
        let ring = &judge.context.scan.ring;
        let gaps = if ring.full_turn { walls.len() } else { walls.len().saturating_sub(1) };
        for at in 0..gaps {
            let next = walls.next(at);
            let (a, b) = (&walls[at], &walls[next]);
            let ends = [a[a.len() - 1], b[0]];
            let is_only_wall = next == at;
            let judged = if is_only_wall && judge.context.is_gap(ends[0], ends[1]) {
                let joint = judge.joint(a, b);
                judge.verdict(&joint)
            } else {
                (!is_only_wall).then(|| judge.least_room(a, b))
            };
            let Some((decision, measured)) = judged else { continue };
            self.measures.push(measured);
            verdicts.push(verdict(ring, ends, decision.is_opening(), decision, measured));
            if !is_only_wall && leak > 0.0 {
                let odds = measured.as_ref().map_or(UNKNOWN_ODDS, odds::odds);
                let eigenvalue = 0.5 * leak / odds.clamp(1.0, MOST_ODDS);
                let weight = eigenvalue / (1.0 / self.chains[at].volume + 1.0 / self.chains[next].volume);
                self.connect(ring, ends[0], ends[1], weight);
            }
        }
    }

    fn connect(&mut self, ring: &Ring, i: usize, j: usize, weight: f64) {
        let [i, j] = [i, j].map(|i| ring.returns[i].number);
        self.others.extend([(i, j, weight), (j, i, weight)]);
    }

    fn write_rows(&mut self, ring: &Ring, out: &mut Affinity) {
        self.places.clear();
        self.places.resize(ring.len(), None);
        for (chain, Chain { places, .. }) in self.chains.iter().enumerate() {
            for (at, &number) in places.clone().zip(&self.numbers[places.clone()]) {
                self.places[number as usize] = Some((chain as u32, at as u32));
            }
        }
        self.others.sort_unstable_by_key(|&(from, to, _)| (from, to));
        let mut others = self.others.iter().peekable();
        let mut row = std::mem::take(&mut self.row);
        let csr = out.weights.make_sparse();
        for (number, place) in (0..).zip(&self.places) {
            let (columns, weights) = self.row_along(&number, *place);
            let has_others = others.peek().is_some_and(|&&(from, ..)| from == number);
            // A chain runs around the sensor at most once: if returns are numbered anticlockwise, only a row across the
            // first beam is not in order.
            if !ring.clockwise && columns[0] <= columns[columns.len() - 1] && !has_others {
                csr.push_row(columns, weights);
                continue;
            }
            row.clear();
            row.extend(columns.iter().copied().zip(weights.iter().copied()));
            while let Some(&(_, to, weight)) = others.next_if(|&&(from, ..)| from == number) {
                row.push((to, weight));
            }
            row.sort_unstable_by_key(|&(column, _)| column);
            row.iter().for_each(|&(column, weight)| csr.push(column, weight));
            csr.end_row();
        }
        self.row = row;
    }

    /// The numbers of the returns to which a return has an edge along its chain, itself among them, with the weights of
    /// these edges.
    fn row_along<'a>(&'a self, number: &'a u32, place: Option<(u32, u32)>) -> (&'a [u32], &'a [f64]) {
        let Some((chain, at)) = place else { return (std::slice::from_ref(number), &[1.0]) };
        let (chain, at) = (&self.chains[chain as usize].places, at as usize);
        let first = at.saturating_sub(NEIGHBOURS).max(chain.start);
        let columns = &self.numbers[first..(at + NEIGHBOURS + 1).min(chain.end)];
        (columns, &self.weights[at * WIDTH + NEIGHBOURS - (at - first)..][..columns.len()])
    }
}

fn verdict(ring: &Ring, ends: [usize; 2], is_opening: bool, decision: Decision, measured: Option<Measures>) -> Verdict {
    let Decision { room_ratio, reason, measured: rests_on, .. } = decision;
    let p = measured.as_ref().map(odds::p);
    Verdict { returns: ends.map(|i| ring.returns[i].number), is_opening, room_ratio, reason, p, measured: rests_on }
}
