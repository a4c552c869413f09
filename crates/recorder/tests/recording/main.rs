//! Recordings, written and read back.

mod contents;
mod difference;
mod drawings;
mod emptiness;
mod every_entity;
mod file;
mod flight_map;
mod frames;
mod killing;
mod merged;
mod parts;
mod read_back;
mod reading;
mod rebuilding;
mod slow_disk;
mod values;
