//! One message of a 2D lidar to one revolution.
//!
//! In: a [`ScanMessage`](crosscut_messages::ScanMessage), a `LaserScan` or a cloud, how its sensor is mounted, and the
//! vehicle's odometry where there is any. Out: a [`Revolution`](crosscut_stage::Revolution): n returns in the body frame
//! (metres; x forward, y left) in message beam order, and what every beam saw. Everything that was turned, left out, repaired
//! or replaced is a note. Nothing here reads a file.
//!
//! - [`Sensor`] makes one scan a revolution.
//! - [`Live`] does so with the scans of a robot, one after the other: corrected for its motion, without blind sectors.
//! - [`RevolutionWriter`], [`Turning`], [`Motion`] and [`Before`] are the parts of that, which recordings use as well.
//!
//! # One scan
//! Beam i looks at θᵢ = yaw ± (angle_min + i·angle_increment), minus if the sensor hangs upside down, and a return of
//! range r stands at (r cos θᵢ, r sin θᵢ, 0). Ranges and angles become f64 before any arithmetic.
//!
//! | range | the beam is | note |
//! |---|---|---|
//! | +∞ | no return | |
//! | NaN, of an invalid measurement by REP 117, but as many drivers say that nothing came back | no return | no |
//! | 0, negative | no return | yes |
//! | at or beyond `range_max` (1e-6 below it counts as at it) | no return | yes |
//! | the largest below `range_max`, if 3 beams or more tell exactly it, two of them neighbours, or 5, and of the others, a tenth of all or more, 5 % at most tell the range of their neighbour | no return | yes |
//! | within 0.5 % below `range_max`, or four standard deviations, if 8 beams or more are, 8 are at it, and most of those below are beside one at it: noise about the maximum, which half of those below show | no return | yes |
//! | exactly 1 m beyond `range_max`, where other beams say otherwise that nothing came back: masked by a filter | unknown | yes |
//! | beyond `max_range_m` of the configuration | no return | yes |
//! | -∞, nearer than the sensor measures | unknown | yes |
//! | below `range_min`, below `min_range_m` of the configuration, in a masked sector | unknown | yes |
//! | anything else | a return | if most are farther than 500 m, as in millimetres (`range_scale`) |
//!
//! A cloud is turned level with the heading of the vehicle, by its mount and by roll and pitch of odometry, with notes. Points of
//! it that are not finite, or stand at the sensor itself (noted), are no returns. Of the others, the
//! revolution has what a level vehicle sees ([`LevelView`](crosscut_scan::LevelView)): the nearest returns at its height, in
//! up to 720 beams. The cloud's other points at this height are entries of the return of their beam, and those above
//! or below it of no wall. An affinity that takes whole clouds has all points beside ([`Sensor::keeping_cloud`]). A sweep of more than 4096 beams is levelled as well.
//!
//! *No return* means that nothing is there within range; *unknown* that nothing is known.
//!
//! | the scan says | what is done, with a note unless said |
//! |---|---|
//! | `range_max` 0, negative or NaN | no limit |
//! | `range_max` infinite | no limit, no note |
//! | `range_max` below 95 % of the ranges, ten different ones or more | no limit |
//! | `range_max` not above `range_min` | neither is a limit |
//! | `range_min` negative, infinite or NaN | 0 |
//! | `angle_increment` negative | the sensor turns clockwise, no note |
//! | `angle_increment` 0, NaN, below 1e-6 rad or beyond π | replaced by (angle_max - angle_min) / (beams - 1); if that is of no use either, no beam has a bearing |
//! | `angle_increment`, or all angles, that fit the number of beams as degrees and not as radians | taken as degrees |
//! | `angle_max` more than 1.5 steps from where the last beam is | angle_min + i·angle_increment is believed |
//! | `angle_min` not finite, or beyond two turns and no degrees | no beam has a bearing: all are unknown, the revolution is empty |
//! | last beam where the first one is | the last one is left out |
//! | more than a full turn | beams beyond the turn are left out |
//! | no beams | an empty revolution |
//! | one beam | its bearing is `angle_min`, no note |
//! | intensities of another number than ranges | they are not used anyway |
//!
//! # Scans in a row
//! Sectors that never return anything in the first 100 scans are taken as unknown, with a note and a setting
//! (`find_blind_sectors`), if their edges stay at the same beams while the ranges beside them change; for a vehicle that
//! stands still, if the driver gives 0 for 60° or more of them and for no other beam, and the walls beside them go on.
//!
//! A vehicle that turns takes its sensor with it while a scan is taken. Where scans state the time from beam to beam
//! (`time_increment`) and odometry, or two that follow each other, show how far the sensor turned, 9° or more in a scan, the
//! beams are brought to the heading in the middle of the scan, with a note and a setting (`deskew`). Then beams beyond a full
//! turn are left out, and a turn may fall short of 360° by the angle that the sensor turned. Points of a cloud that have
//! times are brought to where the vehicle is in the middle of it, by odometry.
//!
//! A stamp that is that of the scan before, or earlier, a hole in the stamps, and another `frame_id` than before are noted.

mod before;
mod blind;
mod cloud;
mod csv;
mod directions;
mod fan;
mod limits;
mod live;
mod motion;
mod odometry;
mod revolution_writer;
mod sensor;
mod turning;

pub use crosscut_scan::VEHICLE_PARAMS;

pub use before::Before;
pub use csv::{CSV_PARAMS, CsvGeometry};
pub use live::Live;
pub use motion::{Motion, times_s};
pub use odometry::{Odometry, StatedPose, VehiclePose, pose_in};
pub use revolution_writer::{LEARNED_SCANS, RevolutionWriter};
pub use sensor::{MAX_RANGE_M, MIN_RANGE_M, PARAMS, Sensor, UPSIDE_DOWN, YAW_RAD, rescale};
pub use turning::Turning;
