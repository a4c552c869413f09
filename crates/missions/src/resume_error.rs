//! Why a mission cannot be resumed.

use std::path::PathBuf;

use crosscut_ingest::IngestError;

/// Why a mission cannot be resumed.
#[derive(Debug, thiserror::Error)]
pub enum ResumeError {
    /// Its journal cannot be read.
    #[error(transparent)]
    Unreadable(#[from] IngestError),
    /// It has no scene of a simulated flight.
    #[error("no scan with odometry and its true pose is in {}", journal.display())]
    NoFlight {
        /// Where it is.
        journal: PathBuf,
    },
    /// The journal is not that of this mission.
    #[error("cannot resume {}: {why}", journal.display())]
    OtherMission {
        /// Where it is.
        journal: PathBuf,
        /// What differs.
        why: String,
    },
}
