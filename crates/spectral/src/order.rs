//! The order of the returns of each block in which their edges are short.

use crate::graph::Graph;

/// A block whose edges are longer than this is ordered by search along them.
const LONG: usize = 16;

/// The members of each block, one block after the other, each in an order of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// All returns, block by block.
    members: Vec<u32>,
    /// Where each block starts in `members`, and the end.
    starts: Vec<u32>,
    block_of_return: Vec<u32>,
    /// The place of each return in its block.
    rank: Vec<u32>,
    /// The longest edge of each block, in places.
    widths: Vec<u32>,
    found: Vec<u32>,
}

impl Order {
    /// Orders the returns of each of `blocks` blocks: in the order of the returns, which is that along a wall, starting after
    /// the largest hole, as a wall may reach over the first beam; or, where that leaves long edges, breadth first from a far
    /// end, if it is better.
    pub(crate) fn form(&mut self, graph: &Graph<'_>, block_of_return: &[u32], blocks: usize) {
        self.block_of_return.clear();
        self.block_of_return.extend_from_slice(block_of_return);
        self.sort_by_block(blocks);
        self.rank.clear();
        self.rank.resize(block_of_return.len(), 0);
        self.widths.clear();
        for block in 0..blocks {
            self.start_after_largest_hole(block);
            let mut width = self.measure(graph, block);
            if width > LONG {
                self.found.clear();
                self.found.extend_from_slice(&self.members[self.span(block)]);
                self.search(graph, block);
                let narrower = self.measure(graph, block);
                if narrower > width {
                    let span = self.span(block);
                    self.members[span].copy_from_slice(&self.found);
                    self.measure(graph, block);
                }
                width = width.min(narrower);
            }
            self.widths.push(width as u32);
        }
    }

    /// The returns of a block.
    pub(crate) fn members(&self, block: usize) -> &[u32] {
        &self.members[self.span(block)]
    }

    /// The longest edge of a block, in places.
    pub(crate) fn width(&self, block: usize) -> usize {
        self.widths[block] as usize
    }

    /// The block of a return.
    pub(crate) fn block(&self, i: usize) -> usize {
        self.block_of_return[i] as usize
    }

    /// The place of a return in its block.
    pub(crate) fn rank(&self, i: usize) -> usize {
        self.rank[i] as usize
    }

    fn span(&self, block: usize) -> std::ops::Range<usize> {
        self.starts[block] as usize..self.starts[block + 1] as usize
    }

    /// Fills `members` and `starts`.
    fn sort_by_block(&mut self, blocks: usize) {
        self.starts.clear();
        self.starts.resize(blocks + 1, 0);
        self.block_of_return.iter().for_each(|&block| self.starts[block as usize + 1] += 1);
        (0..blocks).for_each(|block| self.starts[block + 1] += self.starts[block]);
        self.members.clear();
        self.members.resize(self.block_of_return.len(), 0);
        for (i, &block) in self.block_of_return.iter().enumerate() {
            let next = &mut self.starts[block as usize];
            self.members[*next as usize] = i as u32;
            *next += 1;
        }
        // Each start has become the end, which is where the next one starts.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    fn start_after_largest_hole(&mut self, block: usize) {
        let (n, span) = (self.block_of_return.len() as u32, self.span(block));
        let members = &mut self.members[span];
        let around = members[0] + n - members[members.len() - 1];
        let holes = members.windows(2).map(|pair| pair[1] - pair[0]).enumerate();
        if let Some((at, hole)) = holes.max_by_key(|&(_, hole)| hole)
            && hole > around
        {
            members.rotate_left(at + 1);
        }
    }

    /// Writes the ranks of a block's members, and measures its longest edge.
    fn measure(&mut self, graph: &Graph<'_>, block: usize) -> usize {
        let members = &self.members[self.span(block)];
        for (at, &i) in members.iter().enumerate() {
            self.rank[i as usize] = at as u32;
        }
        let mut width = 0;
        for (at, &i) in members.iter().enumerate() {
            for (j, _) in graph.edges_from(i as usize) {
                if self.block_of_return[j] as usize == block {
                    width = width.max(self.rank[j].abs_diff(at as u32));
                }
            }
        }
        width as usize
    }

    /// Puts a block's members into breadth-first order from the far end of such an order.
    fn search(&mut self, graph: &Graph<'_>, block: usize) {
        let span = self.span(block);
        let mut start = self.members[span.start];
        for _ in 0..2 {
            // Ranks mark what was not yet seen.
            let members = &mut self.members[span.clone()];
            members.iter().for_each(|&i| self.rank[i as usize] = u32::MAX);
            self.rank[start as usize] = 0;
            members[0] = start;
            let mut seen = 1;
            for at in 0..members.len() {
                for &j in graph.edges.row(members[at] as usize).0 {
                    if self.block_of_return[j as usize] as usize == block && self.rank[j as usize] == u32::MAX {
                        self.rank[j as usize] = 0;
                        members[seen] = j;
                        seen += 1;
                    }
                }
            }
            start = members[members.len() - 1];
        }
    }
}
