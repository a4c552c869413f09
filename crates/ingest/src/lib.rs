//! Recordings to revolutions.
//!
//! In: recordings, whole or damaged (MCAP, bags of ROS 1 and rosbag2, CARMEN logs, tables of ranges, lists of returns,
//! PCD, PLY), with scans or clouds of any type that [`ScanDecoder`](crosscut_messages::ScanDecoder) knows. Out: one
//! [`Revolution`] for each scan message, empty ones too: n returns in the body frame
//! (metres; x forward, y left) in message beam order, and what every beam saw. Everything that was turned, left out,
//! repaired or replaced is a note on its revolution; everything that could not be read is a [`Loss`].
//!
//! - [`Recording`] reads the scans of a flight, from one file or several, as a [`Source`]; also from files
//!   that are still being written, standard input, and a live robot by its [`Feed`].
//! - [`describe`] tells what is in a file; [`Truths`] reads the truth beside the scans, [`truth_map`] that of a flight's mine.
//! - [`convert()`] writes any recording as an MCAP of ROS 2.
//!
//! # One scan
//! What a scan's beams say is read by [`Sensor`], whose crate has the rules. Its times and frame:
//!
//! | the scan says | what is done, with a note unless said |
//! |---|---|
//! | stamp 0 or before 1970 | log time, unless it is a clock that starts at 0 |
//! | stamp more than a day from where it should be | log time, less the usual difference of the two |
//! | log time far from most others, or 0 before the clock was set | told by the stamp, or that of the first scan |
//! | stamp that of the scan before, or earlier | kept |
//! | another `frame_id` than the scan before | kept; with `frame_id` in the configuration only that one is taken, and others are not selected: they have no result, and [`Recording::of_other_frames`] counts them |
//! | bytes that are no message of the type | an empty revolution, and a loss |
//!
//! # One recording
//! Each format is one implementation of the trait `Container`, and is recognised by the first bytes of a file.
//!
//! With an index scans come by log time, ties in file order; without one in file order, and scans that are out of order
//! are noted and counted. Rows of a database always come by log time. Memory holds the scans of the chunks that overlap
//! in time, whatever the size of the file; of a database that is damaged, or whose rows are out of order, also the place
//! of each message. A file without an index is looked through once before it is read, so that its topics, counts and
//! losses are known.
//!
//! A file that is cut off gives every whole scan before the cut. A chunk that is damaged (checksum, compression,
//! records) is lost alone; `seq` counts its scans if an index still does. If the index is damaged the file is read
//! without it.
//!
//! If no scan at all can be decoded, nothing is given: the source fails.
//!
//! # Turns
//! Messages that are parts of a turn, each beginning where the one before ends, or in any order until one comes again,
//! are joined into one revolution by their bearings, also where these are not even; `seq` then counts revolutions, and
//! a note gives the number of messages. What cannot be joined is noted. Of a list of returns, the rows of a turn are
//! one scan.
//!
//! # Several scanners
//! Scans of several topics ([`ReadOptions::beside`]) become one revolution in the nearest frame in which all scanners lie
//! by the transforms of the recording, static or moving: each scan of the first topic with that of every other whose stamp
//! is nearest, 0.1 s apart at most. The revolution has beams all around, as wide as two steps of the coarsest scanner; each
//! sees the nearest return in it. What was joined, and what cannot be, is noted.
//!
//! To add another kind of recording: implement `Container` in a file of its own under `container/`, and give it a line
//! in `container::open`.

mod clock;
mod container;
mod convert;
mod describe;
mod error;
mod following;
mod found;
mod inputs;
mod limits;
mod loss;
mod messages;
mod metadata;
mod odometry_reader;
mod order;
mod parts;
mod recording;
mod scanners;
mod stopping;
mod stored;
mod stream;
mod topic_list;
mod topics;
mod truths;
mod turns;

pub use container::KeptStandardInput;
pub use convert::{ConvertError, Converted, convert};
pub use crosscut_sensor::{CSV_PARAMS, CsvGeometry, Sensor};
pub use crosscut_stage::{Notes, Revolution, Source};
pub use describe::{Description, ScanDescription, TopicDescription, describe};
pub use error::IngestError;
pub use following::Following;
pub use found::Found;
pub use inputs::{Parts, parts_in, recordings_in};
pub use loss::{Damage, Loss, LossKind};
pub use recording::{ReadOptions, Recording};
pub use stopping::stop_reading;
pub use stored::{Stored, StoredMessage};
pub use stream::{Feed, LiveFeed, StreamEnded};
pub use topic_list::{TopicInfo, TopicList};
pub use truths::{Truths, truth_map};

/// The example of the README compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
