//! Where each beam of a scan looks.

use std::f64::consts::{PI, TAU};

use crosscut_messages::LaserScan;
use crosscut_stage::NoteCode::{N014, N015, N016, N017, N018, N019, N020, N028};
use crosscut_stage::{self as stage, Notes};

/// A finer step cannot be told from none: f32 angles near π are 2.4e-7 apart.
const LEAST_STEP_RAD: f64 = 1e-6;

/// An `angle_min` beyond this is no angle, or one in degrees.
const LARGEST_ANGLE_RAD: f64 = 2.0 * TAU;

/// Angles of fewer steps do not show that they are in degrees.
const LEAST_DEGREE_STEPS: f64 = 8.0;

/// A turn that is no shorter than by this is full: a driver had room for as many beams as fit, or left some out.
const SHORT_RAD: f64 = 5.0 * PI / 180.0;

/// Bearings of the beams in the sensor's frame: beam i looks at `first + i * increment`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScanFan {
    first_rad: f64,
    /// Negative when the sensor turns clockwise.
    increment_rad: f64,
    /// The beams before the one that would look again where the first one looks.
    beams_in_turn: usize,
    /// A turn that is no shorter than by this is full.
    short_rad: f64,
}

impl ScanFan {
    /// The bearings of `scan`; `None`, with a note, if there are none to be had.
    pub(crate) fn new(scan: &LaserScan, notes: &mut Notes) -> Option<Self> {
        let beams = scan.ranges.len();
        if beams == 0 {
            notes.add(N014, "the scan has no beams");
            return None;
        }
        let scan = &in_radians(scan, notes);
        let first_rad = f64::from(scan.angle_min);
        let is_angle = first_rad.abs() <= LARGEST_ANGLE_RAD;
        if !is_angle {
            notes.add(N015, format!("angle_min {} is no angle in rad: no beam has a bearing", scan.angle_min));
            return None;
        }
        if beams == 1 {
            return Some(Self { first_rad, increment_rad: TAU, beams_in_turn: 1, short_rad: SHORT_RAD });
        }
        let increment_rad = increment_rad(scan, notes)?;
        let beams_in_turn = in_turn(increment_rad, beams);
        match beams - beams_in_turn {
            0 => {}
            1 => notes.add(N016, "the last beam looks where the first one does: left out"),
            more => notes.add(N017, format!("{more} beams beyond a full turn left out")),
        }
        Some(Self { first_rad, increment_rad, beams_in_turn, short_rad: SHORT_RAD })
    }

    /// The bearings in the frame of the middle beam, if the sensor turns by `rad_per_beam` from one beam to the next. A
    /// full turn stays one, also where it falls short of 360° by the angle that the sensor turned.
    pub(crate) fn turned(self, rad_per_beam: f64, beams: usize) -> Self {
        let increment_rad = self.increment_rad + rad_per_beam;
        let is_turned = rad_per_beam != 0.0 && increment_rad * self.increment_rad > 0.0;
        if !is_turned {
            return self;
        }
        let fell_short_rad = if self.missing().is_some() { beams as f64 * rad_per_beam.abs() } else { 0.0 };
        Self {
            first_rad: self.first_rad - 0.5 * (beams - 1) as f64 * rad_per_beam,
            increment_rad,
            beams_in_turn: in_turn(increment_rad, self.beams_in_turn),
            short_rad: SHORT_RAD + fell_short_rad,
        }
    }

    /// Its beams in the body frame, of a sensor that is mounted like this.
    pub(crate) fn mounted(&self, yaw_rad: f64, upside_down: bool) -> stage::Fan {
        let Self { first_rad, increment_rad, .. } = *self;
        stage::Fan { yaw_rad, upside_down, first_rad, increment_rad }
    }

    /// How many beams there are before the one that would look again where the first one looks.
    pub(crate) fn beams_in_turn(&self) -> usize {
        self.beams_in_turn
    }

    pub(crate) fn step_rad(&self) -> f64 {
        self.increment_rad.abs()
    }

    /// How many beams are missing between the last one and the first: none where the gap is about one step. `None` if
    /// that is a limited view.
    pub(crate) fn missing(&self) -> Option<usize> {
        let steps = (TAU / self.step_rad() - self.beams_in_turn as f64).max(0.0).round();
        (self.beams_in_turn > 2 && steps * self.step_rad() <= self.short_rad).then_some(steps as usize)
    }
}

