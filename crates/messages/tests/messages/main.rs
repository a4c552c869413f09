//! Every message type and encoding, whole and damaged.

mod decoding;
mod scans;
