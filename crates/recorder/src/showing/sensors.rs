//! What else an MCAP recording holds, by way of Rerun's own converter: point clouds, cameras, transforms.
//!
//! Its messages are put under `/mcap`, on the timelines of the flight: `stamp` by the time in their header (their log
//! time without one), `revolution` by the latest revolution at that time. One static transform ties the sensor's frame
//! to the body frame that walls and openings are drawn in.

use std::io::{BufReader, ErrorKind};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crosscut_rrd::{Recording, Value};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::{EntityPath, StoreId};
use rerun::log::{Chunk, LogMsg};
use rerun::{
    ComponentDescriptor, CoordinateFrame, Quaternion, RecordingStreamBuilder, StoreKind, TimeColumn, Transform3D,
    TransformRelation,
};

use super::error::ShowError;
use crate::RecorderError;
use crate::schema::SCAN_MOUNTING;

/// Where it is put.
pub(crate) const ROOT: &str = "mcap";
/// The converter's names of the times of a message, the best first.
const STAMPS: [&str; 2] = ["ros2_timestamp", "message_log_time"];
/// Only what can be seen: raw messages and reflections of unknown types would be large.
const DECODERS: [&str; 3] = ["ros2msg", "foxglove", "urdf"];
/// Archetypes that are pictures.
const PICTURES: [&str; 5] = ["EncodedImage:", "Image:", "DepthImage:", "EncodedDepthImage:", "VideoStream:"];

/// Hands over what `path` holds. Gives the entities that are pictures.
///
/// # Errors
/// When the converter is not there, or cannot read the file.
pub(super) fn send(
    path: &Path,
    store: &StoreId,
    revolutions: &[[i64; 2]],
    take: &mut dyn FnMut(LogMsg) -> bool,
) -> Result<Vec<String>, ShowError> {
    let cannot = |cause: String| ShowError::Sensors { path: path.to_owned(), cause };
    let mut converter = Converter::start(path, store)?;
    let output = converter.0.stdout.take().expect("it is piped");
    let mut pictures: Vec<String> = Vec::new();
    let mut wanted = true;
    for message in DecoderApp::decode_lazy(BufReader::new(output)) {
        let LogMsg::ArrowMsg(id, arrow) = message.map_err(|e| cannot(e.to_string()))? else { continue };
        if id.kind() != StoreKind::Recording {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&arrow).map_err(|e| cannot(e.to_string()))?;
        if chunk.entity_path().to_string().starts_with("/__") {
            continue; // properties of the file, not of the flight
        }
        let chunk = on_our_timelines(&chunk, revolutions).map_err(|e| cannot(e.to_string()))?;
        let entity = chunk.entity_path().to_string();
        let is_picture = |name: &str| PICTURES.iter().any(|archetype| name.starts_with(archetype));
        if !pictures.contains(&entity) && chunk.components_identifiers().any(|name| is_picture(name.as_str())) {
            pictures.push(entity);
        }
        let arrow = chunk.to_arrow_msg().map_err(|e| cannot(e.to_string()))?;
        wanted = take(LogMsg::ArrowMsg(store.clone(), arrow));
        if !wanted {
            break;
        }
    }
    let ended = converter.0.wait().map_err(|e| cannot(e.to_string()))?;
    if wanted && !ended.success() {
        return Err(cannot(format!("`rerun mcap convert` ended with {ended}")));
    }
    Ok(pictures)
}

/// Rerun's converter at work; ended when it is dropped.
struct Converter(Child);

impl Converter {
    fn start(path: &Path, store: &StoreId) -> Result<Self, ShowError> {
        let mut command = Command::new("rerun");
        command.args(["mcap", "convert", "--recover", "--disable-raw-fallback"]).arg(path);
        command.args(["--application-id", store.application_id().as_str()]);
        command.args(["--recording-id", store.recording_id().as_str()]);
        command.args(DECODERS.iter().flat_map(|decoder| ["--decoder", decoder]));
        command.env("RUST_LOG", "error").stdin(Stdio::null()).stdout(Stdio::piped());
        command.spawn().map(Self).map_err(|error| match error.kind() {
            ErrorKind::NotFound => RecorderError::NoViewer.into(),
            _ => ShowError::Sensors { path: path.to_owned(), cause: format!("`rerun mcap convert`: {error}") },
        })
    }
}

impl Drop for Converter {
    fn drop(&mut self) {
        self.0.kill().ok(); // it may have ended
        self.0.wait().ok();
    }
}

/// The chunk under [`ROOT`], with `stamp` and `revolution` as its only timelines; static stays static.
fn on_our_timelines(chunk: &Chunk, revolutions: &[[i64; 2]]) -> Result<Chunk, rerun::log::ChunkError> {
    let under = EntityPath::from(ROOT).join(chunk.entity_path());
    let stamps = STAMPS.iter().find_map(|name| chunk.timelines().get(&(*name).into()));
    let stamps: Option<Vec<i64>> = stamps.map(|column| column.times_raw().to_vec());
    let mut chunk = chunk.clone_with_new_entity_path(under);
    if let Some(stamps) = stamps {
        let revolutions = stamps.iter().map(|&stamp_ns| revolution_at(revolutions, stamp_ns));
        chunk.add_timeline(TimeColumn::new_sequence("revolution", revolutions))?;
        chunk.add_timeline(TimeColumn::new_timestamp_nanos_since_epoch("stamp", stamps))?;
        chunk = chunk.timelines_sliced(&["revolution".into(), "stamp".into()].into_iter().collect());
    }
    Ok(chunk)
}

/// The revolution that was the latest at this time, by stamps and numbers; before the first one, the first.
fn revolution_at(revolutions: &[[i64; 2]], stamp_ns: i64) -> i64 {
    let after = revolutions.partition_point(|[stamp, _]| *stamp <= stamp_ns);
    revolutions.get(after.saturating_sub(1)).map_or(0, |[_, seq]| *seq)
}

/// Ties the sensor's frame to the body frame, which is the root of our entities.
pub(super) fn tie(store: &StoreId, recording: &Recording) -> Result<Vec<LogMsg>, ShowError> {
    let mounted = |of: ComponentDescriptor| recording.value_throughout(SCAN_MOUNTING.path, of.component.as_str());
    let Some(Value::Texts(frame)) = mounted(CoordinateFrame::descriptor_frame())? else { return Ok(Vec::new()) };
    let turned = mounted(Transform3D::descriptor_quaternion())?.map(|xyzw| xyzw.to_f64());
    let build = || -> rerun::RecordingStreamResult<Vec<LogMsg>> {
        let (scratch, storage) = RecordingStreamBuilder::from_store_id(store).send_properties(false).memory()?;
        let mut tie = Transform3D::new()
            .with_parent_frame(frame.concat())
            .with_child_frame("tf#/")
            .with_relation(TransformRelation::ChildFromParent);
        if let Some([x, y, z, w]) = turned.as_deref() {
            tie = tie.with_quaternion(Quaternion::from_xyzw([x, y, z, w].map(|part| *part as f32)));
        }
        scratch.log_static(format!("{ROOT}/tie"), &tie)?;
        let mut messages = storage.take();
        messages.retain(|message| matches!(message, LogMsg::ArrowMsg(..)));
        Ok(messages)
    };
    Ok(build().map_err(crate::RecorderError::from)?)
}
