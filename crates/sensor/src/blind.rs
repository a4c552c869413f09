//! Beams that never return anything: a sector that the driver leaves out, or that a part of the vehicle is in front of.
//!
//! A dark passage does not return anything either. It differs in three ways:
//! - Its edges move over the beams as the vehicle moves. The edges of a blind sector stay at the same beams, while the
//!   ranges beside them change.
//! - A vehicle that keeps its heading between two walls that run on keeps the edges of the dark ends, too. Between two walls
//!   that are seen at a grazing angle, a sector counts as blind only once the vehicle has turned by its width.
//! - While the vehicle stands still, the walls that lead into a passage are seen at a grazing angle. A sector counts as
//!   blind then only if the driver gives 0 for it and for no other beam, it is wide, and the walls beside it go on.

use std::ops::Range;

use crosscut_messages::LaserScan;
use crosscut_stage::NoteCode::{N023, N024};
use crosscut_stage::{Beam, Notes, Revolution, as_setting_rad, counted};

use crate::Sensor;
use crate::directions::BeamDirections;
use crate::turning::shift_beams;

/// Fewer scans do not show that a beam never returns.
const LEAST_SCANS: usize = 15;
/// A narrower sector is not worth a word.
const LEAST_RAD: f64 = 2.0 * DEGREE_RAD;
/// A sector that a vehicle that stands still takes for blind is this wide.
const LEAST_STANDING_RAD: f64 = 60.0 * DEGREE_RAD;
/// The beams beside a sector that return in most scans.
const SIDE_BEAMS: usize = 3;
const MOST_SCANS_SHARE: f64 = 0.7;
/// The ranges beside a sector change by more than this as the vehicle moves, m.
const MOVED_M: f64 = 0.5;
/// Over this angle the range of a wall beside a sector grows by no more than this factor, unless it is seen at a grazing
/// angle.
const WALL_RAD: f64 = 4.0 * DEGREE_RAD;
const GRAZING: f64 = 1.1;
/// A sector of which more beams than this share return is not blind.
const REVOKED_SHARE: f64 = 0.1;

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

/// The blind sectors of a sensor.
#[derive(Debug, Default)]
pub(crate) struct BlindSectors {
    sectors: Vec<Sector>,
    /// `angle_min`, `angle_increment` and the number of beams of the scans that they were found in.
    geometry: (f32, f32, usize),
    /// The beams of a turn in these scans.
    turn_beams: usize,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Sector {
    first: usize,
    beams: usize,
}

/// What one beam saw in the first scans.
#[derive(Clone, Copy, Default)]
struct Seen {
    returns: usize,
    zeros: usize,
    nearest_m: f64,
    farthest_m: f64,
    sum_m: f64,
}

impl BlindSectors {
    /// Looks for them in the first scans of a recording; there are none if these differ in their beams.
    pub(crate) fn find(scans: &[&LaserScan], sensor: &Sensor) -> Self {
        let geometry_of = |scan: &LaserScan| (scan.angle_min, scan.angle_increment, scan.ranges.len());
        let Some(geometry) = scans.first().map(|scan| geometry_of(scan)) else { return Self::default() };
        if scans.len() < LEAST_SCANS || scans.iter().any(|scan| geometry_of(scan) != geometry) {
            return Self::default();
        }
        let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
        let mut seen = Vec::new();
        let mut directions = BeamDirections::default();
        for scan in scans {
            let scan = sensor.in_metres(scan);
            notes.clear();
            sensor.turning_revolution(&scan, 0.0, &mut directions, &mut revolution, &mut notes);
            let Some(sweep) = &revolution.sweep else { return Self::default() };
            seen.resize(sweep.len(), Seen::default());
            for ((seen, beam), &range_m) in seen.iter_mut().zip(&sweep.beams).zip(&scan.ranges) {
                seen.zeros += usize::from(range_m == 0.0);
                if matches!(beam, Beam::Return(_)) {
                    seen.add(f64::from(range_m));
                }
            }
        }
        let Some(sweep) = &revolution.sweep else { return Self::default() };
        let first_scans = FirstScans {
            seen,
            scans: scans.len(),
            step_rad: sweep.step_rad,
            full_turn: sweep.full_turn,
            turned_rad: turned_rad(scans),
        };
        Self { sectors: first_scans.sectors(), geometry, turn_beams: sweep.len() }
    }

