//! Where and how to record, and why that may fail.

use std::net::SocketAddr;
use std::path::PathBuf;

use rerun::RecordingStreamError;

use crate::{Layout, Mounting, Scope};

/// Where and how to record.
#[derive(Clone, Debug, Default)]
pub struct RecorderOptions {
    /// The .rrd file to write; an existing one is replaced. A long flight goes on in FILE-2.rrd, FILE-3.rrd...
    pub path: Option<PathBuf>,
    /// Shows the recording in the native viewer while it is made.
    pub view: bool,
    /// Serves the recording at this address while it is made, and until the recorder is dropped; port 0 takes a free
    /// one.
    pub serve: Option<SocketAddr>,
    /// The flight is live: what the disk is too slow for is left out and counted, instead of the flight waiting.
    pub live: bool,
    /// Name of the recording, as the viewer lists it.
    pub name: String,
    /// The resolved configuration, as TOML.
    pub config_toml: String,
    /// How the sensor sits in the body frame.
    pub mounting: Mounting,
    /// The page that the viewer opens with.
    pub layout: Layout,
    /// What is recorded.
    pub scope: Scope,
}

/// Why nothing can be recorded, or no more.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The file could not be made.
    #[error("cannot create the recording: {cause}: {}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// The file could not be written to the end.
    #[error("the recording ends early, with what was written so far: {cause}: {}", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// The disk was slower than the live flight.
    #[error(
        "the disk was slower than the flight: {thinned} revolutions are recorded without matrices, {left_out} not at all"
    )]
    DiskTooSlow {
        /// Recorded without matrices.
        thinned: u64,
        /// Not recorded.
        left_out: u64,
    },
    /// The environment tells Rerun to drop everything in silence.
    #[error("RERUN=0 in the environment turns every recording off; unset it")]
    Disabled,
    /// There is no native viewer on this machine.
    #[error("no Rerun viewer found; `pip install rerun-sdk==0.36.3` brings it")]
    NoViewer,
    /// The viewer could not be started, or went away.
    #[error("the viewer is not to be reached: {0}")]
    Viewer(String),
    /// The viewer reads more slowly than the flight goes.
    #[error("the viewer was too slow: {0} messages were left out of what it shows")]
    ViewerTooSlow(u64),
    /// The address cannot be listened at.
    #[error("cannot serve at {address}: {cause}")]
    Serve {
        /// Which address.
        address: SocketAddr,
        /// What the system said.
        cause: String,
    },
    /// Rerun refused.
    #[error("cannot record: {0}")]
    Rerun(#[from] RecordingStreamError),
}
