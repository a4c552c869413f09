//! Recordings to revolutions.
//!
//! In: recordings, whole or damaged (MCAP, bags of ROS 1 and rosbag2, CARMEN logs, tables of ranges, PCD, PLY), with
//! scans or clouds of any type that [`ScanDecoder`](crosscut_messages::ScanDecoder) knows.
//! Out: one [`Revolution`](crosscut_stage::Revolution) for each scan message, empty ones too: n returns in the
//! body frame (metres; x forward, y left) in message beam order, and what every beam saw. Everything that was turned,
//! left out, repaired or replaced is a note on its revolution; everything that could not be read is a [`Loss`].
//!
//! - [`Sensor`] makes one scan a revolution: pure, no I/O, for a robot's own program as well.
//! - [`Recording`] reads the scans of a flight, from one file or several, as a [`Source`](crosscut_stage::Source).
//! - [`describe`] tells what is in a file; [`Truths`] reads the truth beside the scans, [`truth_map`] that of a flight's mine.
//! - [`convert()`] writes any recording as an MCAP of ROS 2.
//!
//! # One scan
//! Beam i looks at θᵢ = yaw ± (angle_min + i·angle_increment), minus if the sensor hangs upside down, and a return of
//! range r stands at (r cos θᵢ, r sin θᵢ, 0). Ranges and angles become f64 before any arithmetic.
//!
//! | range | the beam is | note |
//! |---|---|---|
//! | +∞ | no return | |
//! | NaN, of an invalid measurement by REP 117, but as many drivers say that nothing came back | no return | in a [`Description`] |
//! | 0, negative | no return | yes |
//! | at or beyond `range_max` (1e-6 below it counts as at it) | no return | yes |
//! | the largest below `range_max`, if 3 beams or more tell exactly it, two of them neighbours, or 5, and of the others, a tenth of all or more, 5 % at most tell the range of their neighbour | no return | yes |
//! | beyond `max_range_m` of the configuration | no return | yes |
//! | -∞, nearer than the sensor measures | unknown | yes |
//! | below `range_min`, below `min_range_m` of the configuration, in a masked sector | unknown | yes |
//! | anything else | a return | if most are farther than 500 m, as in millimetres |
//!
//! Points of a cloud that are not finite, or stand at the sensor itself (noted), are no returns; a cloud has no beams.
//!
//! *No return* means that nothing is there within range; *unknown* that nothing is known.
//!
//! | the scan says | what is done, with a note unless said |
//! |---|---|
//! | `range_max` 0, negative or NaN | no limit |
//! | `range_max` infinite | no limit, no note |
//! | `range_max` not above `range_min` | neither is a limit |
//! | `range_min` negative, infinite or NaN | 0 |
//! | `angle_increment` negative | the sensor turns clockwise, no note |
//! | `angle_increment` 0, NaN, below 1e-6 rad or beyond π | replaced by (angle_max - angle_min) / (beams - 1); if that is of no use either, no beam has a bearing |
//! | `angle_max` more than 1.5 steps from where the last beam is | angle_min + i·angle_increment is believed |
//! | `angle_min` not finite, or beyond two turns (degrees?) | no beam has a bearing: all are unknown, the revolution is empty |
//! | last beam where the first one is | the last one is left out |
//! | more than a full turn | beams beyond the turn are left out |
//! | no beams | an empty revolution |
//! | one beam | its bearing is `angle_min`, no note |
//! | intensities of another number than ranges | they are not used anyway |
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
//! Messages that are parts of a turn, each beginning where the one before ends, are joined into one revolution; `seq`
//! then counts revolutions, and a note gives the number of messages. What cannot be joined is noted. Sectors that never
//! return anything in the first 100 scans of a recording are taken as unknown, with a note and a setting
//! (`find_blind_sectors`), if their edges stay at the same beams while the ranges beside them change; for a vehicle that
//! stands still, if the driver gives 0 for 60° or more of them and for no other beam, and the walls beside them go on.
//!
//! A vehicle that turns takes its sensor with it while a scan is taken. Where scans state the time from beam to beam
//! (`time_increment`) and odometry, or two that follow each other, show how far the sensor turned, 9° or more in a scan, the
//! beams are brought to the heading in the middle of the scan, with a note and a setting (`deskew`). Then beams beyond a full
//! turn are left out, and a turn may fall short of 360° by the angle that the sensor turned. Points of a cloud that have
//! times are brought to where the vehicle is in the middle of it, by odometry.
//!
//! # Several scanners
//! Scans of several topics ([`ReadOptions::beside`]) become one revolution in the nearest frame in which all scanners lie
//! by the transforms of the recording, static or moving: each scan of the first topic with that of every other whose stamp
//! is nearest, 0.1 s apart at most. The revolution has beams all around, as wide as two steps of the coarsest scanner; each
//! sees the nearest return in it. What was joined, and what cannot be, is noted.
//!
//! To add another kind of recording: implement `Container` in a file of its own under `container/`, and give it a line
//! in `container::open`. Scans that arrive live become revolutions by [`Live`]; a [`Source`](crosscut_stage::Source) gives
//! them to the pipeline.

mod before;
mod clock;
mod container;
mod convert;
mod describe;
mod error;
mod following;
mod found;
mod inputs;
mod limits;
mod live;
mod loss;
mod messages;
mod metadata;
mod motion;
mod odometry;
mod odometry_reader;
mod recording;
mod ros;
mod scanners;
mod sensor;
mod stored;
mod topics;
mod truths;
mod turning;
mod turns;

pub use container::{CSV_PARAMS, CsvGeometry, KeptStandardInput};
pub use convert::{ConvertError, Converted, convert};
pub use describe::{Description, ScanDescription, TopicDescription, describe};
pub use error::IngestError;
pub use following::Following;
pub use found::Found;
pub use inputs::{Parts, parts_in, recordings_in};
pub use live::Live;
pub use loss::{Damage, Loss, LossKind};
pub use odometry::Odometry;
pub use recording::{ReadOptions, Recording};
pub use sensor::{MAX_RANGE_M, MIN_RANGE_M, PARAMS, Sensor, UPSIDE_DOWN, YAW_RAD};
pub use stored::{Stored, StoredMessage};
pub use topics::{TopicInfo, TopicList};
pub use truths::{Truths, truth_map};
