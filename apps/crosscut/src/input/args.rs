//! The recordings that a command reads, and the scans in them.

use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

use clap::Args;
use crosscut_detector::Config;
use crosscut_ingest::{CsvGeometry, ReadOptions};
use crosscut_messages::ScanType;

use crate::values::{count, seconds};

/// The heading of what is read.
const INPUT: &str = "Input";

#[derive(Debug, Args)]
pub(crate) struct RecordingsArgs {
    /// Recordings (MCAP, ROS 1 bag, rosbag2 .db3, CARMEN log, CSV, PCD, PLY) or folders of them or, but for `info` and
    /// `convert`, one made with `run --save` (.rrd); `-` is standard input. The wheel's `run` and `compare` (extras live, dds) hear robots, too:
    /// zenoh://HOST[:PORT]/TOPIC[?domain=N][&config=FILE.json5] and ros2://DOMAIN/TOPIC.
    #[arg(required = true, display_order = 0, help_heading = INPUT)]
    pub(crate) input: Vec<PathBuf>,
    /// Type of the messages on the topic, if the recording does not state it or uses another name: LaserScan,
    /// MultiEchoLaserScan or PointCloud2; in JSON or protobuf those of Foxglove. Of zenoh://, the topic is then a key of plain
    /// messages.
    #[arg(long = "as", display_order = 1, value_name = "TYPE", value_parser = scan_type, help_heading = INPUT)]
    pub(crate) read_as: Option<ScanType>,
}

/// Selects scans of recordings: the parts of one flight, in this order, or flights of their own, as the command says.
#[derive(Debug, Args)]
pub(crate) struct InputArgs {
    #[command(flatten)]
    pub(crate) recordings: RecordingsArgs,
    /// Topic of the scans; may be omitted when there is only one. Given several times, the scans of these scanners become
    /// one revolution, by the transforms in the recording (/tf, /tf_static).
    #[arg(short, long, help_heading = INPUT)]
    pub(crate) topic: Vec<String>,
    /// Start this many seconds after the first scan. If no scan is left, the command fails (exit code 1).
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true, help_heading = INPUT)]
    pub(crate) from: Option<f64>,
    /// Stop this many seconds after the first scan.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true, help_heading = INPUT)]
    pub(crate) to: Option<f64>,
    /// Fly recordings of different sensors as one flight, which is refused otherwise.
    #[arg(long, help_heading = INPUT)]
    pub(crate) join: bool,
    /// Take every N-th scan only.
    #[arg(long, value_name = "N", default_value = "1", value_parser = count::<NonZeroU64>, allow_negative_numbers = true, help_heading = INPUT)]
    pub(crate) every: NonZeroU64,
}

/// How an input is read that is not all there yet.
#[derive(Debug, Args)]
pub(crate) struct LiveArgs {
    /// Read on while recordings are written: an MCAP, or a folder in which MCAPs appear, until their recorder closes them or
    /// Ctrl-C.
    #[arg(long, conflicts_with = "to", help_heading = INPUT)]
    pub(crate) follow: bool,
}

impl InputArgs {
    /// What the flight is called: the first input without folder and ending.
    pub(crate) fn name(&self) -> String {
        let first = self.recordings.input.first().and_then(|input| without_query(input).file_stem());
        first.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The options that select these scans, for a command to be typed.
    pub(crate) fn options(&self) -> Vec<String> {
        let mut options: Vec<String> =
            self.topic.iter().flat_map(|topic| ["--topic".to_owned(), topic.clone()]).collect();
        let of_type = self.recordings.read_as.map(|of| ["--as".to_owned(), of.name().to_owned()]);
        options.extend(of_type.into_iter().flatten());
        for (name, value) in [("--from", self.from), ("--to", self.to)] {
            options.extend(value.into_iter().flat_map(|value| [name.to_owned(), value.to_string()]));
        }
        options.extend(self.join.then(|| "--join".to_owned()));
        if self.every > NonZeroU64::MIN {
            options.extend(["--every".to_owned(), self.every.to_string()]);
        }
        options
    }

    /// Which scans are read, and how.
    pub(crate) fn read_options(&self, config: &Config) -> ReadOptions {
        ReadOptions {
            topic: self.topic.first().cloned(),
            beside: self.topic.iter().skip(1).cloned().collect(),
            read_as: self.recordings.read_as,
            from_s: self.from,
            to_s: self.to,
            every: self.every,
            csv: CsvGeometry::new(config.params("csv")),
            waiting_bytes: config.waiting_bytes(),
        }
    }
}

fn scan_type(name: &str) -> Result<ScanType, String> {
    let names: Vec<_> = ScanType::ALL.into_iter().map(ScanType::name).collect();
    ScanType::of_name(name).ok_or_else(|| format!("one of {}", names.join(", ")))
}

fn is_live(input: &Path) -> bool {
    input.to_str().is_some_and(|input| input.starts_with("zenoh://") || input.starts_with("ros2://"))
}

/// An input without what an address of a robot says behind a `?`.
pub(crate) fn without_query(input: &Path) -> &Path {
    let address = input.to_str().filter(|_| is_live(input)).and_then(|address| address.split('?').next());
    address.map_or(input, Path::new)
}

/// The live robot among the inputs, if there is one.
pub(crate) fn live_input(args: &InputArgs) -> Option<&Path> {
    args.recordings.input.iter().map(PathBuf::as_path).find(|input| is_live(input))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_behind_an_address_is_no_part_of_its_name() {
        let without = |input: &'static str| without_query(Path::new(input)).to_str().expect("UTF-8");
        assert_eq!(without("zenoh://robot/scan?domain=3&config=a/b.json5"), "zenoh://robot/scan");
        assert_eq!(without("odd?name.mcap"), "odd?name.mcap", "of a file it is");
    }
}
