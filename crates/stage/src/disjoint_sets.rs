//! Connected components by union-find.

/// Union-find over the numbers 0..n, such as returns: sets without a common member, which edges join. The root of a set is
/// its smallest member.
///
/// ```
/// let mut sets = crosscut_stage::DisjointSets::default();
/// sets.reset(4);
/// sets.join(3, 1);
/// assert_eq!(sets.root(3), 1);
/// assert_eq!(sets.number_components(), [0, 1, 2, 1]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// n sets of one member each.
    pub fn reset(&mut self, n: usize) {
        self.parent.clear();
        self.parent.extend(0..n as u32);
    }

    /// Joins the sets of `i` and `j`.
    pub fn join(&mut self, i: usize, j: usize) {
        if self.parent[i] == self.parent[j] {
            return;
        }
        let (a, b) = (self.root(i), self.root(j));
        self.parent[a.max(b)] = a.min(b) as u32;
    }

    /// The root of the set of `i`; every other member on the path becomes a child of its grandparent.
    pub fn root(&mut self, i: usize) -> usize {
        let mut i = i as u32;
        while self.parent[i as usize] != i {
            let grandparent = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = grandparent;
            i = grandparent;
        }
        i as usize
    }

    /// The set of each member, numbered by their smallest member. It consumes the sets: `reset` comes before anything else.
    pub fn number_components(&mut self) -> &[u32] {
        let mut next = 0;
        for i in 0..self.parent.len() {
            let parent = self.parent[i] as usize;
            // A parent is smaller, so it holds the number of its component already.
            self.parent[i] = if parent == i {
                next += 1;
                next - 1
            } else {
                self.parent[parent]
            };
        }
        &self.parent
    }
}
