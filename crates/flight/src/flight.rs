//! A whole flight, revolution by revolution.

use crosscut_stage::{Frame, ParamSpec, Params};

use crate::FlightAnswer;
use crate::beyond::Beyond;
use crate::here::{PLACE_PARAMS, Places};
use crate::pose::{POSE_PARAMS, PoseTracker};
use crate::rays::Rays;
use crate::steady::Steadier;
use crate::surroundings::Surroundings;

/// Section `flight` of the configuration.
pub const PARAMS: &[ParamSpec] = &{
    let ([pose, share], [widths]) = (POSE_PARAMS, PLACE_PARAMS);
    [pose, share, widths]
};

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
    surroundings: Surroundings,
    beyond: Beyond,
    steadier: Steadier,
}

impl Flight {
    /// From checked values of [`PARAMS`], for a vehicle of this width.
    pub fn new(params: &Params, vehicle_width_m: f64) -> Self {
        Self {
            poses: PoseTracker::new(params),
            places: Places::new(params, vehicle_width_m),
            surroundings: Surroundings::default(),
            beyond: Beyond::new(vehicle_width_m),
            steadier: Steadier::default(),
        }
    }

    /// Fills the pose, the place and the steady answer of the next frame, which the four stages have filled. Notes are
    /// added to those that are there.
    pub fn add(&mut self, frame: &mut Frame) {
        let tracked = self.poses.add(&frame.revolution, &mut frame.notes);
        if tracked.is_some_and(|tracked| tracked.lost) {
            self.surroundings.clear();
        }
        let (revolution, junction) = (&frame.revolution, &frame.junction);
        let rays = Rays::of(revolution, junction);
        if let Some((tracked, rays)) = tracked.as_ref().zip(rays.as_ref()) {
            self.surroundings.add(tracked, revolution.stamp_ns, rays);
        }
        let seen = tracked.as_ref().map(|tracked| (&self.surroundings, &tracked.pose));
        let of_rays = rays.as_ref().zip(seen).map(|(rays, (around, pose))| (rays, around, pose));
        let openings = self.beyond.openings(junction, revolution.stamp_ns, of_rays);
        let sweep = revolution.beams().zip(rays);
        let here = sweep.and_then(|(sweep, rays)| self.places.here(sweep, junction, &openings, rays, seen));
        let (pose, doubt) = (tracked.map(|tracked| tracked.pose), tracked.map(|tracked| tracked.doubt));
        let mut answer = FlightAnswer { pose, doubt, here, steady: None };
        answer.steady = self.steadier.add(frame, &answer, &openings);
        answer.put(frame);
    }
}
