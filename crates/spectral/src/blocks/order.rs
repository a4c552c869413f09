//! The order of the returns of each block in which their edges are short.

/// The members of each block, one block after the other, each in an order of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// All returns, block by block.
    members: Vec<u32>,
    /// Where each block starts in `members`, and the end.
    starts: Vec<u32>,
    /// Where each return is in `members`.
    places: Vec<u32>,
}

impl Order {
    /// Orders the returns of each of `blocks` blocks: in the order of the returns, which is that along a wall, starting
    /// after the largest hole, as a wall may reach over the first beam.
    pub(crate) fn form(&mut self, block_of_return: &[u32], blocks: usize) {
        self.sort_by_block(block_of_return, blocks);
        self.places.clear();
        self.places.resize(block_of_return.len(), 0);
        for block in 0..blocks {
            self.start_after_largest_hole(block);
        }
        for (place, &i) in self.members.iter().enumerate() {
            self.places[i as usize] = place as u32;
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

    /// Where each return is among the members of all blocks.
    pub(crate) fn places(&self) -> &[u32] {
        &self.places
    }

    /// Where a block is among them.
    pub(crate) fn span(&self, block: usize) -> std::ops::Range<usize> {
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
}
