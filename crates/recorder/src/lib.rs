//! Frames to Rerun recordings.
