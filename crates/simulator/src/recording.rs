//! Scenes as an MCAP recording of ROS 2 messages, with truth.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crosscut_messages::{
    CDR_ENCODING, Endian, JSON_ENCODING, JSON_SCHEMA_ENCODING, LaserScan, Message, ODOMETRY_TOPIC, Odometry,
    SCAN_TOPIC, SCHEMA_ENCODING, TF_TOPIC, TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT, TRUTH_MAP_TOPIC,
    TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, TRUTH_TOPIC, TfMessage,
};
use crosscut_outfile::{Growing, Keep, Whole};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;

use crate::scene::Scene;

/// Name of the metadata record that describes a flight.
pub const DESCRIPTION: &str = "crosscut";

/// Why a recording could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file could not be created.
    #[error("cannot create the recording {}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file could not be written to its end.
    #[error("cannot write message {message} of the recording {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Number of scenes written before.
        message: u32,
        /// The cause.
        source: mcap::McapError,
    },
}

/// Writes scenes to `path` one by one, and returns their number. The same scenes give the same bytes. What is there stays
/// until the recording is whole.
///
/// # Errors
/// If the file cannot be created or written.
pub fn write_mcap(path: &Path, scenes: impl Iterator<Item = Scene>) -> Result<u32, RecordingError> {
    let whole = Whole::create(path, Keep::ThroughKill);
    let mut recorder = SceneRecorder::begin(path, whole.map(Out::Whole), BTreeMap::new())?;
    for scene in scenes {
        recorder.add(&scene)?;
    }
    recorder.finish()
}

/// A recording that grows scene by scene. What is there stays until the first flush.
pub struct SceneRecorder {
    path: PathBuf,
    mcap: mcap::Writer<NoSeek<Out>>,
    scan: u16,
    truth: u16,
    /// Channels for odometry and transforms appear with the first scene that has them.
    motion: Option<[u16; 2]>,
    written: u32,
}

impl SceneRecorder {
    /// Creates the file, and holds it: a second recorder of the same file is refused.
    ///
    /// # Errors
    /// If it cannot be created or written.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        Self::described(path, BTreeMap::new())
    }

    /// Creates the file with values that describe the flight, in the metadata record [`DESCRIPTION`].
    ///
    /// # Errors
    /// If it cannot be created or written.
    pub fn described(path: &Path, values: BTreeMap<String, String>) -> Result<Self, RecordingError> {
        let growing = Growing::create(path, Keep::ThroughKill);
        Self::begin(path, growing.map(|file| Out::Growing(BufWriter::new(file))), values)
    }

    fn begin(path: &Path, out: io::Result<Out>, values: BTreeMap<String, String>) -> Result<Self, RecordingError> {
        let out = out.map_err(|source| RecordingError::Create { path: path.into(), source })?;
        let begin = || -> Result<Self, mcap::McapError> {
            // Fixed texts and compression without threads keep the bytes the same in every run.
            let mut mcap = mcap::WriteOptions::new()
                .profile("ros2")
                .library("crosscut-simulator")
                .compression(Some(mcap::Compression::Zstd))
                .compression_level(9)
                .compression_threads(0)
                .disable_seeking(true)
                .create(NoSeek::new(out))?;
            if !values.is_empty() {
                mcap.write_metadata(&Metadata { name: DESCRIPTION.to_owned(), metadata: values })?;
            }
            let scan = ros_channel::<LaserScan>(&mut mcap, SCAN_TOPIC)?;
            let truth = json_channel(&mut mcap, TRUTH_TOPIC, [TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT])?;
            Ok(Self { path: path.into(), mcap, scan, truth, motion: None, written: 0 })
        };
        begin().map_err(|source| RecordingError::Write { path: path.into(), message: 0, source })
    }

    /// Adds a scene.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, scene: &Scene) -> Result<(), RecordingError> {
        self.write(scene).map_err(|source| self.failed(source))?;
        self.written += 1;
        Ok(())
    }

    fn write(&mut self, scene: &Scene) -> Result<(), mcap::McapError> {
        let Self { mcap, scan, truth, written, .. } = self;
        let header = |channel_id| MessageHeader {
            channel_id,
            sequence: *written,
            log_time: scene.stamp_ns,
            publish_time: scene.stamp_ns,
        };
        mcap.write_to_known_channel(&header(*scan), &scene.scan.encode(Endian::Little))?;
        mcap.write_to_known_channel(&header(*truth), &scene.truth.to_json())?;
        if let Some(map) = &scene.map {
            let channel = json_channel(mcap, TRUTH_MAP_TOPIC, [TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT])?;
            mcap.write_to_known_channel(&header(channel), &map.to_json())?;
        }
        if let (Some(odometry), Some(transforms)) = (&scene.odometry, scene.transforms()) {
            let [odometry_channel, tf_channel] = match self.motion {
                Some(channels) => channels,
                None => *self.motion.insert([
                    ros_channel::<Odometry>(mcap, ODOMETRY_TOPIC)?,
                    ros_channel::<TfMessage>(mcap, TF_TOPIC)?,
                ]),
            };
            mcap.write_to_known_channel(&header(odometry_channel), &odometry.encode(Endian::Little))?;
            mcap.write_to_known_channel(&header(tf_channel), &transforms.encode(Endian::Little))?;
        }
        Ok(())
    }

    /// Leaves all scenes so far in the file, readable even if the program ends here.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn flush(&mut self) -> Result<(), RecordingError> {
        self.mcap.flush().map_err(|source| self.failed(source))
    }

    /// Ends the file, and returns the number of scenes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<u32, RecordingError> {
        self.mcap.finish().map_err(|source| self.failed(source))?;
        let Self { path, mcap, written, .. } = self;
        let named = mcap.into_inner().into_inner().finish();
        named.map_err(|error| RecordingError::Write { path, message: written, source: error.into() })?;
        Ok(written)
    }

    fn failed(&self, source: mcap::McapError) -> RecordingError {
        RecordingError::Write { path: self.path.clone(), message: self.written, source }
    }
}

/// Where a recording goes.
enum Out {
    Whole(Whole),
    Growing(BufWriter<Growing>),
}

impl Out {
    fn finish(self) -> io::Result<()> {
        match self {
            Self::Whole(file) => file.finish(),
            Self::Growing(mut file) => file.flush(),
        }
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Whole(file) => file.write(bytes),
            Self::Growing(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Whole(file) => file.flush(),
            Self::Growing(file) => file.flush(),
        }
    }
}

fn json_channel(
    mcap: &mut mcap::Writer<NoSeek<Out>>,
    topic: &str,
    [name, text]: [&str; 2],
) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(name, JSON_SCHEMA_ENCODING, text.as_bytes())?;
    mcap.add_channel(schema, topic, JSON_ENCODING, &BTreeMap::new())
}

fn ros_channel<M: Message>(mcap: &mut mcap::Writer<NoSeek<Out>>, topic: &str) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(M::SCHEMA_NAME, SCHEMA_ENCODING, M::SCHEMA_TEXT.as_bytes())?;
    mcap.add_channel(schema, topic, CDR_ENCODING, &BTreeMap::new())
}
