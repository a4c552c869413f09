//! Messages that show a part of a turn each, and how they are joined.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::f64::consts::TAU;

use crosscut_messages::{LaserScan, ScanMessage};
use crosscut_stage::NoteCode::{N046, N047, N048, N059};
use crosscut_stage::counted;

use super::turn::Turn;
use crate::limits;
use crate::order::usual;

/// Fewer messages do not show what a driver does.
const LEAST_MESSAGES: usize = 6;
/// A message that covers more of a turn than this is a revolution of its own.
const WIDEST_PART_RAD: f64 = 0.75 * TAU;
/// The next part begins within this many steps of where the last one ends.
const LEEWAY_STEPS: f64 = 3.0;
/// At least this share of the messages begin where the one before ends: all but the first of each turn.
const CONTINUED_SHARE: f64 = 0.5;
/// Increments of f32 angles that differ by less than this share are equal.
const ROUNDING_SHARE: f64 = 1e-4;
/// Increments of one sensor, whose motor runs unevenly, are within this factor of the usual one.
const UNEVEN: f64 = 1.2;
/// Parts that come in any order are those of turns if a turn of them shows at least this share of all that they show.
const SHOWN_SHARE: f64 = 0.75;
/// A part of which more than this share was seen in this turn is of the next one.
const SEEN_SHARE: f64 = 0.5;
/// A turn takes no longer than this many usual ones: then messages are missing, and the next one is of another turn.
const LONGEST_TURNS: u64 = 2;

/// Joins the parts of each turn. Beams are numbered from the beginning of the turn, in the order in which the sensor
/// looks.
#[derive(Debug)]
pub(super) struct Joiner {
    /// Where a turn begins, in the direction of travel, rad in [0, 2π).
    start_rad: f64,
    /// As the messages usually state it, negative if the sensor turns clockwise.
    increment_rad: f32,
    /// Parts do not follow each other by their bearings.
    in_any_order: bool,
    beams: usize,
    numbers: Numbers,
    usual_ns: Option<u64>,
    current: Option<Current>,
}

/// Numbers turns by those of their messages.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    pub(super) messages_in_turn: u64,
    following_seq: Option<u64>,
}

/// The turn that is not complete.
#[derive(Debug)]
struct Current {
    turn: Turn,
    scan: LaserScan,
    is_there: Vec<bool>,
    first_seq: u64,
    messages: u64,
    /// First beam of the first and of the last message.
    first_beams: [usize; 2],
    last_stamp_ns: u64,
}

impl Joiner {
    /// Looks whether the first scans of a recording are parts of turns.
    pub(super) fn of(scans: &[&LaserScan]) -> Option<Self> {
        let stated = scans.iter().filter(|scan| states_increment(scan));
        let way = stated.clone().next()?.angle_increment;
        let increment_rad = (usual(stated.map(|scan| f64::from(scan.angle_increment).abs()))? as f32).copysign(way);
        let step_rad = f64::from(increment_rad).abs();
        let is_part =
            |scan: &LaserScan| scan.angle_min.is_finite() && span_rad(scan) > 0.0 && span_rad(scan) < WIDEST_PART_RAD;
        let scans: Vec<_> = scans.iter().map(|scan| along(scan, increment_rad)).collect();
        let scans: Vec<&LaserScan> = scans.iter().map(|scan| &**scan).collect();
        let are_parts = scans.iter().all(|scan| is_part(scan) && is_of_sensor(scan, increment_rad));
        let is_step = step_rad * limits::BEAMS as f64 >= TAU;
        if scans.len() < LEAST_MESSAGES || !is_step || !are_parts {
            return None;
        }
        let begins_rad = |scan: &LaserScan| travel_rad(scan, increment_rad);
        let continues = |pair: &&[&LaserScan]| {
            let moved_rad = (begins_rad(pair[1]) - begins_rad(pair[0])).rem_euclid(TAU);
            (moved_rad - span_rad(pair[0])).abs() <= LEEWAY_STEPS * step_rad
        };
        let continued = scans.windows(2).filter(continues).count();
        let in_any_order = (continued as f64) < CONTINUED_SHARE * (scans.len() - 1) as f64;
        let mut parts_rad: Vec<[f64; 2]> = scans.iter().map(|scan| [begins_rad(scan), span_rad(scan)]).collect();
        parts_rad.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let start_rad = start_of_turn(&parts_rad, LEEWAY_STEPS * step_rad);
        let mut joiner = Self {
            start_rad,
            increment_rad,
            in_any_order,
            beams: 0,
            numbers: Numbers::default(),
            usual_ns: None,
            current: None,
        };
        let all_round = (TAU / step_rad + 0.5).floor() as usize;
        let ends = scans.iter().map(|scan| joiner.first_beam(scan) + joiner.beams_of(scan).len());
        joiner.beams = ends.max()?.min(all_round);
        let is_frame = |scan: &&LaserScan| scan.header.frame_id == scans[0].header.frame_id;
        if in_any_order && !scans.iter().all(is_frame) {
            return None;
        }
        let places = |joiner: &Self| scans.iter().map(|scan| joiner.places(scan)).collect::<Vec<_>>();
        let is_first = |&at: &usize| joiner.first_beam(scans[at]) <= joiner.first_beam(scans[at - 1]);
        let firsts: Vec<usize> = if in_any_order {
            firsts(&places(&joiner), joiner.beams)?
        } else {
            (1..scans.len()).filter(is_first).collect()
        };
        joiner.numbers = Numbers::of(&firsts, scans.len());
        let took_ns = |pair: &[usize]| stamp_ns(scans[pair[1]]).checked_sub(stamp_ns(scans[pair[0]]));
        let took_ns = firsts.windows(2).filter_map(took_ns).map(|ns| ns as f64);
        joiner.usual_ns = usual(took_ns).map(|ns| ns as u64).filter(|&ns| ns > 0);
        Some(joiner)
    }