/// The angles that a scan states.
struct Angles {
    angle_min: f32,
    angle_max: f32,
    angle_increment: f32,
    beams: usize,
}

/// The angles of a scan. Those that make no sense as radians, and agree with each other and the number of beams as degrees,
/// are degrees.
fn in_radians(scan: &LaserScan, notes: &mut Notes) -> Angles {
    let LaserScan { angle_min, angle_max, angle_increment, .. } = *scan;
    let steps = scan.ranges.len().saturating_sub(1) as f64;
    let fits = |to_rad: f64, step_to_rad: f64| {
        let (span_rad, step_rad) =
            (f64::from(angle_max - angle_min) * to_rad, f64::from(angle_increment) * step_to_rad);
        let is_turn =
            (f64::from(angle_min) * to_rad).abs() <= TAU && (steps * step_rad).abs() <= TAU + 1.5 * step_rad.abs();
        step_rad.abs() >= LEAST_STEP_RAD && is_turn && (steps * step_rad - span_rad).abs() <= 1.5 * step_rad.abs()
    };
    let is_odd =
        f64::from(angle_min).abs() > LARGEST_ANGLE_RAD || (steps * f64::from(angle_increment)).abs() > 2.0 * TAU;
    let degree = 1f64.to_radians();
    let [to_rad, step_to_rad] = if steps < LEAST_DEGREE_STEPS || !is_odd {
        [1.0; 2]
    } else if fits(degree, degree) {
        notes.add(N028, "angle_min, angle_max and angle_increment are in degrees");
        [degree; 2]
    } else if fits(1.0, degree) {
        notes.add(N028, format!("angle_increment {angle_increment} is in degrees"));
        [1.0, degree]
    } else if fits(degree, 1.0) {
        notes.add(N028, "angle_min and angle_max are in degrees");
        [degree, 1.0]
    } else {
        [1.0; 2]
    };
    let scaled = |angle: f32, factor: f64| if factor == 1.0 { angle } else { (f64::from(angle) * factor) as f32 };
    Angles {
        angle_min: scaled(angle_min, to_rad),
        angle_max: scaled(angle_max, to_rad),
        angle_increment: scaled(angle_increment, step_to_rad),
        beams: scan.ranges.len(),
    }
}

/// How many of `beams` are before the one that would look again where the first one looks. Half a step of room, since
/// the increment is rounded to f32.
fn in_turn(increment_rad: f64, beams: usize) -> usize {
    beams.min((TAU / increment_rad.abs() - 0.5).ceil() as usize)
}

/// The increment as stated, else as it follows from the first and the last bearing; `None`, with a note, if neither
/// makes sense. Needs two beams.
fn increment_rad(scan: &Angles, notes: &mut Notes) -> Option<f64> {
    let usable = |increment_rad: f64| (LEAST_STEP_RAD..=PI).contains(&increment_rad.abs());
    let steps = (scan.beams - 1) as f64;
    let span_rad = f64::from(scan.angle_max) - f64::from(scan.angle_min);
    let stated_rad = f64::from(scan.angle_increment);
    if usable(stated_rad) {
        // Many drivers give the end one step past the last beam; that is no contradiction.
        let fits = (steps * stated_rad - span_rad).abs() <= 1.5 * stated_rad.abs();
        if !fits {
            notes.add(
                N018,
                format!(
                    "angle_max {} does not fit {} beams: bearings are those of angle_min and angle_increment",
                    scan.angle_max, scan.beams
                ),
            );
        }
        return Some(stated_rad);
    }
    let derived_rad = span_rad / steps;
    if usable(derived_rad) && span_rad.abs() <= TAU + derived_rad.abs() {
        notes
            .add(N019, format!("angle_increment {} replaced by (angle_max - angle_min) / steps", scan.angle_increment));
        Some(derived_rad)
    } else {
        notes.add(
            N020,
            format!(
                "angle_increment {} and angle_max {} are unusable: no beam has a bearing",
                scan.angle_increment, scan.angle_max
            ),
        );
        None
    }
}
