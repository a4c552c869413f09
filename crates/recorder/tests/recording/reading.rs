//! Reads an .rrd back: values by entity, component and revolution.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crosscut_recorder::{Recorder, RecorderOptions, Scope};
use crosscut_stage::{Frame, Observer as _};
use rerun::external::arrow::array::ArrayRef;
use rerun::external::image::{self, GrayImage};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::{EntityPath, LogMsg};
use rerun::log::Chunk;
use rerun::{Component, ComponentDescriptor, EncodedDepthImage, StoreKind, Tensor, TensorBuffer, components};

/// What a footer ends with: its identifier, and one entry.
const FOOTER_END: &[u8] = b"RRF2FOOT\x01\0\0\0";

/// The recording's own chunks, without those of the layout.
pub(crate) struct Recording {
    pub(crate) chunks: Vec<Chunk>,
    /// Messages of the layout.
    pub(crate) layout_messages: usize,
    /// Which recordings the chunks belong to.
    pub(crate) stores: BTreeSet<String>,
    /// Whether the file was brought to its end.
    pub(crate) has_footer: bool,
}

/// Records the frames, to the end, and reads them back.
pub(crate) fn recorded(frames: &[Frame]) -> Recording {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("flight.rrd");
    record(&path, frames);
    Recording::read(&path)
}

pub(crate) fn record(path: &Path, frames: &[Frame]) {
    record_of(path, frames, Scope::default());
}

/// Records what `scope` says.
pub(crate) fn record_of(path: &Path, frames: &[Frame], scope: Scope) {
    record_with(RecorderOptions { scope, ..options(path) }, frames);
}

pub(crate) fn record_with(options: RecorderOptions, frames: &[Frame]) {
    let mut recorder = Recorder::new(options).expect("a recorder");
    for frame in frames {
        recorder.observe(frame).expect("the frame is recorded");
    }
    recorder.finish().expect("the recording ends well");
}

pub(crate) fn options(path: &Path) -> RecorderOptions {
    RecorderOptions {
        path: Some(path.to_owned()),
        name: "tee".to_owned(),
        config_toml: "[affinity]\nkind = \"rbf\"\n".to_owned(),
        ..RecorderOptions::default()
    }
}

impl Recording {
    pub(crate) fn read(path: &Path) -> Self {
        let has_footer = std::fs::read(path).expect("the recording is there").ends_with(FOOTER_END);
        let mut recording = Self { chunks: Vec::new(), layout_messages: 0, stores: BTreeSet::new(), has_footer };
        let file = BufReader::new(File::open(path).expect("the recording is there"));
        for message in DecoderApp::decode_eager(file).expect("an .rrd") {
            match message.expect("a whole message") {
                LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                    recording.stores.insert(format!("{store:?}"));
                    recording.chunks.push(Chunk::from_arrow_msg(&message).expect("a chunk"));
                }
                message => recording.layout_messages += usize::from(message.store_id().kind() == StoreKind::Blueprint),
            }
        }
        recording
    }

    pub(crate) fn of<'a>(&'a self, entity: &str) -> impl Iterator<Item = &'a Chunk> + use<'a> {
        let entity = EntityPath::parse_strict(entity).expect("an entity path");
        self.chunks.iter().filter(move |chunk| *chunk.entity_path() == entity)
    }

    /// What was logged of a component at a revolution; `None` if nothing was.
    pub(crate) fn at<C: Component>(&self, entity: &str, component: ComponentDescriptor, seq: i64) -> Option<Vec<C>> {
        self.of(entity).find_map(|chunk| {
            let row = times(chunk, "revolution").iter().position(|&time| time == seq)?;
            Some(chunk.component_batch(component.component, row)?.expect("values of this type"))
        })
    }

    /// The texts of all rows of a revolution.
    pub(crate) fn texts(&self, entity: &str, component: ComponentDescriptor, seq: i64) -> Vec<String> {
        let mut texts = Vec::new();
        for chunk in self.of(entity) {
            for (row, _) in times(chunk, "revolution").iter().enumerate().filter(|(_, time)| **time == seq) {
                let text: Option<Vec<components::Text>> =
                    chunk.component_batch(component.component, row).map(|text| text.expect("text"));
                texts.extend(text.into_iter().flatten().map(|text| text.to_string()));
            }
        }
        texts
    }

    pub(crate) fn scalar(&self, entity: &str, seq: i64) -> Option<f64> {
        let values: Vec<components::Scalar> = self.at(entity, rerun::Scalars::descriptor_scalars(), seq)?;
        values.first().map(|value| value.0.0)
    }

    /// A logged tensor: its shape and values.
    pub(crate) fn tensor(&self, entity: &str, seq: i64) -> Option<(Vec<u64>, TensorBuffer)> {
        let tensors: Vec<components::TensorData> = self.at(entity, Tensor::descriptor_data(), seq)?;
        tensors.into_iter().next().map(|tensor| (tensor.0.shape.to_vec(), tensor.0.buffer))
    }

    pub(crate) fn f64s(&self, entity: &str, seq: i64) -> (Vec<u64>, Vec<f64>) {
        match self.tensor(entity, seq) {
            Some((shape, TensorBuffer::F64(values))) => (shape, values.to_vec()),
            other => panic!("{entity} at {seq}: {other:?}"),
        }
    }

    pub(crate) fn f32s(&self, entity: &str, seq: i64) -> (Vec<u64>, Vec<f32>) {
        match self.tensor(entity, seq) {
            Some((shape, TensorBuffer::F32(values))) => (shape, values.to_vec()),
            other => panic!("{entity} at {seq}: {other:?}"),
        }
    }

    pub(crate) fn picture(&self, entity: &str, seq: i64) -> Option<GrayImage> {
        let blobs: Vec<components::Blob> = self.at(entity, EncodedDepthImage::descriptor_blob(), seq)?;
        blobs.first().map(|blob| image::load_from_memory(&blob.0.0).expect("a picture").to_luma8())
    }

    /// The revolutions that an entity was logged at.
    pub(crate) fn revolutions(&self, entity: &str) -> BTreeSet<i64> {
        self.of(entity).flat_map(|chunk| times(chunk, "revolution")).collect()
    }

    /// Every value, by entity, component and revolution (none if it is static).
    pub(crate) fn content(&self) -> BTreeMap<(String, String, Option<i64>), ArrayRef> {
        let mut content = BTreeMap::new();
        for chunk in &self.chunks {
            let times = times(chunk, "revolution");
            for component in chunk.components_identifiers() {
                for row in 0..chunk.num_rows() {
                    let Some(value) = chunk.component_batch_raw(component, row) else { continue };
                    let key = (chunk.entity_path().to_string(), component.to_string(), times.get(row).copied());
                    content.insert(key, value.expect("a row"));
                }
            }
        }
        content
    }
}

/// The times of a chunk's rows; none for a static chunk.
pub(crate) fn times(chunk: &Chunk, timeline: &'static str) -> Vec<i64> {
    chunk.timelines().get(&timeline.into()).map_or_else(Vec::new, |column| column.times_raw().to_vec())
}
