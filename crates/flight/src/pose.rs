//! Where each revolution was taken, by the chosen kind of pose.

use nalgebra::{Isometry2, Matrix2, Matrix3, Point2, Vector3};

use crosscut_stage::NoteCode::{self, N090, N091, N092, N093, N095, N097, N098, N103};
use crosscut_stage::{MotionDoubt, Notes, Number, ParamSpec, Params, PoseDoubt, Revolution, Word, is_finite_pose};

use crate::agreement::{Compared, OdometryAgreement, Slip};
use crate::directions::{Directions, Wrong};
use crate::gap::{Break, Clock};
use crate::scan_match::NEIGHBOURS_M;
use crate::{Held, Matched, Motion, ScanMatcher};

const POSE: Word = Word::one_of("pose", &["auto", "odometry", "scan_match", "odometry_scan_match", "none"])
    .doc("odometry, scans matched to the walls seen before, or both; auto: both where there is odometry, else scans");

const ODOMETRY_SHARE: Number = Number::new("odometry_share", "", 0.05)
    .above(0.0)
    .to(1.0)
    .doc("standard deviation of the odometry's motion between two revolutions, as a share of it");

/// Added to the standard deviation of the odometry's motion, m, and to that of its turn, rad.
const ODOMETRY_FLOOR: f64 = 0.005;

/// Parameters of the pose.
pub(crate) const POSE_PARAMS: [ParamSpec; 2] = [POSE.spec, ODOMETRY_SHARE.spec];

/// A motion farther than this many standard deviations from steady motion, where nothing else predicts it, is noted as a jump.
const SURPRISING: f64 = 6.0;

/// Errors of poses that are matched to walls, for each metre of the way and for each radian that the vehicle turns; of the
/// heading by odometry, for each metre (variances).
const WALLS_M2_PER_M: f64 = 0.03 * 0.03;
const WALLS_RAD2_PER_M: f64 = 0.0015 * 0.0015;
const WALLS_RAD2_PER_RAD: f64 = 0.015 * 0.015;
const ODOMETRY_RAD2_PER_M: f64 = 0.009 * 0.009;

/// A turn of a standing vehicle from scan to scan is less than this: it trembles, and no error adds up.
const TREMBLES_RAD: f64 = 0.005;

/// A step of the odometry below this is none, in m and rad: equal poses differ by as much once they are interpolated.
const MOVED: f64 = 1e-6;

/// After a break, odometry that leads across it may come up to this many revolutions late.
const WAITED: u32 = 5;

/// Gives each revolution of a flight its pose.
#[derive(Clone, Debug)]
pub struct PoseTracker {
    kind: PoseKind,
    odometry_share: f64,
    matcher: ScanMatcher,
    agreement: OdometryAgreement,
    directions: Directions,
    /// What was found to be wrong with them.
    wrong: Option<Wrong>,
    clock: Clock,
    /// The last revolution that had odometry.
    aided: Option<Aided>,
    /// The odometry has moved since the first. Before that it predicts nothing: some never moves.
    has_moved: bool,
    /// A break that nothing leads across yet, and how many revolutions there were since.
    open: Option<(Break, u32)>,
    pose: Isometry2<f64>,
    /// The last motion.
    step: Isometry2<f64>,
    doubt: PoseDoubt,
    /// What was guessed of the way since the walls last held the pose, metres.
    guessed_m: f64,
}

/// What was known at a revolution that had odometry.
#[derive(Clone, Copy, Debug)]
struct Aided {
    odometry: Isometry2<f64>,
    pose: Isometry2<f64>,
    doubt: PoseDoubt,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PoseKind {
    Auto,
    Odometry,
    ScanMatch,
    OdometryScanMatch,
    None,
}

/// The pose of one revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// In the frame of the first revolution.
    pub pose: Isometry2<f64>,
    /// How far it may be off.
    pub doubt: PoseDoubt,
    /// The scan does not go with those before: what was seen from earlier poses does not lie where it did.
    pub lost: bool,
}

