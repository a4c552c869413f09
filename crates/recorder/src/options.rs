//! Options of a recording, and why it may fail.

use std::net::SocketAddr;
use std::path::PathBuf;

use rerun::RecordingStreamError;

use crate::truth::TrueWalls;
use crate::{Mounting, Scope};

/// Where and how to record.
#[derive(Clone, Debug, Default)]
pub struct RecorderOptions {
    /// The .rrd file to write; an existing one is replaced. A long flight continues in FILE-2.rrd, FILE-3.rrd...
    pub path: Option<PathBuf>,
    /// Shows the recording in the native viewer during the flight.
    pub view: bool,
    /// Serves the recording at this address until the recorder is dropped; port 0 takes a free one.
    pub serve: Option<SocketAddr>,
    /// The flight is live: it does not wait for a slow disk, but leaves out revolutions and counts them.
    pub live: bool,
    /// Name of the recording in the viewer.
    pub name: String,
    /// The file that was flown and the preset, such as "tee.mcap, preset paper"; the page of a revolution names them.
    pub source: String,
    /// Where the true count of each revolution is told, if the flight has one.
    pub truth: TrueWalls,
    /// The resolved configuration, as TOML.
    pub config_toml: String,
    /// How the sensor is mounted in the body frame.
    pub mounting: Mounting,
    /// What is recorded.
    pub scope: Scope,
    /// The recording that this becomes a part of; without it, one of its own.
    pub ids: Option<StoreIds>,
}

/// What a viewer knows a recording by. Data with the same two is one recording, whoever sends it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoreIds {
    /// The application, to which the pages belong.
    pub application: String,
    /// The recording.
    pub recording: String,
}

/// Why recording failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The file could not be created.
    #[error("cannot create the recording: {cause}: {}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: String,
    },
    /// The file could not be written to the end.
    #[error("the recording ends early, with all that was written before: {cause}: {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        cause: String,
    },
    /// The disk was slower than the live flight.
    #[error(
        "the disk was slower than the flight: {thinned} revolutions are recorded without matrices, {left_out} not at all"
    )]
    DiskTooSlow {
        /// Revolutions recorded without matrices.
        thinned: u64,
        /// Revolutions not recorded.
        left_out: u64,
    },
    /// The environment variable `RERUN` makes Rerun drop everything silently.
    #[error("RERUN=0 in the environment turns every recording off; unset it")]
    Disabled,
    /// There is no native viewer on this machine.
    #[error("no Rerun viewer found; `pip install rerun-sdk==0.36.3` brings it")]
    NoViewer,
    /// The viewer could not be started, or was closed.
    #[error("cannot reach the viewer: {0}")]
    Viewer(String),
    /// The viewer was slower than the flight.
    #[error("the viewer was too slow: it misses {0} messages")]
    ViewerTooSlow(u64),
    /// The server cannot listen at the address.
    #[error("cannot serve at {address}: {cause}")]
    Serve {
        /// The address.
        address: SocketAddr,
        /// The error of the system.
        cause: String,
    },
    /// Rerun returned an error.
    #[error("cannot record: {0}")]
    Rerun(#[from] RecordingStreamError),
}
