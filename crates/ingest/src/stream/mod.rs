//! Messages that are read as they come: of files that are still being written, of standard input, of a live robot.
//!
//! One end is a [`Feed`], into which a thread puts messages of any topics in their order. The other is a container as any
//! other: each of its readers (scans, odometry, transforms, further scanners) has a queue of its own, and whoever needs the next
//! message takes messages from the feed, for all of them, until his is there. So a stream is read once, by one thread, in the
//! order in which it comes, and nothing but that order decides what belongs together.

mod feed;
mod files;
mod queues;
mod reader;
mod standard_input;

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use crosscut_sensor::Sensor;

pub use self::feed::{Feed, LiveFeed, StreamEnded};
use self::queues::{Stream, lock};
use self::reader::Streamed;
use crate::scanners::Mount;
use crate::{Following, IngestError, ReadOptions, Recording};

impl Recording {
    /// Opens files that are still being written, or a folder in which files appear: MCAPs, one after the other. It is waited for
    /// their first scan. The recording ends where its recorder closes it, or when `following` is over.
    ///
    /// # Errors
    /// When a file cannot be opened or is no MCAP, or waiting is over before there is a scan.
    pub fn follow(
        inputs: &[PathBuf],
        options: &ReadOptions,
        sensor: &Sensor,
        following: &Following,
    ) -> Result<Self, IngestError> {
        let (feed, arrivals) = feed::of_file(options.read_as);
        files::read(inputs, feed, following)?;
        let path = inputs.first().cloned().unwrap_or_default();
        Self::of_stream(Stream::new(path, arrivals, following, false), options, sensor)
    }

    /// Reads standard input as it comes, if it is an MCAP, compressed or not; `None` if it is something else, which then is read
    /// as a whole under the name `-`. The recording ends early when `following` is over.
    ///
    /// # Errors
    /// When standard input cannot be read, or it ends before there is a scan.
    pub fn of_standard_input(
        options: &ReadOptions,
        sensor: &Sensor,
        following: &Following,
    ) -> Result<Option<Self>, IngestError> {
        let (feed, arrivals) = feed::of_file(options.read_as);
        let path = PathBuf::from("-");
        let is_stream =
            standard_input::read(feed).map_err(|source| IngestError::Open { path: path.clone(), source })?;
        let stream = is_stream.then(|| Stream::new(path, arrivals, following, false));
        stream.map(|stream| Self::of_stream(stream, options, sensor)).transpose()
    }

    /// The messages of the live robot at `address` that are put into a [`Feed`]. The recording ends when `following` is over.
    ///
    /// # Errors
    /// When hearing ends before there is a scan.
    pub fn of_robot(
        address: &str,
        feed: LiveFeed,
        options: &ReadOptions,
        sensor: &Sensor,
        following: &Following,
    ) -> Result<Self, IngestError> {
        let stream = Stream { missing: feed.missing, ..Stream::new(address.into(), feed.arrivals, following, true) };
        Self::of_stream(stream, options, sensor)
    }

    fn of_stream(mut stream: Stream, options: &ReadOptions, sensor: &Sensor) -> Result<Self, IngestError> {
        stream.most_bytes = options.waiting_bytes;
        stream.wait_for_topics(options)?;
        let stream = Arc::new(Mutex::new(stream));
        let containers = vec![Streamed::boxed(&stream)];
        let scanners = Recording::beside(&containers, &[], options, sensor)?;
        let is_single = scanners.is_none();
        let mount = is_single.then(|| Mount::read(&containers, &options.csv, sensor)).flatten();
        let recording = Self::of(containers, Vec::new(), options, sensor.clone())?;
        lock(&stream).history = None;
        Ok(recording.streamed(scanners, mount))
    }
}
