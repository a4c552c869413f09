//! Live robots. The program knows no network: whoever runs it brings what hears and answers robots.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crosscut_detector::Config;
use crosscut_ingest::Feed;
use crosscut_stage::counted;

use super::args::{InputArgs, LiveArgs, live_input, without_query};
use crate::exit::UsageError;
use crate::output::{looking::quoted, say};

/// After so long without a scan, that is said.
const SILENCE: Duration = Duration::from_secs(2);

/// A robot to be heard.
#[derive(Clone, Debug)]
pub struct RobotAddress {
    /// `zenoh://HOST[:PORT]/TOPIC[?domain=N][&config=FILE.json5]` or `ros2://DOMAIN/TOPIC`.
    pub address: String,
    /// The topic in it.
    pub topic: String,
    /// Further topics whose messages are wanted: other scanners, odometry, transforms.
    pub beside: Vec<String>,
    /// The topic is a key of plain messages of this type.
    pub message_type: Option<String>,
    /// Answers are sent below this key.
    pub publish: Option<String>,
}

/// Why a robot cannot be heard.
#[derive(Clone, Debug)]
pub enum RobotError {
    /// What was asked for is wrong, or a package is not installed.
    Usage(String),
    /// There is no robot, or no network.
    Failed(String),
}

/// An answer on its way to a robot.
#[derive(Clone, Copy, Debug)]
pub enum Answer<'a> {
    /// A line of results, JSON.
    Results(&'a str),
    /// The map so far, JSON.
    Map(&'a str),
    /// A drawing: `visualization_msgs/MarkerArray` in CDR.
    Markers(&'a [u8]),
}

/// Hears robots.
pub trait Robots: Sync {
    /// Puts the messages of a robot into `feed` from now on, until what is returned is dropped.
    ///
    /// # Errors
    /// When it cannot be heard.
    fn hear(&self, robot: &RobotAddress, feed: Feed) -> Result<Box<dyn Robot>, RobotError>;
}

/// A robot that is heard.
pub trait Robot: Send {
    /// Sends an answer.
    ///
    /// # Errors
    /// When it cannot be sent: why.
    fn send(&mut self, answer: Answer<'_>) -> Result<(), String>;
}

/// Refuses a live robot, for a command that reads its input from the start to the end, or more than once.
pub(crate) fn refuse_live(args: &InputArgs) -> Result<(), UsageError> {
    match live_input(args) {
        Some(robot) => {
            let robot = robot.display();
            Err(UsageError(format!("{robot} is a live robot, which `crosscut run` and `crosscut compare` hear")))
        }
        None => Ok(()),
    }
}

/// The robot that a command is asked to hear, and to `publish` answers to; `None` if its input is recorded.
pub(crate) fn robot_of(
    args: &InputArgs,
    live: &LiveArgs,
    publish: Option<&String>,
    config: &Config,
) -> Result<Option<RobotAddress>, UsageError> {
    let usage = |text: String| Err(UsageError(text));
    let Some(input) = live_input(args) else {
        return match publish {
            Some(_) => usage("--publish is for live robots: zenoh://HOST/TOPIC, ros2://DOMAIN/TOPIC".to_owned()),
            None => Ok(None),
        };
    };
    let address = input.display().to_string();
    if args.recordings.input.len() > 1 {
        return usage(format!("{address} is a live robot; nothing else is read beside it"));
    }
    if live.follow {
        return usage(format!("{address} is a live robot, which is followed at its own pace; leave out --follow"));
    }
    let topic = without_query(input).to_str().and_then(|address| address.splitn(4, '/').nth(3)).unwrap_or_default();
    let topic = topic.trim_matches('/').to_owned();
    let transforms = ["/tf", "/tf_static"].map(str::to_owned);
    let odometry = config.sensor().odometry_topic().to_owned();
    let odometry = Some(odometry).filter(|odometry| !odometry.is_empty());
    let scanners = args.topic.clone();
    let beside = odometry.into_iter().chain(transforms.into_iter().filter(|_| !scanners.is_empty()));
    let mut beside: Vec<String> = scanners.iter().cloned().chain(beside).collect();
    beside.dedup();
    Ok(Some(RobotAddress {
        topic,
        beside,
        message_type: args.recordings.read_as.map(|read_as| read_as.name().to_owned()),
        publish: publish.cloned(),
        address,
    }))
}

/// Hears it with `robots`.
pub(crate) fn hear(robot: &RobotAddress, robots: Option<&dyn Robots>, feed: Feed) -> anyhow::Result<Box<dyn Robot>> {
    let Some(robots) = robots else {
        let address = &robot.address;
        return Err(UsageError(format!(
            "{address} is a live robot, and this crosscut has no network: the wheel has. `python/run --install` builds it, and \
             then `target/python/venv/bin/crosscut run {}` hears the robot",
            quoted(address)
        ))
        .into());
    };
    robots.hear(robot, feed).map_err(|error| match error {
        RobotError::Usage(text) => UsageError(text).into(),
        RobotError::Failed(text) => anyhow::Error::msg(text),
    })
}

/// Counts the scans that are missing by the usual interval of their stamps, of a robot whose messages are not numbered.
#[derive(Default)]
pub(crate) struct Gaps {
    last_ns: u64,
    /// The last intervals.
    intervals_ns: VecDeque<u64>,
    missing: u64,
}

impl Gaps {
    /// Fewer intervals do not show the usual one, and more than these are old.
    const LEAST: usize = 5;
    const MOST: usize = 25;

    pub(crate) fn take(&mut self, stamp_ns: u64) {
        let last_ns = std::mem::replace(&mut self.last_ns, stamp_ns);
        if last_ns == 0 || stamp_ns <= last_ns {
            return;
        }
        let interval_ns = stamp_ns - last_ns;
        self.intervals_ns.push_back(interval_ns);
        if self.intervals_ns.len() > Self::MOST {
            self.intervals_ns.pop_front();
        }
        let mut sorted: Vec<u64> = self.intervals_ns.iter().copied().collect();
        sorted.sort_unstable();
        let usual_ns = sorted[(sorted.len() - 1) / 2];
        if sorted.len() >= Self::LEAST {
            self.missing += (interval_ns as f64 / usual_ns as f64).round() as u64 - 1;
        }
    }

    /// What there is to say of it.
    pub(crate) fn note(&self) -> Option<String> {
        (self.missing > 0).then(|| format!("about {} missing by their stamps", counted_are(self.missing)))
    }
}

fn counted_are(scans: u64) -> String {
    format!("{} {}", counted(scans, "scan"), if scans == 1 { "is" } else { "are" })
}

/// Says it once when no scan comes for a while.
#[derive(Clone)]
pub(crate) struct Silence {
    since: Arc<Mutex<Option<Instant>>>,
}

impl Silence {
    pub(crate) fn new() -> Self {
        Self { since: Arc::new(Mutex::new(Some(Instant::now()))) }
    }

    /// There was a scan.
    pub(crate) fn end(&self) {
        *self.since.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    /// There is none at this time.
    pub(crate) fn goes_on(&self) {
        let mut since = self.since.lock().unwrap_or_else(PoisonError::into_inner);
        if since.is_some_and(|since| since.elapsed() > SILENCE) {
            *since = None;
            say(format_args!("warning: no scan for {} s; is the topic right, and is the robot up?", SILENCE.as_secs()));
        }
    }
}
