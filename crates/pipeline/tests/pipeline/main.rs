//! Streaming, with stages that count, fail and panic on command.

mod stages;
mod streaming;
