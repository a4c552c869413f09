//! The flight, read into memory.

use std::cell::RefCell;
use std::rc::Rc;

use crosscut_debugger::{Reader, Scan};
use crosscut_detector::Config;

use crate::input::{Flight, InputArgs, Judge};

/// What was lost of the flight when it was read last.
pub(super) type Lost = Rc<RefCell<Vec<String>>>;

/// Reads the scans that `input` selects, as often as it is asked to.
pub(super) fn reader(input: InputArgs) -> (Reader, Lost) {
    let lost = Lost::default();
    let to_lost = Rc::clone(&lost);
    let read = move |config: &Config| {
        let (scans, lost) = scans(&input, config).map_err(|error| format!("{error:#}"))?;
        *to_lost.borrow_mut() = lost;
        Ok(scans)
    };
    (Box::new(read), lost)
}

fn scans(input: &InputArgs, config: &Config) -> anyhow::Result<(Vec<Scan>, Vec<String>)> {
    let mut flight = Flight::open_with_truths(&input.recordings.input, input, config)?;
    let (mut scans, mut judge) = (Vec::new(), Judge::default());
    loop {
        let mut scan = Scan::default();
        match flight.next(&mut scan.revolution, &mut scan.notes) {
            Ok(None) => break,
            Ok(Some(truth)) => scan.truth = judge.truth(truth, scan.revolution.seq),
            Err(error) if scans.is_empty() => return Err(error.into()),
            Err(error) => {
                let mut lost = flight.losses(judge);
                lost.push(error.to_string());
                return Ok((scans, lost));
            }
        }
        scans.push(scan);
    }
    let lost = flight.losses(judge);
    Ok((scans, lost))
}
