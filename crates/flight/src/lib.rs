//! Where each revolution of a flight was taken, and what kind of place that is.
//!
//! In: revolutions in order, and odometry where there is any. Out: poses in the plane, [`nalgebra::Isometry2`] in metres
//! and radians, in the frame of the first revolution (x forward, y left).
//!
//! - [`Flight`] adds all of this to the frames of a flight, in order.
//! - [`ScanMatcher`] matches each revolution to the walls seen before, point to line; odometry is its prediction where
//!   there is any.
//! - [`PoseTracker`] chooses between odometry, scans and both by name, and notes slips, jumps and missing odometry.
//! - [`Here`] says which of the openings in view belong to the place of the vehicle: junction, passage, dead end, chamber.
//! - [`Mapper`] makes the [`Map`] of a flight: junctions and dead ends, each once, and the passages between them.
//! - [`PoseGraph`] corrects the poses once a place is known to be seen again; [`write_g2o`] and [`read_g2o`] exchange it
//!   with other programs.
//!
//! All of it is deterministic: the same revolutions give the same poses.

mod agreement;
mod answer;
mod belief;
mod beyond;
mod directions;
mod evidence;
mod flight;
mod g2o;
mod gap;
mod here;
mod line_points;
mod local_map;
mod look;
mod map;
mod motion;
mod own_returns;
mod pose;
mod pose_graph;
mod rays;
mod scan_match;
mod search;
mod steady;
mod surroundings;
mod unaided;

pub use answer::{FlightAnswer, Here, HereKind, Steady, SteadyOpening, Way};
pub use flight::{Flight, PARAMS};
pub use g2o::{G2oError, read_g2o, write_g2o};
pub use look::Look;
pub use map::{Anchored, Decided, Fit, Located, Map, MapDrawing, Mapper, NoPlace, Node, NodeWay, Passage, loops_in};
pub use motion::Motion;
pub use pose::{PoseTracker, Tracked};
pub use pose_graph::{Constraint, PoseGraph, PoseGraphError, Solved};
pub use scan_match::{Held, Matched, ScanMatcher};
