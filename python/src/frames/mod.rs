//! Frames as columns, one row a frame, so that the steps of an engine can run in several processes.
//!
//! A column is an array of numpy; of lists, the start of each row's list and the values of all rows; of text, its UTF-8
//! likewise. `python/crosscut/_frames.py` makes Arrow of them. What a later step reads is there, to the last bit, and
//! nothing else: W ends at the spectral step, U at the k-means step.

mod matrices;
mod read;
mod write;

use crosscut_stage::Beam;

pub(crate) use self::read::read;
#[cfg(feature = "rerun")]
pub(crate) use self::read::read_to_record;
pub(crate) use self::write::{write_scans, write_step};

/// In `return_of_beam`: a beam that came back with nothing, and one of which nothing is known.
const NO_RETURN: i32 = -1;
const UNKNOWN: i32 = -2;

fn number_of_beam(beam: &Beam) -> i32 {
    match beam {
        Beam::Return(i) => i.cast_signed(),
        Beam::NoReturn => NO_RETURN,
        Beam::Unknown => UNKNOWN,
    }
}

fn beam_of_number(number: i32, returns: usize) -> Option<Beam> {
    match number {
        NO_RETURN => Some(Beam::NoReturn),
        UNKNOWN => Some(Beam::Unknown),
        i => u32::try_from(i).ok().filter(|&i| (i as usize) < returns).map(Beam::Return),
    }
}
