//! Waiting for more of a recording that is still being written.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use crosscut_sensor::Sensor;

use crate::{IngestError, Loss, LossKind, ReadOptions, Recording, container};

/// Between two looks at a file that did not grow.
const INTERVAL: Duration = Duration::from_millis(50);

/// Waits for more of a recording until there is some, or until whoever made this wants no more.
#[derive(Clone)]
pub struct Following(Arc<dyn Fn() -> bool + Send + Sync>);

impl Following {
    /// Waiting ends for good as soon as `is_over` is true.
    pub fn until(is_over: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(is_over))
    }

    /// Waits a moment; `false` if waiting is over.
    pub(crate) fn wait(&self) -> bool {
        if (self.0)() {
            return false;
        }
        sleep(INTERVAL);
        true
    }
}

impl fmt::Debug for Following {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Following")
    }
}

impl Recording {
    /// Opens an MCAP that is still being written, and waits for its first scan. The recording ends where its recorder
    /// closes it, or when `following` is over; it has no index to be read by until then.
    ///
    /// # Errors
    /// When it cannot be opened or is no MCAP, or waiting is over before there is a scan.
    pub fn follow(
        path: &Path,
        options: &ReadOptions,
        sensor: &Sensor,
        following: &Following,
    ) -> Result<Self, IngestError> {
        loop {
            let error = match container::open(path, &options.csv) {
                Ok(mut container) => {
                    let is_cut = |loss: &Loss| matches!(loss.kind, LossKind::CutOff { .. });
                    let is_unfinished = container.contents().losses.iter().any(is_cut);
                    if !container.follow(following) {
                        return Err(IngestError::CannotFollow { path: path.to_owned() });
                    }
                    match Self::of(vec![container], Vec::new(), options, sensor.clone()) {
                        Err(error) if is_unfinished => error,
                        // Odometry is read from the file a second time, which would end where the file ends now.
                        opened => return opened.map(Self::without_odometry),
                    }
                }
                Err(error) => error,
            };
            if !error.may_be_too_early() || !following.wait() {
                return Err(error);
            }
        }
    }
}