    /// Takes what the beams of blind sectors saw as unknown. A sector that returns something after all is forgotten.
    pub(crate) fn hide(&mut self, scan: &LaserScan, out: &mut Revolution, notes: &mut Notes) {
        let Some(sweep) = &mut out.sweep else { return };
        if (scan.angle_min, scan.angle_increment, scan.ranges.len()) != self.geometry {
            return;
        }
        // The last beams of a turn are left out while the vehicle turns towards them.
        let (all, turn_beams) = (sweep.len(), self.turn_beams);
        self.sectors.retain(|sector| {
            let beams = || sector.range().map(|beam| beam % turn_beams).filter(|beam| *beam < all);
            let returns = beams().filter(|&beam| matches!(sweep.beams[beam], Beam::Return(_))).count();
            if returns as f64 > REVOKED_SHARE * sector.beams as f64 {
                notes.add(N024, "a sector that was taken as blind returns something: it is in view from here on");
                return false;
            }
            let mut hidden = 0;
            for beam in beams() {
                if sweep.beams[beam] == Beam::NoReturn {
                    sweep.beams[beam] = Beam::Unknown;
                    hidden += 1;
                }
            }
            if hidden > 0 {
                let ends =
                    [sector.first, sector.first + sector.beams - 1].map(|beam| sweep.bearings_rad[beam % turn_beams]);
                let [from, to] = if sweep.view().clockwise { [ends[1], ends[0]] } else { ends };
                let margin_rad = 0.5 * sweep.step_rad;
                notes.add(
                    N023,
                    format!(
                        "{} never returned anything in the first scans, taken as blind: \
                     ingest.masked_sectors_rad = [[{:.3}, {:.3}]] masks them for good; \
                     ingest.find_blind_sectors = false turns this off",
                        counted(hidden, "beam"),
                        as_setting_rad(from - margin_rad),
                        as_setting_rad(to + margin_rad)
                    ),
                );
            }
            true
        });
    }
}

impl Sector {
    fn range(&self) -> Range<usize> {
        self.first..self.first + self.beams
    }
}

impl Seen {
    fn add(&mut self, range_m: f64) {
        let is_first = self.returns == 0;
        self.nearest_m = if is_first { range_m } else { self.nearest_m.min(range_m) };
        self.farthest_m = self.farthest_m.max(range_m);
        self.sum_m += range_m;
        self.returns += 1;
    }
}

/// What all beams saw in the first scans.
struct FirstScans {
    seen: Vec<Seen>,
    scans: usize,
    step_rad: f64,
    full_turn: bool,
    /// The angle between the headings that lie farthest apart.
    turned_rad: f64,
}

impl FirstScans {
    fn sectors(&self) -> Vec<Sector> {
        let zeros_of_blind = |sector: &Sector| sector.range().map(|beam| self.at(beam).zeros).sum::<usize>();
        let zeros: usize = self.seen.iter().map(|seen| seen.zeros).sum();
        let is_blind = |sector: &Sector| {
            let sides = self.sides(sector);
            let is_wide = |least_rad: f64| sector.beams as f64 * self.step_rad >= least_rad;
            let is_sharp = sides.iter().all(|side| self.is_sharp(side));
            // A fan may be blind up to one of its ends, but not all over.
            let all_zero = zeros == zeros_of_blind(sector) && zeros == sector.beams * self.scans;
            is_wide(LEAST_RAD)
                && !sides.is_empty()
                && is_sharp
                && ((sides.iter().all(|side| self.has_moved(side)) && !self.may_be_a_passage(sector, &sides))
                    || (is_wide(LEAST_STANDING_RAD) && all_zero && sides.iter().all(|side| self.goes_on(side))))
        };
        self.silent().into_iter().filter(is_blind).collect()
    }

