//! The notes of the revolutions of a run.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crosscut_stage::Notes;

/// At most this many kinds are counted, so that the notes of a damaged recording do not fill the memory.
const MOST_KINDS: usize = 100;

/// How often each kind of note occurs; notes that differ only in their numbers are of one kind.
#[derive(Debug, Default)]
pub struct NoteCounts(BTreeMap<String, NoteCount>);

/// One kind of note.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoteCount {
    /// The first of its kind, with its numbers.
    pub first: String,
    /// Number of revolutions with one of its kind.
    pub revolutions: u64,
    /// The last of them, by its place in the run.
    last: u64,
}

impl NoteCounts {
    /// Takes the notes of the `number`-th revolution of the run, from 1 on.
    pub(crate) fn add(&mut self, number: u64, notes: &Notes) {
        for note in notes.iter() {
            let kind = Notes::kind_of(note);
            if let Some(count) = self.0.get_mut(&kind) {
                count.revolutions += u64::from(count.last != number);
                count.last = number;
            } else if self.0.len() < MOST_KINDS {
                self.0.insert(kind, NoteCount { first: note.to_owned(), revolutions: 1, last: number });
            }
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
    use super::*;

    #[test]
    fn notes_that_differ_in_numbers_count_as_one_and_once_a_revolution() {
        let mut counts = NoteCounts::default();
        for (number, notes) in
            [(1, &["stamp 0"][..]), (2, &["3 beams masked", "7 beams masked"]), (3, &["4 beams masked"])]
        {
            let mut of_frame = Notes::default();
            notes.iter().for_each(|note| of_frame.add(*note));
            counts.add(number, &of_frame);
        }
        let counted: Vec<_> =
            counts.by_frequency().iter().map(|count| (count.first.as_str(), count.revolutions)).collect();
        assert_eq!(counted, [("3 beams masked", 2), ("stamp 0", 1)]);
    }

    #[test]
    fn notes_without_end_take_no_memory_without_end() {
        let mut counts = NoteCounts::default();
        for number in 1..=1000 {
            let mut of_frame = Notes::default();
            of_frame.add(format!("frame_id {}", "x".repeat(number as usize)));
            counts.add(number, &of_frame);
        }
        assert_eq!(counts.by_frequency().len(), MOST_KINDS);
    }
}
