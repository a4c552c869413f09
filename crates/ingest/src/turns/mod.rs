//! From scan messages to turns of the lidar: messages that are parts of a turn are joined, and blind sectors are found.
//!
//! Both are learned from the first messages of a recording, which wait until enough of them are there. Most recordings
//! have one message a turn and no blind sector; they pass unchanged.

mod clouds;
mod segments;
mod turn;

use std::collections::VecDeque;

use crosscut_messages::{LaserScan, ScanMessage};
use crosscut_sensor::{LEARNED_SCANS, Motion, RevolutionWriter, Sensor};
use crosscut_stage::{Notes, Revolution};

use self::clouds::CloudJoiner;
use self::segments::Joiner;
pub(crate) use self::turn::Turn;
use crate::limits;

/// So many messages show whether they are parts of turns: some turns of those drivers that send the most of them.
const LEARNED_MESSAGES: usize = 100;
const LEARNED_CLOUDS: usize = 12;

/// Turns on their way.
#[derive(Debug)]
pub(crate) struct Turns {
    /// Messages of which it is not known yet whether they are parts of turns.
    waiting: Vec<Turn>,
    turns: VecDeque<Turn>,
    joiner: Option<Joiner>,
    clouds: Option<CloudJoiner>,
    learned_messages: usize,
    knows_parts: bool,
    knows_blind: bool,
    /// Turns are given before there are enough of them to know blind sectors; these were.
    early: Option<Vec<LaserScan>>,
    writer: RevolutionWriter,
    spare: Vec<ScanMessage>,
    /// Of the ranges that wait, and how many may.
    bytes: u64,
    most_bytes: u64,
}

impl Turns {
    /// `are_scans`: messages are those of a 2D lidar.
    pub(crate) fn new(are_scans: bool, finds_blind: bool) -> Self {
        Self {
            waiting: Vec::new(),
            turns: VecDeque::new(),
            joiner: None,
            clouds: None,
            learned_messages: if are_scans { LEARNED_MESSAGES } else { LEARNED_CLOUDS },
            knows_parts: false,
            knows_blind: !are_scans || !finds_blind,
            early: None,
            writer: RevolutionWriter::default(),
            spare: Vec::new(),
            bytes: 0,
            most_bytes: limits::WAITING_BYTES,
        }
    }

    /// With less memory for the messages that wait: fewer have to do, where they are large.
    pub(crate) fn limited(self, most_bytes: u64) -> Self {
        Self { most_bytes, ..self }
    }

    /// How many messages usually make a turn.
    pub(crate) fn messages_in_turn(&self) -> u64 {
        let of_clouds = self.clouds.as_ref().map_or(1, |clouds| clouds.numbers.messages_in_turn);
        self.joiner.as_ref().map_or(of_clouds, Joiner::messages_in_turn)
    }

    /// Takes a message.
    pub(crate) fn push(&mut self, message: Turn, sensor: &Sensor) {
        if !self.is_settled() {
            self.bytes += match &message.scan {
                Ok(ScanMessage::Scan(scan)) => size_of::<f32>() * (scan.ranges.len() + scan.intensities.len()),
                Ok(ScanMessage::Cloud(cloud)) => size_of::<[f64; 3]>() * cloud.points_m.len(),
                Err(_) => 0,
            } as u64;
        }
        let is_full = self.bytes >= self.most_bytes;
        if self.knows_parts {
            self.take(message);
        } else {
            self.waiting.push(message);
            if self.waiting.len() >= self.learned_messages || is_full {
                self.learn_parts();
            }
        }
        if self.knows_parts && self.early.is_none() && (self.turns.len() >= LEARNED_SCANS || is_full) {
            self.learn_blind(sensor);
        }
    }

    /// There are no more messages.
    pub(crate) fn finish(&mut self, sensor: &Sensor) {
        self.learn_parts();
        if let Some(joiner) = &mut self.joiner {
            joiner.finish(&mut self.turns);
        }
        if let Some(clouds) = &mut self.clouds {
            clouds.finish(&mut self.turns);
        }
        self.learn_blind(sensor);
    }

