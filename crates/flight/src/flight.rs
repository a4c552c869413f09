//! A whole flight, revolution by revolution.

use crosscut_stage::{Count, Frame, ParamSpec, Params};

use crate::FlightAnswer;
use crate::here::{PLACE_PARAMS, Places};
use crate::pose::{POSE_PARAMS, PoseTracker};
use crate::steady::Steadier;

/// How many revolutions after each its steady answer rests on. [`Flight::add`] looks at none.
pub const LOOK_AHEAD: Count = Count::new("look_ahead", "revolutions", 0)
    .from(0)
    .to(1000)
    .doc("of a recording, the steady answer rests on this many later scans, too; 10 are enough; 0: as on a robot");

/// Section `flight` of the configuration.
pub const PARAMS: &[ParamSpec] = &{
    let ([pose, share], [widths]) = (POSE_PARAMS, PLACE_PARAMS);
    [pose, share, widths, LOOK_AHEAD.spec]
};

/// A setting needs scans that are not there yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("flight.look_ahead is for recordings: a scan that was just taken has none after it")]
pub struct LooksAhead;

/// Refuses settings that only the flight of a recording can keep to.
///
/// # Errors
/// If the steady answer is to rest on later scans.
pub fn check_live(params: &Params) -> Result<(), LooksAhead> {
    if params.get(LOOK_AHEAD) > 0 { Err(LooksAhead) } else { Ok(()) }
}

/// Adds to each frame of a flight what the flight so far shows.
///
/// ```
/// use crosscut_flight::{Flight, FlightAnswer, PARAMS};
/// use crosscut_stage::{Frame, Params};
///
/// let mut flight = Flight::new(&Params::defaults(PARAMS), 0.6);
/// let mut frame = Frame::default(); // filled by the four stages
/// flight.add(&mut frame);
/// assert_eq!(FlightAnswer::of(&frame).here, None, "there is no wall");
/// ```
#[derive(Clone, Debug)]
pub struct Flight {
    poses: PoseTracker,
    places: Places,
    steadier: Steadier,
}

impl Flight {
    /// From checked values of [`PARAMS`], for a vehicle of this width.
    pub fn new(params: &Params, vehicle_width_m: f64) -> Self {
        Self {
            poses: PoseTracker::new(params),
            places: Places::new(params, vehicle_width_m),
            steadier: Steadier::default(),
        }
    }

    /// Fills the pose, the place and the steady answer of the next frame, which the four stages have filled. Notes are
    /// added to those that are there.
    pub fn add(&mut self, frame: &mut Frame) {
        self.place(frame);
        self.steady(frame, std::iter::empty());
    }

    /// The first half of [`Flight::add`]: pose and place of the next frame.
    pub fn place(&mut self, frame: &mut Frame) {
        let tracked = self.poses.add(&frame.revolution, &mut frame.notes);
        let pose = tracked.map(|tracked| tracked.pose);
        if tracked.is_some_and(|tracked| tracked.lost) {
            self.places.forget();
        }
        let here = self.places.here(&frame.revolution, &frame.junction, tracked.as_ref());
        let doubt = tracked.map(|tracked| tracked.doubt);
        FlightAnswer { pose, doubt, here, steady: None }.put(frame);
    }

    /// The second half: the steady answer of the next frame. `later`: frames after it, in order, whose pose and place are
    /// filled.
    pub fn steady<'f>(&mut self, frame: &mut Frame, later: impl Iterator<Item = &'f Frame>) {
        let steady = self.steadier.add(frame, later);
        FlightAnswer { steady, ..FlightAnswer::of(frame).clone() }.put(frame);
    }
}
