//! Configuration and streaming, with stages that count, fail and panic on command.

mod config;
mod stages;
mod streaming;
