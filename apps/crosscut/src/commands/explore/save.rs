//! The recording of a mission for the Rerun viewer.

use crosscut_detector::Config;
use crosscut_flight::FlightAnswer;
use crosscut_missions::{Flown, Moment};
use crosscut_recorder::{MissionDecision, MissionMoment, MissionRecorder, RecorderError, RecorderOptions, TrueWalls};
use crosscut_simulator::World;
use crosscut_stage::ObserverError;
use nalgebra::{Isometry2, Point2};

use super::args::ExploreArgs;
use super::outcome;
use crate::diagnostics::Diagnostics;
use crate::output::observers;

/// The map is drawn anew after this many revolutions: it costs more than all else.
const MAP_EVERY: u64 = 20;

/// A mission that is recorded.
pub(super) struct Saved {
    recorder: MissionRecorder,
    truths: TrueWalls,
    failed: Option<ObserverError>,
}

impl Saved {
    /// The recording of a mission, if one is requested. If it cannot be opened, the mission is flown without it.
    pub(super) fn open(
        args: &ExploreArgs,
        name: &str,
        config: &Config,
        world: &World,
        diagnostics: &mut Diagnostics,
    ) -> Option<Self> {
        let options = RecorderOptions {
            path: args.save.clone(),
            source: format!("mission {name}, seed {}, preset {}", args.seed.start(), args.config.preset()),
            ..observers::recorder_options(name.to_owned(), config)
        };
        let created = args.save.is_some().then(|| Self::create(options, world)).transpose();
        diagnostics.lost_all(created.as_ref().err());
        created.unwrap_or_default()
    }

    fn create(options: RecorderOptions, world: &World) -> Result<Self, RecorderError> {
        let start = world.start;
        let home = Isometry2::new(start.position_m.coords, start.heading_rad).inverse();
        let segments = world.mine.surface().segments().iter();
        let mine_m: Vec<[Point2<f64>; 2]> =
            segments.map(|segment| [home * segment.from_m, home * segment.to_m]).collect();
        let truths = options.truth.clone();
        Ok(Self { recorder: MissionRecorder::new(options, &mine_m)?, truths, failed: None })
    }

    pub(super) fn add(&mut self, moment: &Moment) {
        if self.failed.is_some() {
            return;
        }
        let frame = moment.frame;
        let truth = (moment.scene)().truth;
        let json = String::from_utf8(truth.to_json()).unwrap_or_default();
        self.truths.tell(frame.revolution.seq, truth.walls as usize, json);
        let map = frame.revolution.seq.is_multiple_of(MAP_EVERY).then(|| moment.mapper.map());
        let (tracked, correction) = (FlightAnswer::of(frame).pose.unwrap_or_default(), moment.step.correction);
        let decision = moment.step.decision.as_ref().map(|decision| MissionDecision {
            place: decision.place,
            bearing_rad: decision.bearing_rad + correction.rotation.angle(),
            why: &decision.why,
        });
        let (vehicle, goal_m) = (correction * tracked, correction * moment.step.goal_m);
        let moment = MissionMoment { frame, vehicle, goal_m, doing: moment.step.doing, decision, map };
        self.failed = self.recorder.add(&moment).err();
    }

    /// Ends the file with what became of the mission, and returns the first error.
    pub(super) fn finish(mut self, flown: &Flown) -> Result<(), ObserverError> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => self.recorder.finish(&outcome::markdown(flown)),
        }
    }
}
