//! Scenes with their truth, and the recordings made of them.

mod recordings;
mod truth;
