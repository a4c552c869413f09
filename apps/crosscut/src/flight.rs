//! The flight that a command reads.

use crosscut_detector::Config;
use crosscut_flight::check_live;
use crosscut_ingest::{CsvGeometry, Following, ReadOptions, Recording};
use crosscut_pipeline::StopFlag;
use crosscut_sensor::Sensor;

use crate::cli::FlightArgs;
use crate::exit::UsageError;

/// Opens the recordings of a flight, read with the settings of the sensor in `config`.
pub(crate) fn open(args: &FlightArgs, config: &Config) -> anyhow::Result<Recording> {
    refuse_empty_span(args.from, args.to)?;
    refuse_live(args)?;
    Ok(Recording::open(&args.input, &options(args, config), sensor(config))?)
}

/// Opens a recording that is still being written, which ends at the latest when `stop` is set.
pub(crate) fn follow(args: &FlightArgs, config: &Config, stop: StopFlag) -> anyhow::Result<Recording> {
    let [path] = &args.input[..] else {
        return Err(UsageError("--follow reads one MCAP".to_owned()).into());
    };
    if args.topic.len() > 1 {
        return Err(UsageError("--follow reads one topic".to_owned()).into());
    }
    if path.as_os_str() == "-" {
        return Err(UsageError("--follow reads a file; standard input is read up to its end anyway".to_owned()).into());
    }
    check_live(config.params("flight")).map_err(|error| UsageError(error.to_string()))?;
    let following = Following::until(move || stop.is_set());
    Ok(Recording::follow(path, &options(args, config), &sensor(config), &following)?)
}

fn sensor(config: &Config) -> Sensor {
    Sensor::new(config.params("ingest"))
}

fn options(args: &FlightArgs, config: &Config) -> ReadOptions {
    let csv = CsvGeometry::new(config.params("csv"));
    ReadOptions {
        topic: args.topic.first().cloned(),
        beside: args.topic.iter().skip(1).cloned().collect(),
        read_as: args.read_as,
        from_s: args.from,
        to_s: args.to,
        every: args.every,
        csv,
    }
}

/// Refuses a live robot, which the program of the Python package hears.
fn refuse_live(args: &FlightArgs) -> Result<(), UsageError> {
    let is_live = |path: &&str| path.starts_with("zenoh://") || path.starts_with("ros2://");
    let live = args.input.iter().filter_map(|path| path.to_str()).find(is_live);
    match live {
        Some(robot) => Err(UsageError(format!(
            "{robot} is a live robot, which `crosscut run` of the Python package hears: see docs/deployment.md"
        ))),
        None => Ok(()),
    }
}

/// Refuses a span of time that ends before it begins.
pub(crate) fn refuse_empty_span(from_s: Option<f64>, to_s: Option<f64>) -> Result<(), UsageError> {
    match (from_s, to_s) {
        (Some(from), Some(to)) if from > to => Err(UsageError(format!("--from {from} is after --to {to}"))),
        _ => Ok(()),
    }
}
