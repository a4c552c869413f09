//! Notes in the log. Each is logged when it begins; the explanation of a revolution has all of its notes.

use crosscut_stage::{Frame, Notes as NotesOfFrame};
use rerun::{TextLog, TextLogLevel};

use crate::beam_order::LARGEST_SIDE;
use crate::matrices::is_drawn;
use crate::rows::Rows;
use crate::schema::LOG;

/// Finds the notes that begin. Notes are compared without their numbers: "4 beams masked" continues "3 beams masked".
#[derive(Default)]
pub(crate) struct Notes {
    /// Kinds of the notes of the revolution before.
    before: Vec<String>,
}

impl Notes {
    /// Logs the notes of the stages and of this recording that begin at this revolution.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame) {
        for note in self.new_of(frame) {
            rows.log(&LOG, &TextLog::new(note).with_level(TextLogLevel::INFO));
        }
    }

    fn new_of(&mut self, frame: &Frame) -> Vec<String> {
        let mut notes: Vec<String> = frame.notes.iter().map(str::to_owned).collect();
        let n = frame.affinity.weights.n();
        if n > 0 && !is_drawn(frame) {
            notes.push(format!("no picture of W and L: {n} returns, pictures are made up to {LARGEST_SIDE}"));
        }
        let kinds: Vec<String> = notes.iter().map(|note| NotesOfFrame::kind_of(note)).collect();
        let before = std::mem::replace(&mut self.before, kinds);
        let new = notes.into_iter().zip(&self.before).filter(|(_, kind)| !before.contains(kind));
        new.map(|(note, _)| note).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_is_logged_when_it_begins_and_begins_again() {
        let noted = |notes: &[&str]| {
            let mut frame = Frame::default();
            notes.iter().for_each(|note| frame.notes.add(*note));
            frame
        };
        let mut notes = Notes::default();
        let flight = [&["3 beams masked"][..], &["4 beams masked", "lost: x"], &["lost: x"], &[], &["lost: x"]];
        let told = flight.map(|frame| notes.new_of(&noted(frame)));
        assert_eq!(told, [vec!["3 beams masked"], vec!["lost: x"], vec![], vec![], vec!["lost: x"]]);
    }
}
