//! Returns with the same edges, taken together as one node of a smaller graph.

use crosscut_stage::Csr;

/// Smaller graphs are not searched for twins, which would cost more than it saves: a sweep has none.
const FEWEST_RETURNS: usize = 1024;
const NONE: u32 = u32::MAX;

/// The nodes of a graph: returns, or the twins among them.
///
/// Twins have edges of the same weights to the same others, and none to each other, like the returns of a cloud that one
/// return of a wall stands for. On the m_A twins i of a node A, a vector that sums to 0 there and is 0 elsewhere is an
/// eigenvector,
///
/// L x = (1 - 1 / D_ii) x,
///
/// so that 1 - 1 / D_ii is an eigenvalue m_A - 1 times. All others are even on twins: with y_A = √m_A x_i, they are
/// those of the Laplacian of the graph of nodes,
///
/// W_AB = m_A m_B W_ij, W_AA = m_A, D_AA = m_A D_ii.
///
/// Returns are taken together only where 1 - 1 / D_ii >= τ, so that no zero is lost.
#[derive(Clone, Debug, Default)]
pub(crate) struct Twins {
    node_of_return: Vec<u32>,
    /// The first return of each node.
    firsts: Vec<u32>,
    /// Number of returns of each node, m_A.
    sizes: Vec<f64>,
    /// The latest node among those whose edges have the same [`bucket`].
    latest: Vec<u32>,
    /// W and D of the nodes.
    edges: Csr,
    degrees: Vec<f64>,
}

impl Twins {
    /// Finds the nodes of a graph, numbered by their first return; whether there are twins. Some may be missed.
    pub(crate) fn find(&mut self, edges: &Csr, degrees: &[f64], tolerance: f64) -> bool {
        let n = edges.n();
        self.node_of_return.clear();
        self.firsts.clear();
        self.sizes.clear();
        if n <= FEWEST_RETURNS {
            self.node_of_return.extend(0..n as u32);
            self.sizes.resize(n, 1.0);
            return false;
        }
        self.latest.clear();
        self.latest.resize(n.next_power_of_two(), NONE);
        for (i, degree) in degrees.iter().enumerate() {
            let bucket = bucket(edges, i, self.latest.len()).filter(|_| 1.0 - degree.recip() >= tolerance);
            let node = bucket.map_or(NONE, |bucket| self.latest[bucket]);
            if node != NONE && same_ties(edges, self.firsts[node as usize] as usize, i) {
                self.node_of_return.push(node);
                self.sizes[node as usize] += 1.0;
                continue;
            }
            let node = self.firsts.len() as u32;
            bucket.into_iter().for_each(|bucket| self.latest[bucket] = node);
            self.node_of_return.push(node);
            self.firsts.push(i as u32);
            self.sizes.push(1.0);
        }
        let found = self.firsts.len() < n;
        if found {
            self.take_together(edges, degrees);
        }
        found
    }

    /// The node of each return.
    pub(crate) fn node_of_return(&self) -> &[u32] {
        &self.node_of_return
    }

    /// W_AA of each node.
    pub(crate) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// W and D of the nodes, if twins were found.
    pub(crate) fn quotient(&self) -> (&Csr, &[f64]) {
        (&self.edges, &self.degrees)
    }

    fn take_together(&mut self, edges: &Csr, degrees: &[f64]) {
        let Self { node_of_return, firsts, sizes, edges: quotient, degrees: of_nodes, .. } = self;
        quotient.clear();
        of_nodes.clear();
        for (&i, &size) in firsts.iter().zip(&*sizes) {
            let (others, weights) = edges.row(i as usize);
            for (&j, &weight) in others.iter().zip(weights) {
                let node = node_of_return[j as usize];
                if j == i {
                    quotient.push(node, size * weight);
                } else if firsts[node as usize] == j {
                    // The others of the node have an edge of the same weight.
                    quotient.push(node, size * sizes[node as usize] * weight);
                }
            }
            quotient.end_row();
            of_nodes.push(size * degrees[i as usize]);
        }
    }
}

/// Where to look for a return with the same edges; `None` without any.
fn bucket(edges: &Csr, i: usize, buckets: usize) -> Option<usize> {
    let (others, _) = edges.row(i);
    let is_other = |&&j: &&u32| j as usize != i;
    let (first, last) = (others.iter().find(is_other)?, others.iter().rfind(is_other)?);
    let mixed = (u64::from(*first) << 32 | u64::from(*last)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    Some((mixed >> 32) as usize % buckets)
}

fn same_ties(edges: &Csr, i: usize, j: usize) -> bool {
    let ties = |i: usize| {
        let (others, weights) = edges.row(i);
        others.iter().zip(weights).filter(move |&(&other, _)| other as usize != i)
    };
    edges.row(i).0.len() == edges.row(j).0.len() && ties(i).eq(ties(j))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A star of hubs with this many leaves, each with edges to its hub and to hub 0, leaf by leaf around the hubs.
    fn star(hubs: u32, leaves: u32) -> (Csr, Vec<f64>) {
        let (mut edges, mut degrees) = (Csr::default(), Vec::new());
        let n = hubs * (1 + leaves);
        let is_leaf_of = |leaf: u32, hub: u32| leaf >= hubs && (leaf % hubs == hub || hub == 0);
        let weight = |i: u32, j: u32| match () {
            () if i == j => 1.0,
            () if is_leaf_of(i, j) || is_leaf_of(j, i) => 0.5,
            () if i.max(j) < hubs && i.min(j) == 0 => 0.25,
            () => 0.0,
        };
        for i in 0..n {
            let before = edges.nonzeros();
            (0..n).filter(|&j| weight(i, j) > 0.0).for_each(|j| edges.push(j, weight(i, j)));
            edges.end_row();
            degrees.push(edges.values()[before..].iter().sum());
        }
        (edges, degrees)
    }

    #[test]
    fn leaves_of_a_hub_are_one_node_and_leaves_below_the_tolerance_or_of_another_weight_are_not() {
        let (hubs, leaves) = (8, 200);
        let (edges, degrees) = star(hubs, leaves);
        let mut twins = Twins::default();
        assert!(twins.find(&edges, &degrees, 1e-8));
        let expected: Vec<u32> = (0..hubs * (1 + leaves)).map(|i| if i < hubs { i } else { hubs + i % hubs }).collect();
        assert_eq!(twins.node_of_return(), expected);
        let (quotient, of_nodes) = twins.quotient();
        assert_eq!(quotient.row(1), (&[0, 1, 9][..], &[0.25, 1.0, 100.0][..]));
        assert_eq!(quotient.row(9), (&[0, 1, 9][..], &[100.0, 100.0, 200.0][..]));
        assert_eq!((of_nodes[9], twins.sizes()[9]), (400.0, 200.0), "2 a leaf");
        assert!(!twins.find(&edges, &degrees, 0.51), "1 - 1 / D is 0.5");
        assert!(!twins.find(&star(8, 9).0, &star(8, 9).1, 1e-8), "few returns are not looked through");
    }
}
