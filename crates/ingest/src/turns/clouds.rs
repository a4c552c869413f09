//! Clouds that show a part of a turn each, as of a lidar that sends halves: joined until a part comes again.

use std::collections::{BTreeSet, VecDeque};
use std::f64::consts::TAU;

use crosscut_messages::{Cloud, ScanMessage};
use crosscut_stage::NoteCode::N047;
use crosscut_stage::counted;

use super::segments::{Numbers, firsts, is_seen};
use super::turn::Turn;

/// The sectors of a turn, which a cloud shows or not.
const SECTORS: usize = 72;
/// Clouds of a turn show this many of them at least, and a part of it no more than the second number, and no fewer than
/// the third.
const LEAST_SHOWN: usize = 54;
const MOST_OF_PART: usize = 54;
const LEAST_OF_PART: usize = 6;

/// Joins the clouds of each turn.
#[derive(Debug)]
pub(super) struct CloudJoiner {
    pub(super) numbers: Numbers,
    is_there: Vec<bool>,
    /// The turn that is not complete, and the number of its messages.
    current: Option<(Turn, u64)>,
}

impl CloudJoiner {
    /// Looks whether the first clouds of a recording are parts of turns.
    pub(super) fn of(clouds: &[&Cloud]) -> Option<Self> {
        let parts: Vec<Vec<usize>> = clouds.iter().map(|cloud| sectors(cloud)).collect();
        let shown: BTreeSet<&usize> = parts.iter().flatten().collect();
        let are_parts = parts.iter().all(|part| (LEAST_OF_PART..=MOST_OF_PART).contains(&part.len()));
        if !are_parts || shown.len() < LEAST_SHOWN {
            return None;
        }
        let numbers = Numbers::of(&firsts(&parts, SECTORS)?, parts.len());
        Some(Self { numbers, is_there: vec![false; SECTORS], current: None })
    }

    /// Takes a message; turns that are complete go to `out`.
    pub(super) fn take(&mut self, mut part: Turn, out: &mut VecDeque<Turn>) {
        let Ok(ScanMessage::Cloud(cloud)) = &part.scan else {
            part.seq = self.numbers.next(part.seq, part.seq);
            return out.push_back(part);
        };
        let shown = sectors(cloud);
        if is_seen(&self.is_there, &shown) {
            self.finish(out);
        }
        shown.iter().for_each(|sector| self.is_there[*sector] = true);
        let Some((turn, messages)) = &mut self.current else {
            self.current = Some((part, 1));
            return;
        };
        *messages += 1;
        if let Ok(ScanMessage::Cloud(all)) = &mut turn.scan {
            let stamp_ns = |cloud: &Cloud| cloud.header.stamp.to_ns().unwrap_or(0);
            let later_s = (i128::from(stamp_ns(cloud)) - i128::from(stamp_ns(all))) as f64 * 1e-9;
            all.points_m.extend(&cloud.points_m);
            all.times_s.extend(cloud.times_s.iter().map(|time_s| time_s + later_s));
            all.rings.extend(&cloud.rings);
        }
    }

    /// Gives the turn that is not complete to `out`.
    pub(super) fn finish(&mut self, out: &mut VecDeque<Turn>) {
        self.is_there.fill(false);
        let Some((mut turn, messages)) = self.current.take() else { return };
        let joined = counted(messages, "message");
        turn.notes.add(N047, format!("a revolution joined of {joined}: seq counts revolutions"));
        turn.seq = self.numbers.next(turn.seq, turn.seq + messages - 1);
        out.push_back(turn);
    }
}

/// The sectors that a cloud shows.
fn sectors(cloud: &Cloud) -> Vec<usize> {
    let at = |[x, y, _]: &[f64; 3]| (y.atan2(*x).rem_euclid(TAU) / TAU * SECTORS as f64) as usize % SECTORS;
    let points = cloud.points_m.iter().filter(|[x, y, _]| x.is_finite() && y.is_finite() && (*x != 0.0 || *y != 0.0));
    points.map(at).collect::<BTreeSet<_>>().into_iter().collect()
}
