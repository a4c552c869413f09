//! Connected components by union-find.

/// Union-find in which the root of a tree is its smallest member.
#[derive(Clone, Debug, Default)]
pub(crate) struct Forest {
    parent: Vec<u32>,
}

impl Forest {
    /// n trees of one member each.
    pub(crate) fn plant(&mut self, n: usize) {
        self.parent.clear();
        self.parent.extend(0..n as u32);
    }

    pub(crate) fn join(&mut self, i: usize, j: usize) {
        if self.parent[i] == self.parent[j] {
            return;
        }
        let (a, b) = (self.root(i as u32), self.root(j as u32));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The root of the tree of `i`; every other member on the path becomes a child of its grandparent.
    fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let grandparent = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = grandparent;
            i = grandparent;
        }
        i
    }

    /// The component of each member, numbered by their smallest member. The forest is used up.
    pub(crate) fn number_components(&mut self) -> &[u32] {
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

/// Σ D_ii over each component, as [`Forest::number_components`] numbers them.
pub(crate) fn volumes(component_of_return: &[u32], degrees: &[f64], out: &mut Vec<f64>) {
    out.clear();
    for (&component, &degree) in component_of_return.iter().zip(degrees) {
        match out.get_mut(component as usize) {
            Some(volume) => *volume += degree,
            None => out.push(degree), // components appear in the order of their numbers
        }
    }
}
