//! The ways of a mine, and the least flight through all of them. This is the truth, for the judge alone.

use std::collections::BTreeMap;

use nalgebra::Point2;

use crosscut_simulator::network::Network;

/// Up to this many nodes of odd degree are paired exactly.
const MOST_EXACT: usize = 18;

/// A way of a mine: a chain of tunnels between two nodes that are a junction, a dead end or the start.
#[derive(Clone, Debug)]
pub(crate) struct TrueWay {
    pub(crate) ends: [usize; 2],
    pub(crate) centreline_m: Vec<Point2<f64>>,
    /// Half the width at its middle.
    pub(crate) half_width_m: f64,
    pub(crate) length_m: f64,
    /// Which of its ends are dead ends.
    pub(crate) dead_ends: [bool; 2],
}

/// The ways of a network.
pub(crate) fn ways_of(network: &Network, start: usize) -> Vec<TrueWay> {
    let is_end = |node: usize| network.degree(node) != 2 || node == start;
    let mut is_used = vec![false; network.tunnels.len()];
    let mut ways = Vec::new();
    for first in 0..network.tunnels.len() {
        for end in 0..2 {
            let from = network.tunnels[first].ends[end];
            if is_used[first] || !is_end(from) {
                continue;
            }
            let (mut at, mut tunnel) = (from, first);
            let (mut line, mut half_widths_m): (Vec<Point2<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
            loop {
                is_used[tunnel] = true;
                let of = &network.tunnels[tunnel];
                let is_forward = of.ends[0] == at;
                let order: Vec<usize> = if is_forward {
                    (0..of.centreline_m.len()).collect()
                } else {
                    (0..of.centreline_m.len()).rev().collect()
                };
                line.extend(order.iter().map(|&i| of.centreline_m[i]));
                half_widths_m.extend(order.iter().map(|&i| of.half_widths_m[i]));
                at = of.ends[usize::from(is_forward)];
                let next =
                    (0..network.tunnels.len()).find(|&next| !is_used[next] && network.tunnels[next].ends.contains(&at));
                match next.filter(|_| !is_end(at)) {
                    Some(next) => tunnel = next,
                    None => break,
                }
            }
            let length_m = line.windows(2).map(|step| (step[1] - step[0]).norm()).sum();
            let dead_ends = [from, at].map(|node| network.degree(node) == 1);
            let half_width_m = half_widths_m[half_widths_m.len() / 2];
            ways.push(TrueWay { ends: [from, at], centreline_m: line, half_width_m, length_m, dead_ends });
        }
    }
    ways
}

/// The length of the shortest closed flight through all ways, and whether it is exact (else an upper bound).
///
/// It is the length of all ways, and of the shortest pairing of the nodes where an odd number of them meets: these are flown
/// twice (the Chinese postman).
pub(crate) fn offline_m(ways: &[TrueWay]) -> (f64, bool) {
    let all_m: f64 = ways.iter().map(|way| way.length_m).sum();
    // A way to a dead end is flown twice in any case; without it the rest is a smaller mine.
    let mut left: Vec<&TrueWay> = ways.iter().collect();
    let mut twice_m = 0.0;
    loop {
        let degrees = degrees(&left);
        let is_leaf = |way: &&TrueWay| way.ends[0] != way.ends[1] && way.ends.iter().any(|end| degrees[end] == 1);
        let Some(leaf) = left.iter().position(is_leaf) else { break };
        twice_m += left.remove(leaf).length_m;
    }
    let odd: Vec<usize> =
        degrees(&left).into_iter().filter(|(_, degree)| degree % 2 == 1).map(|(node, _)| node).collect();
    let between_m: Vec<Vec<f64>> = odd
        .iter()
        .map(|&from| {
            let least_m = distances_m(&left, from);
            odd.iter().map(|to| least_m.get(to).copied().unwrap_or(f64::INFINITY)).collect()
        })
        .collect();
    let is_exact = odd.len() <= MOST_EXACT;
    let pairs_m = if is_exact { exact_pairs_m(&between_m) } else { improved_pairs_m(&between_m) };
    (all_m + twice_m + pairs_m, is_exact)
}

fn degrees(ways: &[&TrueWay]) -> BTreeMap<usize, usize> {
    let mut degrees = BTreeMap::new();
    for end in ways.iter().flat_map(|way| way.ends) {
        *degrees.entry(end).or_insert(0) += 1;
    }
    degrees
}

/// Dijkstra over the ways.
fn distances_m(ways: &[&TrueWay], from: usize) -> BTreeMap<usize, f64> {
    let mut least_m = BTreeMap::from([(from, 0.0)]);
    let mut done: BTreeMap<usize, f64> = BTreeMap::new();
    while let Some((&at, &at_m)) = least_m.iter().min_by(|a, b| f64::total_cmp(a.1, b.1)) {
        least_m.remove(&at);
        done.insert(at, at_m);
        for way in ways.iter().filter(|way| way.ends.contains(&at)) {
            let to = if way.ends[0] == at { way.ends[1] } else { way.ends[0] };
            if !done.contains_key(&to) {
                let to_m = least_m.entry(to).or_insert(f64::INFINITY);
                *to_m = to_m.min(at_m + way.length_m);
            }
        }
    }
    done
}

/// The least sum over all pairings, by the set of nodes that are paired.
fn exact_pairs_m(between_m: &[Vec<f64>]) -> f64 {
    let n = between_m.len();
    let mut least_m = vec![f64::INFINITY; 1 << n];
    least_m[0] = 0.0;
    for paired in 0_usize..1 << n {
        let Some(first) = (0..n).find(|&node| paired & 1 << node == 0) else { continue };
        for second in (first + 1..n).filter(|&node| paired & 1 << node == 0) {
            let with = paired | 1 << first | 1 << second;
            least_m[with] = least_m[with].min(least_m[paired] + between_m[first][second]);
        }
    }
    least_m[(1 << n) - 1]
}

/// The nearest are paired first; then two pairs are exchanged as long as that makes the sum less.
fn improved_pairs_m(between_m: &[Vec<f64>]) -> f64 {
    let n = between_m.len();
    let mut all: Vec<(usize, usize)> = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))).collect();
    all.sort_by(|x, y| between_m[x.0][x.1].total_cmp(&between_m[y.0][y.1]));
    let mut is_paired = vec![false; n];
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (a, b) in all {
        if !is_paired[a] && !is_paired[b] {
            (is_paired[a], is_paired[b]) = (true, true);
            pairs.push((a, b));
        }
    }
    let mut has_changed = true;
    while has_changed {
        has_changed = false;
        for i in 0..pairs.len() {
            for j in i + 1..pairs.len() {
                let ((a, b), (c, d)) = (pairs[i], pairs[j]);
                let now_m = between_m[a][b] + between_m[c][d];
                for (x, y) in [((a, c), (b, d)), ((a, d), (b, c))] {
                    if between_m[x.0][x.1] + between_m[y.0][y.1] < now_m - 1e-9 {
                        (pairs[i], pairs[j], has_changed) = (x, y, true);
                        break;
                    }
                }
            }
        }
    }
    pairs.iter().map(|&(a, b)| between_m[a][b]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(from: usize, to: usize, length_m: f64) -> TrueWay {
        TrueWay { ends: [from, to], centreline_m: Vec::new(), half_width_m: 1.0, length_m, dead_ends: [false; 2] }
    }

    #[test]
    fn the_least_flight_through_small_mines_is_known() {
        assert_eq!(offline_m(&[way(0, 1, 10.0), way(1, 2, 5.0), way(1, 3, 7.0)]), (44.0, true), "a tree: all twice");
        assert_eq!(offline_m(&[way(0, 1, 3.0), way(1, 2, 4.0), way(2, 0, 5.0)]), (12.0, true), "a loop: all once");
        // Two junctions joined by three ways: the shortest is flown twice.
        assert_eq!(offline_m(&[way(0, 1, 3.0), way(0, 1, 4.0), way(0, 1, 5.0), way(0, 2, 6.0)]), (27.0, true));
    }

    #[test]
    fn pairing_by_exchange_is_near_the_exact_one() {
        let places: Vec<(f64, f64)> = (0..14).map(|i| (f64::from(i * 37 % 17), f64::from(i * 23 % 13))).collect();
        let between_m: Vec<Vec<f64>> =
            places.iter().map(|a| places.iter().map(|b| (a.0 - b.0).hypot(a.1 - b.1)).collect()).collect();
        let (exact_m, improved_m) = (exact_pairs_m(&between_m), improved_pairs_m(&between_m));
        assert!(improved_m >= exact_m - 1e-9 && improved_m <= 1.2 * exact_m, "{improved_m} and {exact_m}");
    }
}