impl PoseTracker {
    /// From checked values of [`PARAMS`](crate::PARAMS).
    pub fn new(params: &Params) -> Self {
        let kind = match params.get(POSE).as_str() {
            "odometry" => PoseKind::Odometry,
            "scan_match" => PoseKind::ScanMatch,
            "odometry_scan_match" => PoseKind::OdometryScanMatch,
            "none" => PoseKind::None,
            _ => PoseKind::Auto,
        };
        Self {
            kind,
            odometry_share: params.get(ODOMETRY_SHARE),
            matcher: ScanMatcher::default(),
            agreement: OdometryAgreement::default(),
            directions: Directions::default(),
            wrong: None,
            clock: Clock::default(),
            aided: None,
            has_moved: false,
            open: None,
            pose: Isometry2::identity(),
            step: Isometry2::identity(),
            doubt: PoseDoubt::default(),
            guessed_m: 0.0,
        }
    }

    /// The pose of the next revolution, with what was odd in `notes`: a slip or a jump, a lost map, missing odometry, a gap,
    /// odometry and scans that contradict each other. `None` without a source for it, as before the first walls; scans of
    /// clouds are not matched.
    pub fn add(&mut self, revolution: &Revolution, notes: &mut Notes) -> Option<Tracked> {
        if self.kind == PoseKind::None {
            return None;
        }
        let odometry = revolution.odometry.filter(is_finite_pose);
        if odometry.is_none() && revolution.odometry.is_some() {
            notes.add(N090, "pose: the odometry is not finite");
        }
        let had_odometry = self.aided.is_some() || odometry.is_some();
        let step = self.aided.zip(odometry).map(|(before, now)| before.odometry.inv_mul(&now));
        let moves = |step: Isometry2<f64>| step.translation.vector.norm().max(step.rotation.angle().abs()) > MOVED;
        self.has_moved |= step.is_some_and(moves);
        let motion = self.aided.zip(step).map(|(there, step)| self.motion(there.pose, step));
        let mut motion = motion.filter(|_| self.kind != PoseKind::ScanMatch);
        let mut begins = false;
        if let Some(gap) = self.clock.gap(revolution.stamp_ns) {
            self.open = Some((Break::Gap(gap), 0));
        }
        if let Some((open, since)) = self.open.take_if(|(open, _)| open.is_back() || motion.is_none()) {
            if self.waits(open, since, notes) {
                return None;
            }
            self.matcher.forget();
            (motion, begins) = (None, true);
        }
        self.open = None;
        let by_odometry = self.kind == PoseKind::Odometry || revolution.beams().is_none();
        let (pose, mut doubt) = if by_odometry {
            if !had_odometry {
                if self.kind != PoseKind::Auto {
                    notes.add(N091, "pose: no odometry yet");
                }
                return None;
            }
            if odometry.is_none() {
                notes.add(N092, "pose: no odometry at this time; the pose before");
            }
            let pose = motion.map_or(self.pose, |motion| self.pose * motion.step);
            (pose, self.by_odometry(&pose))
        } else {
            let is_expected = match self.kind {
                PoseKind::Auto => had_odometry,
                kind => kind == PoseKind::OdometryScanMatch,
            };
            if odometry.is_none() && is_expected {
                notes.add(N093, "pose: no odometry at this time; by the scan alone");
            }
            let mut matched = self.matcher.add(revolution, motion.filter(|_| self.has_moved));
            if matched.lost {
                if self.waits(Break::Lost { matched: matched.matched }, 0, notes) {
                    return None;
                }
                begins = true;
                self.matcher.forget();
                matched = self.matcher.add(revolution, None);
            }
            notes.extend(self.matcher.own_returns_note());
            let mut doubt = self.by_scan(&matched, motion.is_some());
            if let Some(known_m) = matched.guess_known_m {
                doubt.guessed_m = known_m - self.guessed_m;
            }
            self.guessed_m = if matched.held == Held::Everywhere { 0.0 } else { self.guessed_m + doubt.guessed_m };
            if matched.surprise > SURPRISING && motion.is_none() {
                let times = matched.surprise;
                notes.add(N095, format!("pose: a slip or a jump, {times:.0} standard deviations from steady motion"));
            }
            notes.extend(motion.and_then(|motion| self.turned(&motion, &matched, revolution)));
            notes.extend(self.slip(motion.as_ref(), &matched));
            notes.extend(self.unknown_length(&matched, motion.is_some()));
            notes.extend(motion.and_then(|motion| self.compare(&motion, &matched)));
            (matched.pose, doubt)
        };
        if begins {
            self.doubt = PoseDoubt::of_stretch(self.doubt.stretch + 1);
            self.guessed_m = 0.0;
        } else {
            // What was guessed since there was odometry last, odometry shows now.
            if let Some(aided) = self.aided.filter(|_| motion.is_some() && self.has_moved)
                && self.doubt.measured(&aided.doubt)
            {
                self.guessed_m = 0.0;
                doubt.lasting_m += self.agreement.share(self.odometry_share)
                    * (self.pose.translation.vector - aided.pose.translation.vector);
            }
            self.doubt.add(&doubt, Point2::from(pose.translation.vector));
        }
        self.step = self.pose.inv_mul(&pose);
        self.pose = pose;
        let aided = odometry.map(|odometry| Aided { odometry, pose, doubt: self.doubt });
        self.aided = aided.or(self.aided.filter(|_| !begins));
        let is_known = by_odometry || motion.is_some() || begins || self.matcher.has_walls();
        is_known.then_some(Tracked { pose, doubt: self.doubt, lost: begins })
    }

