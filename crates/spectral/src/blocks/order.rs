//! The order of the returns of each block in which their edges are short.

use super::graph::Graph;
use super::split::Split;

/// A block whose edges are longer than this is ordered by search along them.
const LONG: usize = 16;

/// The members of each block, one block after the other, each in an order of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// All returns, block by block.
    members: Vec<u32>,
    /// Where each block starts in `members`, and the end.
    starts: Vec<u32>,
    /// Where each return is in `members`.
    places: Vec<u32>,
    /// The length of the longest edge of each block, in places.
    pub(crate) longest: Vec<usize>,
}

impl Order {
    /// Orders the returns of each block: in the order of the returns, which is that along a wall, starting
    /// after the largest hole, as a wall may reach over the first beam.
    pub(crate) fn form(&mut self, split: &Split) {
        let (block_of_return, blocks) = (&split.block_of_return, split.volumes.len());
        self.sort_by_block(block_of_return, blocks);
        self.places.clear();
        self.places.resize(block_of_return.len(), 0);
        for block in 0..blocks {
            self.start_after_largest_hole(block);
        }
        for (place, &i) in self.members.iter().enumerate() {
            self.places[i as usize] = place as u32;
        }
        self.longest.clear();
        self.longest.resize(blocks, 0);
        for edge in &split.within {
            let [from, to] = [edge.from, edge.to].map(|i| self.places[i as usize]);
            let longest = &mut self.longest[block_of_return[edge.from as usize] as usize];
            *longest = (from.abs_diff(to) as usize).max(*longest);
        }
    }

    /// Orders a block in which that leaves long edges breadth first from a far end, unless they are then longer.
    pub(crate) fn shorten(&mut self, graph: &Graph, block: usize) {
        if self.longest[block] <= LONG {
            return;
        }
        let (before, searched) = (self.members(block).to_vec(), self.search(graph, block));
        self.arrange(block, &searched);
        let then_longest = self.longest_edge(graph, block);
        if then_longest > self.longest[block] {
            self.arrange(block, &before);
        } else {
            self.longest[block] = then_longest;
        }
    }

    /// The returns of a block.
    pub(crate) fn members(&self, block: usize) -> &[u32] {
        &self.members[self.span(block)]
    }

    /// The place in a block of each return; `None` if it is of another.
    pub(crate) fn ranks(&self, block: usize) -> impl Fn(usize) -> Option<usize> {
        let (start, len) = (self.starts[block], self.starts[block + 1] - self.starts[block]);
        let places = &self.places[..];
        move |i| {
            // What is before the block is far behind it when wrapped.
            let rank = places[i].wrapping_sub(start);
            (rank < len).then_some(rank as usize)
        }
    }

    /// Where a block is among the members of all blocks.
    fn span(&self, block: usize) -> std::ops::Range<usize> {
        self.starts[block] as usize..self.starts[block + 1] as usize
    }

    /// Fills `members` and `starts`.
    fn sort_by_block(&mut self, block_of_return: &[u32], blocks: usize) {
        self.starts.clear();
        self.starts.resize(blocks + 1, 0);
        block_of_return.iter().for_each(|&block| self.starts[block as usize + 1] += 1);
        (0..blocks).for_each(|block| self.starts[block + 1] += self.starts[block]);
        self.members.clear();
        self.members.resize(block_of_return.len(), 0);
        for (i, &block) in block_of_return.iter().enumerate() {
            let next = &mut self.starts[block as usize];
            self.members[*next as usize] = i as u32;
            *next += 1;
        }
        // Each start has become the end, which is where the next one starts.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    fn start_after_largest_hole(&mut self, block: usize) {
        let (n, span) = (self.members.len() as u32, self.span(block));
        let members = &mut self.members[span];
        let around = members[0] + n - members[members.len() - 1];
        let holes = members.windows(2).map(|pair| pair[1] - pair[0]).enumerate();
        if let Some((at, hole)) = holes.max_by_key(|&(_, hole)| hole)
            && hole > around
        {
            members.rotate_left(at + 1);
        }
    }

    /// The length of a block's longest edge, in places.
    fn longest_edge(&self, graph: &Graph, block: usize) -> usize {
        let rank = self.ranks(block);
        let members = self.members(block).iter().map(|&i| i as usize).enumerate();
        let edges = members.flat_map(|(at, i)| graph.edges_back(i).map(move |edge| (at, edge.to as usize)));
        edges.filter_map(|(at, j)| Some(at.abs_diff(rank(j)?))).max().unwrap_or(0)
    }

    /// The members of a block, which is connected, in breadth-first order from the far end of such an order.
    fn search(&self, graph: &Graph, block: usize) -> Vec<u32> {
        let rank = self.ranks(block);
        let members = self.members(block);
        let mut start = members[0];
        let (mut found, mut is_seen) = (Vec::with_capacity(members.len()), vec![false; members.len()]);
        for _ in 0..2 {
            is_seen.fill(false);
            let mut see = |i: u32| rank(i as usize).is_some_and(|rank| !std::mem::replace(&mut is_seen[rank], true));
            see(start);
            found.clear();
            found.push(start);
            let mut next = 0;
            while let Some(&i) = found.get(next) {
                found.extend(graph.edges.row(i as usize).0.iter().filter(|&&j| see(j)));
                next += 1;
            }
            start = found[found.len() - 1];
        }
        found
    }

    /// Puts a block's members into this order.
    fn arrange(&mut self, block: usize, members: &[u32]) {
        let span = self.span(block);
        self.members[span.clone()].copy_from_slice(members);
        for (place, &i) in span.zip(members) {
            self.places[i as usize] = place as u32;
        }
    }
}
