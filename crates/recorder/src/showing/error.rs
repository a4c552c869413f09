//! Why nothing is shown.

use std::path::PathBuf;

use crosscut_rrd::ReadError;

use crate::RecorderError;

/// Why nothing is shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShowError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// The MCAP recording cannot be read.
    #[error("cannot convert the recording: {cause}: {}", path.display())]
    Sensors {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// There is no viewer or no address to show it at.
    #[error(transparent)]
    Viewer(#[from] RecorderError),
}
