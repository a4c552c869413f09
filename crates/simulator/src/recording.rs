//! Scenes as an MCAP recording of ROS 2 messages, with truth.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crosscut_messages::{
    CDR_ENCODING, Endian, JSON_ENCODING, JSON_SCHEMA_ENCODING, LaserScan, Message, ODOMETRY_TOPIC, Odometry,
    SCAN_TOPIC, SCHEMA_ENCODING, TF_TOPIC, TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT, TRUTH_MAP_TOPIC,
    TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, TRUTH_TOPIC, TfMessage,
};
use mcap::records::MessageHeader;

use crate::scene::Scene;

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

/// Writes scenes to `path` one by one, and returns their number. The same scenes give the same bytes.
///
/// # Errors
/// If the file cannot be created or written.
pub fn write_mcap(path: &Path, scenes: impl Iterator<Item = Scene>) -> Result<u32, RecordingError> {
    let file = File::create(path).map_err(|source| RecordingError::Create { path: path.into(), source })?;
    let mut written = 0;
    write_all(BufWriter::new(file), scenes, &mut written).map_err(|source| RecordingError::Write {
        path: path.into(),
        message: written,
        source,
    })?;
    Ok(written)
}

fn write_all(
    file: BufWriter<File>,
    scenes: impl Iterator<Item = Scene>,
    written: &mut u32,
) -> Result<(), mcap::McapError> {
    // Fixed texts and compression without threads keep the bytes the same in every run.
    let mut mcap = mcap::WriteOptions::new()
        .profile("ros2")
        .library("crosscut-simulator")
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(9)
        .compression_threads(0)
        .create(file)?;
    let scan = ros_channel::<LaserScan>(&mut mcap, SCAN_TOPIC)?;
    let truth_schema = mcap.add_schema(TRUTH_SCHEMA_NAME, JSON_SCHEMA_ENCODING, TRUTH_SCHEMA_TEXT.as_bytes())?;
    let truth = mcap.add_channel(truth_schema, TRUTH_TOPIC, JSON_ENCODING, &BTreeMap::new())?;
    // Channels for odometry and transforms appear with the first scene that has them.
    let mut motion = None;
    for scene in scenes {
        let header = |channel_id| MessageHeader {
            channel_id,
            sequence: *written,
            log_time: scene.stamp_ns,
            publish_time: scene.stamp_ns,
        };
        mcap.write_to_known_channel(&header(scan), &scene.scan.encode(Endian::Little))?;
        mcap.write_to_known_channel(&header(truth), &scene.truth.to_json())?;
        if let Some(map) = &scene.map {
            let schema =
                mcap.add_schema(TRUTH_MAP_SCHEMA_NAME, JSON_SCHEMA_ENCODING, TRUTH_MAP_SCHEMA_TEXT.as_bytes())?;
            let channel = mcap.add_channel(schema, TRUTH_MAP_TOPIC, JSON_ENCODING, &BTreeMap::new())?;
            mcap.write_to_known_channel(&header(channel), &map.to_json())?;
        }
        if let (Some(odometry), Some(transforms)) = (&scene.odometry, scene.transforms()) {
            let (odometry_channel, tf_channel) = match motion {
                Some(channels) => channels,
                None => {
                    let channels = (
                        ros_channel::<Odometry>(&mut mcap, ODOMETRY_TOPIC)?,
                        ros_channel::<TfMessage>(&mut mcap, TF_TOPIC)?,
                    );
                    *motion.insert(channels)
                }
            };
            mcap.write_to_known_channel(&header(odometry_channel), &odometry.encode(Endian::Little))?;
            mcap.write_to_known_channel(&header(tf_channel), &transforms.encode(Endian::Little))?;
        }
        *written += 1;
    }
    mcap.finish()?;
    Ok(())
}

fn ros_channel<M: Message>(mcap: &mut mcap::Writer<BufWriter<File>>, topic: &str) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(M::SCHEMA_NAME, SCHEMA_ENCODING, M::SCHEMA_TEXT.as_bytes())?;
    mcap.add_channel(schema, topic, CDR_ENCODING, &BTreeMap::new())
}
