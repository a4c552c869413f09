//! Recordings, written and read back.

mod emptiness;
mod file;
mod frames;
mod reading;
mod values;