    /// Whether odometry may still lead across a break, so many revolutions after it; else a new stretch begins.
    fn waits(&mut self, open: Break, since: u32, notes: &mut Notes) -> bool {
        let may_lead = self.aided.is_some() && self.kind != PoseKind::ScanMatch && !open.is_back();
        let waits = may_lead && since < WAITED;
        self.open = waits.then_some((open, since + 1));
        let what = match waits {
            true => ", and no odometry yet that leads across",
            false => "; a new stretch begins, how it lies to the one before is not known",
        };
        notes.add(open.code(), format!("pose: {open}{what}"));
        waits
    }

    /// The motion since the revolution before, by a step of the odometry from the pose `there`.
    fn motion(&self, there: Isometry2<f64>, step: Isometry2<f64>) -> Motion {
        // Odometry may stand still where the vehicle does not.
        let moved_m = step.translation.vector.norm().max(self.step.translation.vector.norm());
        let turned_rad = step.rotation.angle().abs().max(self.step.rotation.angle().abs());
        let deviation_m = ODOMETRY_FLOOR + self.odometry_share * moved_m;
        let deviation_rad = ODOMETRY_FLOOR + self.odometry_share * turned_rad;
        let deviations = Vector3::new(deviation_m, deviation_m, deviation_rad);
        let covariance = Matrix3::from_diagonal(&deviations.component_mul(&deviations));
        let step = self.pose.inv_mul(&(there * step));
        // By its angle: a rotation that is multiplied by the inverse of its like is a unit ever less.
        Motion { step: Isometry2::new(step.translation.vector, step.rotation.angle()), covariance }
    }

    /// What a motion that the odometry alone shows adds to the doubt.
    fn by_odometry(&self, pose: &Isometry2<f64>) -> MotionDoubt {
        let moved_m = pose.translation.vector - self.pose.translation.vector;
        let share = self.agreement.share(self.odometry_share);
        let turned_rad = share * self.pose.rotation.angle_to(&pose.rotation);
        let turn_rad2 = ODOMETRY_RAD2_PER_M * moved_m.norm() + turned_rad * turned_rad;
        MotionDoubt { lasting_m: share * moved_m, turn_rad2, ..MotionDoubt::default() }
    }

    /// What a motion that a scan shows adds to the doubt: where the walls do not hold it, it is as good as the prediction.
    fn by_scan(&self, matched: &Matched, has_odometry: bool) -> MotionDoubt {
        let moved_m = matched.pose.translation.vector - self.pose.translation.vector;
        let (way_m, share) = (moved_m.norm(), self.agreement.share(self.odometry_share));
        let turned_rad = (self.pose.rotation.angle_to(&matched.pose.rotation).abs() - TREMBLES_RAD).max(0.0);
        let by_walls = MotionDoubt {
            independent_m2: Matrix2::identity() * WALLS_M2_PER_M * way_m,
            turn_rad2: WALLS_RAD2_PER_M * way_m + WALLS_RAD2_PER_RAD * turned_rad,
            ..MotionDoubt::default()
        };
        match matched.held {
            Held::Everywhere => by_walls,
            Held::ButAlong(along) if has_odometry => {
                MotionDoubt { lasting_m: along.into_inner() * share * along.dot(&moved_m), ..by_walls }
            }
            Held::ButAlong(along) => MotionDoubt { guessed_m: deviation_m(matched, &along), ..by_walls },
            Held::Nowhere if has_odometry => {
                let by_odometry = self.by_odometry(&matched.pose);
                MotionDoubt {
                    independent_m2: matched.by_odometry.fixed_view::<2, 2>(0, 0).into_owned(),
                    turn_rad2: by_odometry.turn_rad2 + matched.by_odometry[(2, 2)],
                    ..by_odometry
                }
            }
            Held::Nowhere => MotionDoubt { guessed_m: deviation_m(matched, &nalgebra::Vector2::x_axis()), ..by_walls },
        }
    }

