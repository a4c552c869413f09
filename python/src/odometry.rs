//! Poses of a live robot.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crosscut_sensor::Odometry as Poses;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::Class;
use crate::scan::Scan;
use crate::values::xy_yaw;

/// Of more poses than these, those of the last seconds are kept, where no scan asks for any.
const MOST_POSES: usize = 10_000;
const KEPT_NS: u64 = 5_000_000_000;

/// The latest poses of a robot by its odometry.
#[pyclass(frozen, module = "crosscut._native")]
#[derive(Default)]
pub(crate) struct Odometry {
    poses: Mutex<Poses>,
}

impl Odometry {
    fn poses(&self) -> MutexGuard<'_, Poses> {
        self.poses.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Odometry {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Adds the pose in a message of ROS 2 (CDR): a `nav_msgs/msg/Odometry`, or a `tf2_msgs/msg/TFMessage` with the transform
    /// below frame `odom`.
    fn add(&self, py: Python<'_>, message: &[u8], message_type: &str) -> PyResult<()> {
        if !Poses::reads(message_type) {
            let known = "nav_msgs/msg/Odometry and tf2_msgs/msg/TFMessage do";
            return Err(PyValueError::new_err(format!("{message_type} has no poses: {known}")));
        }
        let mut poses = self.poses();
        poses.push_message(message_type, message).map_err(|error| Class::Read.because(py, &error))?;
        if let Some(last_ns) = poses.last_ns().filter(|_| poses.len() > MOST_POSES) {
            poses.forget_before(last_ns.saturating_sub(KEPT_NS));
        }
        Ok(())
    }

    /// Whether there are poses up to the end of the scan.
    fn reaches(&self, scan: &Scan) -> bool {
        scan.span_ns().is_none_or(|[_, end_ns]| self.poses().last_ns().is_some_and(|last_ns| last_ns >= end_ns))
    }

    /// The scan with the poses around it, and x, y and yaw of the vehicle in the middle of it. Scans are asked for in order.
    fn beside(&self, scan: &Scan) -> (Scan, Option<(f64, f64, f64)>) {
        let mut poses = self.poses();
        if let Some([start_ns, _]) = scan.span_ns() {
            poses.forget_before(start_ns);
        }
        let (scan, pose) = scan.beside(&poses);
        (scan, pose.as_ref().map(xy_yaw))
    }
}
