//! One turn of the lidar on its way from messages to a revolution.

use crosscut_messages::{DecodeError, LaserScan, ScanMessage};
use crosscut_stage::{NoteCode, Notes};

/// One turn of the lidar, or one message before that is known.
#[derive(Debug)]
pub(crate) struct Turn {
    /// Index of the message in its topic; of joined turns, index of the turn.
    pub(crate) seq: u64,
    /// When its first message was recorded, as the recording states it.
    pub(crate) log_time_ns: u64,
    /// When its first message was recorded, as far as that can be known.
    pub(crate) recorded_ns: u64,
    /// Why that is another time than the recording states.
    pub(crate) odd_time: Option<(NoteCode, &'static str)>,
    /// Which part of the flight its first message is in.
    pub(crate) part: usize,
    pub(crate) scan: Result<ScanMessage, DecodeError>,
    /// Beams whose messages are missing; empty if none is.
    pub(crate) missing: Vec<bool>,
    /// The angle by which the sensor turned with its vehicle from beam to beam by the scan before, rad.
    pub(crate) rad_per_beam: f64,
    /// The time from beam to beam, s; 0 if it is not known.
    pub(crate) beam_s: f64,
    pub(crate) notes: Notes,
    /// Messages of a joined turn that cannot be decoded: their index in the topic, and why.
    pub(crate) undecodable: Vec<(u64, DecodeError)>,
}

impl Turn {
    pub(crate) fn new(seq: u64, part: usize) -> Self {
        Self {
            seq,
            log_time_ns: 0,
            recorded_ns: 0,
            odd_time: None,
            part,
            scan: Ok(ScanMessage::default()),
            missing: Vec::new(),
            rad_per_beam: 0.0,
            beam_s: 0.0,
            notes: Notes::default(),
            undecodable: Vec::new(),
        }
    }

    pub(crate) fn laser_scan(&self) -> Option<&LaserScan> {
        match &self.scan {
            Ok(ScanMessage::Scan(scan)) => Some(scan),
            _ => None,
        }
    }
}