    /// The beams of a turn that a message shows.
    fn places(&self, scan: &LaserScan) -> Vec<usize> {
        let first = self.first_beam(scan);
        (first..first + self.beams_of(scan).len()).map(|beam| beam % self.beams).collect()
    }

    /// The ranges of a message at the beams of a turn from its first one on: each is that of the nearest beam.
    fn beams_of<'a>(&self, scan: &'a LaserScan) -> Cow<'a, [f32]> {
        if has_increment(scan, self.increment_rad) {
            return Cow::Borrowed(&scan.ranges);
        }
        let [step_rad, own_rad] = [self.increment_rad, scan.angle_increment].map(|rad| f64::from(rad).abs());
        let off_rad = 0.5 * step_rad - (self.off_start_rad(scan) + 0.5 * step_rad).rem_euclid(TAU).rem_euclid(step_rad);
        let last = scan.ranges.len() - 1;
        let beams = ((span_rad(scan) - 0.5 * step_rad - off_rad) / step_rad).ceil().max(1.0) as usize;
        let nearest = |beam: usize| ((off_rad + beam as f64 * step_rad) / own_rad).round().max(0.0) as usize;
        (0..beams).map(|beam| scan.ranges[nearest(beam).min(last)]).collect()
    }

    fn off_start_rad(&self, scan: &LaserScan) -> f64 {
        travel_rad(scan, self.increment_rad) - self.start_rad
    }

    /// How many messages usually make a turn.
    pub(super) fn messages_in_turn(&self) -> u64 {
        self.numbers.messages_in_turn
    }

    /// Whether a scan is a part of a turn, and looks where the first ones did.
    fn joins(&self, scan: &LaserScan) -> bool {
        !scan.ranges.is_empty()
            && scan.angle_min.is_finite()
            && (!states_increment(scan) || is_of_sensor(scan, self.increment_rad))
            && self.first_beam(&along(scan, self.increment_rad)) <= self.beams
    }

    /// Takes a message; turns that are complete go to `out`.
    pub(super) fn take(&mut self, mut part: Turn, out: &mut VecDeque<Turn>) {
        let scan = match &part.scan {
            Ok(ScanMessage::Scan(scan)) if self.joins(scan) => along(scan, self.increment_rad),
            Ok(_) => {
                self.finish(out);
                part.notes.add(
                    N059,
                    "not joined with other parts of its turn: the angle from beam to beam, or its sector, is another",
                );
                part.seq = self.numbers.next(part.seq, part.seq);
                out.push_back(part);
                return;
            }
            Err(cause) => {
                if let Some(current) = &mut self.current {
                    current.turn.notes.add(N046, format!("a message of this turn cannot be decoded: {cause}"));
                    current.turn.undecodable.push((part.seq, cause.clone()));
                } else {
                    part.seq = self.numbers.next(part.seq, part.seq);
                    out.push_back(part);
                }
                return;
            }
        };
        let (scan, first_beam, ranges) = (&*scan, self.first_beam(&scan), self.beams_of(&scan));
        let is_late = |current: &Current| {
            let longest_ns = self.usual_ns.map_or(u64::MAX, |usual_ns| LONGEST_TURNS * usual_ns);
            stamp_ns(scan).saturating_sub(stamp_ns(&current.scan)) > longest_ns
        };
        let is_next = |current: &Current| match self.in_any_order {
            true => is_seen(&current.is_there, &self.places(scan)),
            // The end of a part that went on into this turn may be where the next one begins.
            false => {
                let last_beam = current.first_beams[1];
                first_beam <= last_beam && (last_beam > 0 || is_seen(&current.is_there, &self.places(scan)))
            }
        };
        if self.current.as_ref().is_some_and(|current| is_next(current) || is_late(current)) {
            self.finish(out);
        }
        let fits = ranges.len().min(self.beams.saturating_sub(first_beam));
        self.place(&part, scan, &ranges[..fits], first_beam);
        if fits < ranges.len() {
            // It goes on where the next turn begins.
            if !self.in_any_order {
                self.finish(out);
            }
            self.place(&part, scan, &ranges[fits..ranges.len().min(fits + self.beams)], 0);
        }
    }

    /// Gives the turn that is not complete to `out`.
    pub(super) fn finish(&mut self, out: &mut VecDeque<Turn>) {
        let Some(mut current) = self.current.take() else { return };
        let [first, last] = current.first_beams;
        let took_ns = current.last_stamp_ns.saturating_sub(stamp_ns(&current.scan));
        if last > first && took_ns > 0 {
            current.scan.time_increment = (took_ns as f64 * 1e-9 / (last - first) as f64) as f32;
            current.scan.scan_time = current.scan.time_increment * self.beams as f32;
        }
        let messages = counted(current.messages, "message");
        current.turn.notes.add(N047, format!("a revolution joined of {messages}: seq counts revolutions"));
        let missing = current.is_there.iter().filter(|is_there| !**is_there).count();
        if missing > 0 {
            let beams = counted(missing as u64, "beam");
            current.turn.notes.add(N048, format!("{beams} of messages that are missing left out"));
        }
        current.turn.missing = current.is_there.iter().map(|is_there| !is_there).collect();
        current.turn.seq = self.numbers.next(current.first_seq, current.turn.seq);
        current.turn.scan = Ok(ScanMessage::Scan(current.scan));
        out.push_back(current.turn);
    }

    /// Puts some of the ranges of `scan` into the current turn, from a beam on.
    fn place(&mut self, part: &Turn, scan: &LaserScan, ranges: &[f32], first_beam: usize) {
        let (beams, increment_rad) = (self.beams, f64::from(self.increment_rad));
        let begin = || {
            let angle_min = self.start_rad * increment_rad.signum();
            let scan = LaserScan {
                header: scan.header.clone(),
                angle_min: angle_min as f32,
                angle_max: (angle_min + (beams - 1) as f64 * increment_rad) as f32,
                angle_increment: self.increment_rad,
                ranges: vec![f32::NAN; beams],
                intensities: Vec::new(),
                ..*scan
            };
            Current {
                turn: Turn {
                    log_time_ns: part.log_time_ns,
                    recorded_ns: part.recorded_ns,
                    odd_time: part.odd_time,
                    notes: part.notes.clone(),
                    ..Turn::new(part.seq, part.part)
                },
                scan,
                is_there: vec![false; beams],
                first_seq: part.seq,
                messages: 0,
                first_beams: [first_beam; 2],
                last_stamp_ns: 0,
            }
        };
        let current = self.current.get_or_insert_with(begin);
        let places = first_beam..first_beam + ranges.len();
        current.scan.ranges[places.clone()].copy_from_slice(ranges);
        current.is_there[places].fill(true);
        current.messages += 1;
        current.first_beams[1] = first_beam;
        current.last_stamp_ns = stamp_ns(scan);
        current.turn.seq = part.seq;
    }

    /// The beam of a turn that the first range of `scan` is.
    fn first_beam(&self, scan: &LaserScan) -> usize {
        let step_rad = f64::from(self.increment_rad).abs();
        ((self.off_start_rad(scan) + 0.5 * step_rad).rem_euclid(TAU) / step_rad) as usize
    }
}

