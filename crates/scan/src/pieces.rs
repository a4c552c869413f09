//! Pieces of walls: stretches of the ring of returns.

use std::ops::Index;

use crate::ring::Ring;

/// A piece of fewer returns is neither a wall nor an island.
pub const LEAST_WALL_RETURNS: usize = 3;

/// Pieces in the order in which they follow each other around the sensor. Each has at least one return. All returns lie
/// in one buffer, so that joining and cutting moves none of them.
#[derive(Clone, Debug, Default)]
pub struct Pieces {
    /// The returns of all pieces, one piece after the other.
    returns: Vec<usize>,
    /// Where each piece ends in `returns`.
    ends: Vec<usize>,
}

impl Pieces {
    /// Number of pieces.
    #[inline]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no piece.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The ring of the `kept` returns, cut where two neighbours are `cut_m` apart or more.
    pub(crate) fn fill(&mut self, ring: &Ring, kept: impl Iterator<Item = usize>, cut_m: f64) {
        self.clear();
        let is_apart = |from: usize, to: usize| ring.are_apart(from, to, cut_m);
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

    /// Removes all pieces, keeping the buffers.
    pub fn clear(&mut self) {
        self.returns.clear();
        self.ends.clear();
    }

    /// The pieces, each as its returns.
    pub fn iter(&self) -> impl Iterator<Item = &[usize]> {
        (0..self.len()).map(|at| &self[at])
    }

    /// The returns of all pieces.
    pub fn returns(&self) -> &[usize] {
        &self.returns
    }

    /// The piece after one, around the sensor.
    #[inline]
    pub fn next(&self, at: usize) -> usize {
        if at + 1 < self.len() { at + 1 } else { 0 }
    }

    /// Adds a return to the last piece, or to a new piece behind it.
    pub(crate) fn push(&mut self, i: usize, starts_piece: bool) {
        if starts_piece {
            self.ends.push(self.returns.len());
        }
        self.returns.push(i);
        if let Some(end) = self.ends.last_mut() {
            *end = self.returns.len();
        }
    }

    /// Joins a piece with the next, which is the first one if it is the last.
    pub fn join(&mut self, at: usize) {
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

    /// Cuts a piece before its return number `cut`, which is not the first of the piece.
    pub fn cut(&mut self, at: usize, cut: usize) {
        self.ends.insert(at, self.start(at) + cut);
    }

    /// Takes a piece out and gives its returns.
    pub fn remove(&mut self, at: usize) -> impl Iterator<Item = usize> {
        let (start, end) = (self.start(at), self.ends.remove(at));
        self.ends[at..].iter_mut().for_each(|later| *later -= end - start);
        self.returns.drain(start..end)
    }

    fn start(&self, at: usize) -> usize {
        if at == 0 { 0 } else { self.ends[at - 1] }
    }
}

/// An end of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The clockwise end.
    First,
    /// The anticlockwise end.
    Last,
}

impl End {
    /// The k-th return of a piece, counted from this end.
    #[inline]
    pub fn at(self, piece: &[usize], k: usize) -> usize {
        piece[if self == Self::Last { piece.len() - 1 - k } else { k }]
    }
}

impl Index<usize> for Pieces {
    type Output = [usize];

    #[inline]
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
    fn joined_cut_and_removed_pieces_keep_their_returns() {
        let mut all = pieces(&[&[1, 2], &[3], &[4, 5, 6], &[7]]);
        all.join(1);
        assert!(all.iter().eq([&[1, 2][..], &[3, 4, 5, 6], &[7]]), "{all:?}");
        all.join(2);
        assert!(all.iter().eq([&[3, 4, 5, 6][..], &[7, 1, 2]]), "the last is joined with the first: {all:?}");
        all.cut(0, 1);
        assert!(all.remove(1).eq([4, 5, 6]));
        assert!(all.iter().eq([&[3][..], &[7, 1, 2]]), "{all:?}");
        assert_eq!((all.returns(), all.len()), (&[3, 7, 1, 2][..], 2));
    }
}
