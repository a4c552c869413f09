//! Scenes as an MCAP recording of ROS 2 messages, with truth.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use crosscut_messages::{
    CDR_ENCODING, Endian, JSON_ENCODING, JSON_SCHEMA_ENCODING, LaserScan, Message, ODOMETRY_TOPIC, Odometry,
    SCAN_TOPIC, SCHEMA_ENCODING, TF_TOPIC, TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT, TRUTH_MAP_TOPIC,
    TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, TRUTH_TOPIC, TfMessage, Truth, TruthMap,
};
use mcap::records::{MessageHeader, Metadata, Record};

use crate::scene::Scene;

/// Name of the metadata record that describes a flight.
const DESCRIPTION: &str = "crosscut";

/// Why a recording could not be written or read.
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
    /// The file could not be read.
    #[error("cannot read the recording {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file has no scene of a simulated flight.
    #[error("no scan with odometry and its true pose is in {}", path.display())]
    NoFlight {
        /// The file.
        path: PathBuf,
    },
}

/// Writes scenes to `path` one by one, and returns their number. The same scenes give the same bytes.
///
/// # Errors
/// If the file cannot be created or written.
pub fn write_mcap(path: &Path, scenes: impl Iterator<Item = Scene>) -> Result<u32, RecordingError> {
    let mut recorder = SceneRecorder::create(path)?;
    for scene in scenes {
        recorder.add(&scene)?;
    }
    recorder.finish()
}

/// A recording that grows scene by scene.
pub struct SceneRecorder {
    path: PathBuf,
    mcap: mcap::Writer<BufWriter<File>>,
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

    /// Creates the file with values that describe the flight, for [`read_description`].
    ///
    /// # Errors
    /// If it cannot be created or written.
    pub fn described(path: &Path, values: BTreeMap<String, String>) -> Result<Self, RecordingError> {
        let file = created(path).map_err(|source| RecordingError::Create { path: path.into(), source })?;
        let begin = || -> Result<Self, mcap::McapError> {
            // Fixed texts and compression without threads keep the bytes the same in every run.
            let mut mcap = mcap::WriteOptions::new()
                .profile("ros2")
                .library("crosscut-simulator")
                .compression(Some(mcap::Compression::Zstd))
                .compression_level(9)
                .compression_threads(0)
                .create(BufWriter::new(file))?;
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
        Ok(self.written)
    }

    fn failed(&self, source: mcap::McapError) -> RecordingError {
        RecordingError::Write { path: self.path.clone(), message: self.written, source }
    }
}

/// Reads the scenes of a flight that [`SceneRecorder`] wrote, as far as the file is whole.
///
/// # Errors
/// If the file cannot be read, or has no scene with odometry and a true pose.
pub fn read_mcap(path: &Path) -> Result<Vec<Scene>, RecordingError> {
    let bytes = bytes_of(path)?;
    let messages = mcap::MessageStream::new_with_options(&bytes, mcap::read::Options::IgnoreEndMagic.into());
    let mut scenes: Vec<Scene> = Vec::new();
    // The last chunk of a file that was not finished is in pieces.
    for message in messages.into_iter().flatten().map_while(Result::ok) {
        let of = message.sequence as usize;
        match (message.channel.topic.as_str(), of.checked_sub(scenes.len())) {
            (SCAN_TOPIC, Some(0)) => {
                let Ok(scan) = LaserScan::decode(&message.data) else { break };
                scenes.push(Scene::of_scan(message.log_time, scan));
            }
            (TRUTH_TOPIC, None) => scenes[of].truth = Truth::from_json(&message.data).unwrap_or_default(),
            (TRUTH_MAP_TOPIC, None) => scenes[of].map = TruthMap::from_json(&message.data).ok(),
            (ODOMETRY_TOPIC, None) => scenes[of].odometry = Odometry::decode(&message.data).ok(),
            _ => {}
        }
    }
    let is_whole = |scene: &Scene| scene.odometry.is_some() && scene.truth.pose.is_some();
    scenes.truncate(scenes.iter().take_while(|scene| is_whole(scene)).count());
    if scenes.is_empty() { Err(RecordingError::NoFlight { path: path.into() }) } else { Ok(scenes) }
}

/// An empty file that no other program writes to.
fn created(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
    // On other systems a lock would exclude readers as well.
    if cfg!(unix) && matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, "another program is writing to it"));
    }
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    Ok(file)
}

/// The values that describe a flight, as [`SceneRecorder::described`] wrote them; none if it was written without.
///
/// # Errors
/// If the file cannot be read.
pub fn read_description(path: &Path) -> Result<BTreeMap<String, String>, RecordingError> {
    let bytes = bytes_of(path)?;
    let records = mcap::read::LinearReader::new_with_options(&bytes, mcap::read::Options::IgnoreEndMagic.into());
    let described = records.into_iter().flatten().map_while(Result::ok).find_map(|record| match record {
        Record::Metadata(metadata) if metadata.name == DESCRIPTION => Some(metadata.metadata),
        _ => None,
    });
    Ok(described.unwrap_or_default())
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, RecordingError> {
    std::fs::read(path).map_err(|source| RecordingError::Read { path: path.into(), source })
}

fn json_channel(
    mcap: &mut mcap::Writer<BufWriter<File>>,
    topic: &str,
    [name, text]: [&str; 2],
) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(name, JSON_SCHEMA_ENCODING, text.as_bytes())?;
    mcap.add_channel(schema, topic, JSON_ENCODING, &BTreeMap::new())
}

fn ros_channel<M: Message>(mcap: &mut mcap::Writer<BufWriter<File>>, topic: &str) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(M::SCHEMA_NAME, SCHEMA_ENCODING, M::SCHEMA_TEXT.as_bytes())?;
    mcap.add_channel(schema, topic, CDR_ENCODING, &BTreeMap::new())
}