    /// The longest runs of beams that never returned; in a full turn one may go on from the last beam to the first.
    fn silent(&self) -> Vec<Sector> {
        let all = self.seen.len();
        let Some(start) = self.seen.iter().position(|seen| seen.returns > 0) else { return Vec::new() };
        let start = if self.full_turn { start } else { 0 };
        let mut runs: Vec<Sector> = Vec::new();
        for beam in start..start + all {
            if self.at(beam).returns > 0 {
                continue;
            }
            match runs.last_mut() {
                Some(run) if run.first + run.beams == beam => run.beams += 1,
                _ => runs.push(Sector { first: beam, beams: 1 }),
            }
        }
        runs
    }

    fn at(&self, beam: usize) -> &Seen {
        &self.seen[beam % self.seen.len()]
    }

    /// The beams beside a sector, from it on outwards; a fan has none beyond its ends.
    fn sides(&self, sector: &Sector) -> Vec<Vec<&Seen>> {
        let (all, count) = (self.seen.len(), SIDE_BEAMS.max(self.wall_beams() + 1));
        let after = (sector.range().end..).take(count);
        let before = (1..=count).map(|back| (sector.first + all).checked_sub(back));
        let beams = |beam: usize, is_there: bool| (self.full_turn || is_there).then(|| self.at(beam));
        let after: Vec<_> = after.map_while(|beam| beams(beam, beam < all)).collect();
        let before: Vec<_> = before.map_while(|beam| beam.and_then(|beam| beams(beam, beam >= all))).collect();
        [before, after].into_iter().filter(|side| side.len() >= SIDE_BEAMS).collect()
    }

    fn wall_beams(&self) -> usize {
        ((WALL_RAD / self.step_rad).round() as usize).max(1)
    }

    fn is_sharp(&self, side: &[&Seen]) -> bool {
        let mostly = |seen: &&&Seen| seen.returns as f64 >= MOST_SCANS_SHARE * self.scans as f64;
        side.iter().take(SIDE_BEAMS).filter(mostly).count() + 1 >= SIDE_BEAMS
    }

    /// Whether both walls run on into the dark, and the vehicle never looked there with other beams.
    fn may_be_a_passage(&self, sector: &Sector, sides: &[Vec<&Seen>]) -> bool {
        let runs_on = |side: &Vec<&Seen>| !self.goes_on(side);
        self.turned_rad < sector.beams as f64 * self.step_rad && sides.len() == 2 && sides.iter().all(runs_on)
    }

    fn has_moved(&self, side: &[&Seen]) -> bool {
        side.iter().take(SIDE_BEAMS).any(|seen| seen.returns > 0 && seen.farthest_m - seen.nearest_m > MOVED_M)
    }

    /// Whether the wall on this side is not seen at a grazing angle.
    fn goes_on(&self, side: &[&Seen]) -> bool {
        let mean_m = |seen: &&&Seen| (seen.returns > 0).then(|| seen.sum_m / seen.returns as f64);
        let (near_m, far_m) =
            (side.first().as_ref().and_then(mean_m), side.get(self.wall_beams()).as_ref().and_then(mean_m));
        near_m.zip(far_m).is_some_and(|(near_m, far_m)| near_m <= GRAZING * far_m)
    }
}

/// The angle between the headings of these scans that lie farthest apart, by how their ranges shift.
fn turned_rad(scans: &[&LaserScan]) -> f64 {
    let (mut heading, mut least, mut most) = (0, 0, 0);
    let mut from = scans[0];
    for scan in scans {
        // Slow turns add up to a beam only over several scans.
        match shift_beams(&from.ranges, scan) {
            Some(0) => {}
            shift => {
                heading += shift.unwrap_or(0);
                (from, least, most) = (scan, least.min(heading), most.max(heading));
            }
        }
    }
    (most - least) as f64 * f64::from(scans[0].angle_increment).abs()
}