impl Numbers {
    /// Of turns that begin with these of the first messages.
    pub(super) fn of(firsts: &[usize], messages: usize) -> Self {
        let messages_in_turn = match firsts[..] {
            [first, .., last] => ((last - first) as f64 / (firsts.len() - 1) as f64).round().max(1.0) as u64,
            _ => messages as u64,
        };
        Self { messages_in_turn, following_seq: None }
    }

    /// The number of the turn whose messages are those from `first` to `last`: turns that are missing are counted.
    pub(super) fn next(&mut self, first: u64, last: u64) -> u64 {
        let first_turn = first / self.messages_in_turn;
        let seq = self.following_seq.map_or(first_turn, |next| next.max(first_turn));
        self.following_seq = Some((seq + 1).max(last / self.messages_in_turn));
        seq
    }
}

/// The first message of each turn but the first, of messages in any order that show these of all places each; `None` if
/// these are no parts of turns.
pub(super) fn firsts(parts: &[Vec<usize>], places: usize) -> Option<Vec<usize>> {
    let (mut is_there, mut is_ever_there) = (vec![false; places], vec![false; places]);
    let (mut firsts, mut shown) = (Vec::new(), Vec::new());
    for (at, part) in parts.iter().enumerate() {
        if is_seen(&is_there, part) {
            firsts.push(at);
            shown.push(is_there.iter().filter(|is_there| **is_there).count());
            is_there.fill(false);
        }
        part.iter().for_each(|place| (is_there[*place], is_ever_there[*place]) = (true, true));
    }
    let all = is_ever_there.iter().filter(|is_there| **is_there).count();
    let whole = shown.iter().filter(|shown| **shown as f64 >= SHOWN_SHARE * all as f64).count();
    (shown.len() > 2 && 2 * whole > shown.len() && 2 * firsts.len() <= parts.len()).then_some(firsts)
}

