//! Pieces of walls: stretches of the ring of returns.

use std::ops::Index;

use super::ring::Ring;

/// Pieces as they follow each other, none of them empty. They lie in one buffer, so that joining and cutting them moves
/// no returns.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    /// The returns of all pieces, one piece after the other.
    returns: Vec<usize>,
    /// Where each piece ends in `returns`.
    ends: Vec<usize>,
}

impl Pieces {
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The ring of the `kept` returns, cut where two that follow each other are a passage apart.
    pub(super) fn fill(&mut self, ring: &Ring, kept: impl Iterator<Item = usize>, passage_m: f64) {
        self.clear();
        let is_apart = |from: usize, to: usize| ring.are_apart(from, to, passage_m);
        for i in kept {
            let starts_piece = self.returns.last().is_none_or(|&last| is_apart(last, i));
            self.push(i, starts_piece);
        }
        if let [first, .., last] = self.returns[..]
            && self.len() > 1
            && ring.full_turn
            && !is_apart(last, first)
        {
            self.join(self.len() - 1);
        }
    }

    pub(super) fn clear(&mut self) {
        self.returns.clear();
        self.ends.clear();
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[usize]> {
        (0..self.len()).map(|at| &self[at])
    }

    /// The returns of all pieces.
    pub(super) fn returns(&self) -> &[usize] {
        &self.returns
    }

    /// Adds a return to the last piece, or to a new one behind it.
    pub(super) fn push(&mut self, i: usize, starts_piece: bool) {
        if starts_piece {
            self.ends.push(self.returns.len());
        }
        self.returns.push(i);
        if let Some(end) = self.ends.last_mut() {
            *end = self.returns.len();
        }
    }

    /// Joins a piece with the next, which is the first one if it is the last.
    pub(super) fn join(&mut self, at: usize) {
        if at + 1 < self.len() {
            self.ends.remove(at);
            return;
        }
        let first = self.ends.remove(0);
        self.returns.rotate_left(first);
        self.ends.iter_mut().for_each(|end| *end -= first);
        if let Some(end) = self.ends.last_mut() {
            *end = self.returns.len();
        }
    }

    /// Cuts a piece before its return at `cut`, where it has some on both sides.
    pub(super) fn cut(&mut self, at: usize, cut: usize) {
        self.ends.insert(at, self.start(at) + cut);
    }

    /// Takes a piece out.
    pub(super) fn remove(&mut self, at: usize) -> impl Iterator<Item = usize> {
        let (start, end) = (self.start(at), self.ends.remove(at));
        self.ends[at..].iter_mut().for_each(|later| *later -= end - start);
        self.returns.drain(start..end)
    }

    fn start(&self, at: usize) -> usize {
        if at == 0 { 0 } else { self.ends[at - 1] }
    }
}

/// Which end of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    First,
    Last,
}

impl End {
    /// The k-th return of a piece from this end on.
    pub(super) fn at(self, piece: &[usize], k: usize) -> usize {
        piece[if self == Self::Last { piece.len() - 1 - k } else { k }]
    }
}

impl Index<usize> for Pieces {
    type Output = [usize];

    fn index(&self, at: usize) -> &[usize] {
        &self.returns[self.start(at)..self.ends[at]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(of: &[&[usize]]) -> Pieces {
        let mut pieces = Pieces::default();
        for piece in of {
            piece.iter().enumerate().for_each(|(at, &i)| pieces.push(i, at == 0));
        }
        pieces
    }

    #[test]
    fn joined_cut_and_taken_out_pieces_keep_their_returns_also_around_the_ring() {
        let mut all = pieces(&[&[1, 2], &[3], &[4, 5, 6], &[7]]);
        all.join(1);
        assert!(all.iter().eq([&[1, 2][..], &[3, 4, 5, 6], &[7]]), "{all:?}");
        all.join(2);
        assert!(all.iter().eq([&[3, 4, 5, 6][..], &[7, 1, 2]]), "the last goes on in the first: {all:?}");
        all.cut(0, 1);
        assert!(all.remove(1).eq([4, 5, 6]));
        assert!(all.iter().eq([&[3][..], &[7, 1, 2]]), "{all:?}");
        assert_eq!((all.returns(), all.len()), (&[3, 7, 1, 2][..], 2));
    }
}
