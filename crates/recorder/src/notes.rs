//! Notes in the log. Each is logged when it begins; the explanation of a revolution has all of its notes.

use crosscut_stage::Frame;
use crosscut_stage::NoteCode::{self, N099};
use rerun::{TextLog, TextLogLevel};

use crate::beam_order::LARGEST_SIDE;
use crate::matrices::is_drawn;
use crate::rows::Rows;
use crate::schema::LOG;

/// Finds the notes that begin: those of a code that no note of the revolution before has.
#[derive(Default)]
pub(crate) struct Notes {
    /// Codes of the notes of the revolution before.
    before: Vec<NoteCode>,
}

impl Notes {
    /// Logs the notes of the stages and of this recording that begin at this revolution.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame) {
        for note in self.new_of(frame) {
            rows.log(&LOG, &TextLog::new(note).with_level(TextLogLevel::INFO));
        }
    }

    fn new_of(&mut self, frame: &Frame) -> Vec<String> {
        let mut notes = frame.notes.coded().to_vec();
        let n = frame.affinity.weights.n();
        if n > 0 && !is_drawn(frame) {
            notes.push((N099, format!("no picture of W and L: {n} rows, pictures are made up to {LARGEST_SIDE}")));
        }
        let codes = notes.iter().map(|(code, _)| *code).collect();
        let before = std::mem::replace(&mut self.before, codes);
        notes.into_iter().filter(|(code, _)| !before.contains(code)).map(|(_, note)| note).collect()
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::NoteCode::{N001, N094};

    use super::*;

    #[test]
    fn a_note_is_logged_when_it_begins_and_begins_again() {
        let noted = |notes: &[(NoteCode, &str)]| {
            let mut frame = Frame::default();
            frame.notes.extend(notes.iter().copied());
            frame
        };
        let mut notes = Notes::default();
        let lost = (N094, "lost: x");
        let flight = [&[(N001, "3 beams masked")][..], &[(N001, "4 beams masked"), lost], &[lost], &[], &[lost]];
        let told = flight.map(|frame| notes.new_of(&noted(frame)));
        assert_eq!(told, [vec!["3 beams masked"], vec!["lost: x"], vec![], vec![], vec!["lost: x"]]);
    }
}