/// Whether most of a part was seen in this turn.
pub(super) fn is_seen(is_there: &[bool], part: &[usize]) -> bool {
    part.iter().filter(|place| is_there[**place]).count() as f64 > SEEN_SHARE * part.len() as f64
}

/// Whether a scan can be of a sensor whose increment is usually this one.
fn is_of_sensor(scan: &LaserScan, increment_rad: f32) -> bool {
    let share = (f64::from(scan.angle_increment) / f64::from(increment_rad)).abs();
    (1.0 / UNEVEN..=UNEVEN).contains(&share)
}

/// The angle that a scan covers.
fn span_rad(scan: &LaserScan) -> f64 {
    scan.ranges.len() as f64 * f64::from(scan.angle_increment).abs()
}

/// Whether a scan says how far its beams are apart.
fn states_increment(scan: &LaserScan) -> bool {
    scan.angle_increment.is_finite() && scan.angle_increment != 0.0
}

/// The scan with its beams in the direction of `increment_rad`; they are as far apart as usual where it does not say how far.
fn along(scan: &LaserScan, increment_rad: f32) -> Cow<'_, LaserScan> {
    if !states_increment(scan) {
        return Cow::Owned(LaserScan { angle_increment: increment_rad, ..scan.clone() });
    }
    if scan.angle_increment * increment_rad >= 0.0 {
        return Cow::Borrowed(scan);
    }
    let steps = scan.ranges.len().saturating_sub(1) as f32;
    let (angle_min, angle_max) = (scan.angle_min + steps * scan.angle_increment, scan.angle_min);
    let ranges = scan.ranges.iter().rev().copied().collect();
    Cow::Owned(LaserScan { angle_min, angle_max, angle_increment: -scan.angle_increment, ranges, ..scan.clone() })
}

fn has_increment(scan: &LaserScan, increment_rad: f32) -> bool {
    let [stated, wanted] = [scan.angle_increment, increment_rad].map(f64::from);
    (stated - wanted).abs() <= ROUNDING_SHARE * wanted.abs()
}

/// Where the scan begins, counted in the direction in which the sensor turns, in [0, 2π).
fn travel_rad(scan: &LaserScan, increment_rad: f32) -> f64 {
    (f64::from(scan.angle_min) * f64::from(increment_rad).signum()).rem_euclid(TAU)
}

fn stamp_ns(scan: &LaserScan) -> u64 {
    scan.header.stamp.to_ns().unwrap_or(0)
}

/// Where turns begin: behind the widest gap between parts (beginning and span, by beginning); of a full turn at the
/// first beginning from the back of the sensor on.
fn start_of_turn(parts_rad: &[[f64; 2]], leeway_rad: f64) -> f64 {
    let (mut reach_rad, mut widest) = (parts_rad.iter().map(|part| part[0] + part[1]).fold(0.0, f64::max) - TAU, None);
    for &[begin_rad, span_rad] in parts_rad {
        let gap_rad = begin_rad - reach_rad;
        if gap_rad > widest.map_or(leeway_rad, |(widest_rad, _)| widest_rad) {
            widest = Some((gap_rad, begin_rad));
        }
        reach_rad = reach_rad.max(begin_rad + span_rad);
    }
    // A beginning at the back may be rounded to either side of it.
    let from_back_rad = |begin_rad: f64| (begin_rad - 0.5 * TAU + leeway_rad).rem_euclid(TAU);
    let first_from_back =
        || parts_rad.iter().map(|part| part[0]).min_by(|&a, &b| from_back_rad(a).total_cmp(&from_back_rad(b)));
    widest.map(|(_, begin_rad)| begin_rad).or_else(first_from_back).unwrap_or(0.0)
}
