//! Recordings, written and read back.

mod difference;
mod emptiness;
mod file;
mod frames;
mod killing;
mod parts;
mod read_back;
mod reading;
mod slow_disk;
mod values;
