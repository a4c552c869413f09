//! Flights that are read as they come.

use std::path::{Path, PathBuf};

use crosscut_detector::Config;
use crosscut_ingest::{Feed, Following};
use crosscut_pipeline::StopFlag;

use super::files::{files_read, files_to_come};
use super::flight::Flight;
use crate::input::live::{Robot, RobotAddress, Robots, Silence, hear};
use crate::input::{InputArgs, LiveArgs};

/// A flight that is read as it comes.
pub(crate) struct Coming {
    pub(crate) flight: Flight,
    /// The robot that it comes from; it is heard until this is dropped.
    pub(crate) robot: Option<Box<dyn Robot>>,
    pub(crate) silence: Silence,
}

impl Coming {
    /// Opens `robot`, files that are followed, or standard input; `None` if the input is none of these.
    pub(crate) fn open(
        args: &InputArgs,
        live: &LiveArgs,
        robot: Option<&RobotAddress>,
        config: &Config,
        stop: &StopFlag,
        robots: Option<&dyn Robots>,
    ) -> anyhow::Result<Option<Self>> {
        let silence = Silence::new();
        let (stop, of_robot) = (stop.clone(), robot.map(|_| silence.clone()));
        let following = Following::until(move || {
            of_robot.iter().for_each(Silence::goes_on);
            stop.is_set()
        });
        let mut heard = None;
        let flight = match robot {
            Some(address) => {
                let (feed, messages) = Feed::of_robot();
                heard = Some(hear(address, robots, feed)?);
                Flight::of_robot(address, messages, args, config, &following)?
            }
            None if live.follow => Flight::follow(args, config, &following)?,
            None if is_piped(args) => Flight::of_standard_input(args, config, &following)?,
            None => return Ok(None),
        };
        Ok(Some(Self { flight, robot: heard, silence }))
    }
}

/// Whether the input is standard input.
fn is_piped(args: &InputArgs) -> bool {
    args.recordings.input == [Path::new("-")]
}

/// The recordings that a command reads as [`Coming::open`] does, and its files of settings, which no output may replace.
pub(crate) fn files_of(
    args: &InputArgs,
    live: &LiveArgs,
    robot: Option<&RobotAddress>,
    settings: impl IntoIterator<Item = PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    let may_come_later = live.follow || is_piped(args) || robot.is_some();
    if may_come_later { files_to_come(args, settings) } else { files_read(args, settings) }
}
