//! Openings and confidence of scenes computed by hand.

mod confidence;
mod openings;
mod scenes;
