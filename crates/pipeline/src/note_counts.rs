//! The notes of the revolutions of a run.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crosscut_stage::{NoteCode, Notes};

/// How often each kind of note occurs.
#[derive(Debug, Default)]
pub struct NoteCounts(BTreeMap<NoteCode, NoteCount>);

/// One kind of note.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoteCount {
    /// The kind.
    pub code: NoteCode,
    /// The first of its kind.
    pub first: String,
    /// Number of revolutions with one of its kind.
    pub revolutions: u64,
    /// The last of them, by its place in the run.
    last: u64,
}

impl NoteCounts {
    /// Takes the notes of the `number`-th revolution of the run, from 1 on.
    pub(crate) fn add(&mut self, number: u64, notes: &Notes) {
        for &(code, ref note) in notes.coded() {
            let new = || NoteCount { code, first: note.clone(), revolutions: 0, last: 0 };
            let count = self.0.entry(code).or_insert_with(new);
            count.revolutions += u64::from(count.last != number);
            count.last = number;
        }
    }

    /// All kinds, the most frequent first.
    pub fn by_frequency(&self) -> Vec<&NoteCount> {
        let mut counts: Vec<_> = self.0.values().collect();
        counts.sort_by_key(|count| Reverse(count.revolutions));
        counts
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::NoteCode::{N001, N040};

    use super::*;

    #[test]
    fn notes_of_one_code_count_once_a_revolution() {
        let mut counts = NoteCounts::default();
        let masked = |note| (N001, note);
        for (number, notes) in [
            (1, &[(N040, "stamp 0")][..]),
            (2, &[masked("3 beams masked"), masked("7 beams masked")]),
            (3, &[masked("4 beams masked")]),
        ] {
            let mut of_frame = Notes::default();
            of_frame.extend(notes.iter().copied());
            counts.add(number, &of_frame);
        }
        let counted: Vec<_> =
            counts.by_frequency().iter().map(|count| (count.first.as_str(), count.revolutions)).collect();
        assert_eq!(counted, [("3 beams masked", 2), ("stamp 0", 1)]);
    }
}