    /// Says once more that the length is not known, for as long as it is so.
    fn unknown_length(&self, matched: &Matched, has_odometry: bool) -> Option<(NoteCode, &'static str)> {
        let is_guessed = matches!(matched.held, Held::ButAlong(_)) && !has_odometry;
        let is_unknown = is_guessed && self.doubt.sd_m(Point2::from(matched.pose.translation.vector)).is_none();
        is_unknown.then_some((N097, "pose: the walls do not show how far along the passage; its length is not known"))
    }

    /// Directions that are wrong, in the revolution that shows it.
    fn turned(&mut self, odometry: &Motion, matched: &Matched, of: &Revolution) -> Option<(NoteCode, String)> {
        if !is_compared(odometry, matched) {
            return None;
        }
        self.directions.add(&odometry.step, &self.pose.inv_mul(&matched.pose));
        let fan = of.sweep.as_ref()?.fan?;
        // Only a turn of the vehicle shows that a scan is mirrored.
        let is_new = |wrong: &Wrong| self.wrong.is_none_or(|known| wrong.is_mirrored && !known.is_mirrored);
        let wrong = self.directions.wrong().filter(is_new)?;
        self.wrong = Some(wrong);
        Some((N103, wrong.described(&fan)))
    }

    /// A slip of the wheels, or a jump.
    fn slip(&mut self, odometry: Option<&Motion>, matched: &Matched) -> Option<(NoteCode, String)> {
        let is_held = matched.held == Held::Everywhere && !self.agreement.contradicts();
        let Some(odometry) = odometry.filter(|_| is_held) else {
            self.agreement.interrupt();
            return None;
        };
        let slip = self.agreement.slip(odometry, &self.pose.inv_mul(&matched.pose), self.odometry_share);
        let is_of_motion =
            |slip: &Slip| self.wrong.is_none() && !self.directions.may_explain(slip.odometry, slip.scans);
        let Slip { odometry, scans, deviations } = slip.filter(is_of_motion)?;
        let moved = |[way_m, turn_rad]: [f64; 2]| format!("{way_m:.1} m and {:.0} degrees", turn_rad.to_degrees());
        let (odometry, scans) = (moved(odometry), moved(scans));
        let apart = format!("{deviations:.0} standard deviations apart");
        Some((N095, format!("pose: a slip or a jump: the odometry moved by {odometry}, the scans by {scans}, {apart}")))
    }

    /// Compares odometry and scans, and what there is to note about it.
    fn compare(&mut self, odometry: &Motion, matched: &Matched) -> Option<(NoteCode, String)> {
        if !is_compared(odometry, matched) {
            return None;
        }
        let Compared { odometry_m, scans_m, contradicts, is_new } =
            self.agreement.add(&odometry.step, &self.pose.inv_mul(&matched.pose))?;
        let what = match (contradicts, is_new) {
            _ if self.wrong.is_some() => return None,
            (true, _) => "they contradict each other",
            (false, true) => "they agree again",
            (false, false) => return None,
        };
        let moved = format!("the odometry moved by {odometry_m:.1} m, the scans by {scans_m:.1} m");
        Some((N098, format!("pose: {moved}: {what}")))
    }
}

/// Whether a motion of the scans can be compared with that of the odometry.
fn is_compared(odometry: &Motion, matched: &Matched) -> bool {
    let are_neighbours = odometry.step.translation.vector.norm() < NEIGHBOURS_M;
    matched.held == Held::Everywhere && are_neighbours
}

/// The standard deviation of a motion along a direction, metres.
fn deviation_m(matched: &Matched, along: &nalgebra::Unit<nalgebra::Vector2<f64>>) -> f64 {
    let position = matched.covariance.fixed_view::<2, 2>(0, 0);
    along.dot(&(position * along.into_inner())).max(0.0).sqrt()
}