    /// Whether all is learned.
    pub(crate) fn is_settled(&self) -> bool {
        self.knows_parts && self.knows_blind
    }

    /// Nobody waits any longer: turns are given from now on, by what the messages so far show of their parts. Blind sectors are
    /// known once there were enough of them: of few, a view down a tunnel is no different.
    pub(crate) fn hurry(&mut self) {
        self.learn_parts();
        if !self.knows_blind {
            self.early.get_or_insert_default();
        }
    }

    /// The next turn, if it is complete and nothing is left to be learned.
    pub(crate) fn pop(&mut self, sensor: &Sensor) -> Option<Turn> {
        if self.is_settled() {
            return self.turns.pop_front();
        }
        self.early.as_ref()?;
        let turn = self.turns.pop_front()?;
        if let (Some(early), Some(scan)) = (&mut self.early, turn.laser_scan())
            && !turn.missing.contains(&true)
        {
            early.push(scan.clone());
        }
        self.learn_of_early(sensor);
        Some(turn)
    }

    fn learn_of_early(&mut self, sensor: &Sensor) {
        if let Some(early) = self.early.take_if(|early| early.len() >= LEARNED_SCANS) {
            self.writer.learn_blind(&early.iter().collect::<Vec<_>>(), sensor);
            self.knows_blind = true;
        }
    }

    /// Writes the revolution that `scan`, which is that of `turn`, shows into `out`; `motion` is that of the vehicle
    /// meanwhile, if odometry tells it. Beams whose messages are missing and those of blind sectors are unknown.
    pub(crate) fn show(
        &mut self,
        turn: &Turn,
        scan: &ScanMessage,
        motion: Option<&Motion>,
        sensor: &Sensor,
        out: &mut Revolution,
        notes: &mut Notes,
    ) {
        self.writer.show(scan, turn.rad_per_beam, motion, sensor, out, notes);
        notes.extend(turn.notes.coded().iter().cloned());
        self.writer.hide(scan, &turn.missing, sensor, out, notes);
    }

    /// A place for the next message.
    pub(crate) fn place(&mut self) -> ScanMessage {
        self.spare.pop().unwrap_or_default()
    }

    /// Takes back the place of a turn that is done with.
    pub(crate) fn recycle(&mut self, turn: Turn) {
        if self.joiner.is_none() && self.clouds.is_none() && self.spare.is_empty() {
            self.spare.extend(turn.scan);
        }
    }

    fn take(&mut self, message: Turn) {
        match (&mut self.joiner, &mut self.clouds) {
            (Some(joiner), _) => joiner.take(message, &mut self.turns),
            (_, Some(clouds)) => clouds.take(message, &mut self.turns),
            _ => self.turns.push_back(message),
        }
    }

    fn learn_parts(&mut self) {
        if self.knows_parts {
            return;
        }
        self.knows_parts = true;
        let waiting = std::mem::take(&mut self.waiting);
        self.joiner = Joiner::of(&waiting.iter().filter_map(Turn::laser_scan).collect::<Vec<_>>());
        let clouds = waiting.iter().filter_map(|turn| match &turn.scan {
            Ok(ScanMessage::Cloud(cloud)) => Some(cloud),
            _ => None,
        });
        self.clouds = CloudJoiner::of(&clouds.collect::<Vec<_>>());
        waiting.into_iter().for_each(|message| self.take(message));
    }

    fn learn_blind(&mut self, sensor: &Sensor) {
        if self.knows_blind {
            return;
        }
        self.knows_blind = true;
        if self.early.take().is_some() {
            return; // too few
        }
        // A turn without some of its messages shows nothing of the beams that are missing.
        let is_whole = |turn: &&Turn| !turn.missing.contains(&true);
        let scans: Vec<_> = self.turns.iter().filter(is_whole).filter_map(Turn::laser_scan).collect();
        self.writer.learn_blind(&scans, sensor);
    }
}
