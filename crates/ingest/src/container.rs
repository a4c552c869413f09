//! One MCAP file: what it holds, and its scan messages in order.
//!
//! Records are told apart here and taken apart by the `mcap` crate. Its own readers stop at the first damaged chunk, do
//! not check the checksum of a chunk that was found by the index, and do not say where a fault is; a damaged recording
//! has to give all that is whole.

mod catalogue;
mod chunk;
mod data_section;
mod records;
mod scans;
mod summary;

pub(crate) use catalogue::{Container, Topic};
pub(crate) use scans::{Message, ScanReader};
