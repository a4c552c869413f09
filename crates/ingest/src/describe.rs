//! What is in a recording, without running it.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use crosscut_messages::{ScanDecoder, ScanMessage, ScanType};
use crosscut_stage::{Notes, Revolution, counted};

use crate::container::{Container, TopicReader};
use crate::topics::topics_of;
use crate::{IngestError, Loss, LossKind, Sensor, TopicInfo};

const NS_PER_S: f64 = 1e9;

/// What is in one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Profile, such as `ros2`; empty if it states none.
    pub profile: String,
    /// The program that wrote it; empty if it does not say.
    pub library: String,
    /// Chunks in its index; `None` if it has no index, so that messages come in file order.
    pub indexed_chunks: Option<usize>,
    /// How its chunks are compressed (`none`, `zstd`, `lz4`), as far as the index says.
    pub compressions: BTreeSet<String>,
    /// First and last log time, nanoseconds since the epoch, if there are messages.
    pub log_time_ns: Option<[u64; 2]>,
    /// Its topics, by name.
    pub topics: Vec<TopicDescription>,
    /// What was found to be lost. Without an index that is all; with one, the chunks were not read, only the first
    /// scan of each topic.
    pub losses: Vec<Loss>,
}

/// One topic.
#[derive(Clone, Debug, PartialEq)]
pub struct TopicDescription {
    /// Name, type, encoding, count.
    pub info: TopicInfo,
    /// Messages a second, on average over the whole file.
    pub rate_hz: Option<f64>,
    /// Its first scan of those that the sensor takes, if it carries any.
    pub first_scan: Option<ScanDescription>,
}

/// One scan as `sensor` sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanDescription {
    /// The sensor's frame.
    pub frame_id: String,
    /// Number of beams.
    pub beams: usize,
    /// Number of returns.
    pub returns: usize,
    /// Angle from one beam to the next, as used.
    pub step_rad: f64,
    /// Angle from the first beam to the last, as used; 0 if no beam has a bearing.
    pub field_of_view_rad: f64,
    /// The beams go all the way round, and look out everywhere.
    pub full_turn: bool,
    /// Shortest and longest range, as the scan states them, m.
    pub range_m: [f32; 2],
    /// What the rules of ingest say of it.
    pub notes: Vec<String>,
}

impl Description {
    /// From the first to the last message, s.
    pub fn duration_s(&self) -> Option<f64> {
        self.log_time_ns.map(|[first, last]| last.saturating_sub(first) as f64 / NS_PER_S)
    }
}

/// Looks into one file; scans are described as `sensor` sees them. Messages of topics without a schema are read as
/// `read_as`, if that is given.
///
/// # Errors
/// When it cannot be opened or is no MCAP.
pub fn describe(path: &Path, sensor: &Sensor, read_as: Option<ScanType>) -> Result<Description, IngestError> {
    let mut container = Container::open(path)?;
    let (profile, library) = container.header().unwrap_or_default();
    let compressed = |chunk: &mcap::records::ChunkIndex| match chunk.compression.as_str() {
        "" => "none".to_owned(),
        name => name.to_owned(),
    };
    let mut description = Description {
        path: path.to_owned(),
        bytes: container.length,
        profile,
        library,
        indexed_chunks: (!container.chunks.is_empty()).then_some(container.chunks.len()),
        compressions: container.chunks.iter().map(compressed).collect(),
        log_time_ns: container.catalogue.log_time_ns,
        topics: Vec::new(),
        losses: container.losses.clone(),
    };
    let duration_s = description.duration_s().filter(|duration_s| *duration_s > 0.0);
    for info in topics_of(std::slice::from_ref(&container)) {
        let spans = info.messages.map(|messages| messages.saturating_sub(1) as f64);
        let rate_hz = spans.zip(duration_s).map(|(spans, duration_s)| spans / duration_s);
        let mut first_scan = None;
        let read_as = read_as.filter(|_| info.type_name.is_empty());
        if let Some(decoder) = info.decoder(read_as) {
            let channels = info.channels_in(&container);
            let mut reader = TopicReader::new(container, channels);
            first_scan = describe_first(&mut reader, &info, decoder, sensor, &mut description.losses);
            container = reader.into_container();
        }
        description.topics.push(TopicDescription { info, rate_hz, first_scan });
    }
    Ok(description)
}

fn describe_first(
    reader: &mut TopicReader,
    topic: &TopicInfo,
    mut decoder: ScanDecoder,
    sensor: &Sensor,
    losses: &mut Vec<Loss>,
) -> Option<ScanDescription> {
    decoder.echo = sensor.echo();
    let mut scan = ScanMessage::default();
    let mut seq = 0;
    loop {
        let message = reader.next();
        for loss in reader.take_losses() {
            if !losses.contains(&loss) {
                losses.push(loss);
            }
        }
        let message = message?;
        if let Err(cause) = decoder.decode_into(&message.data, &mut scan) {
            let kind = LossKind::Messages { topic: topic.name.clone(), first_seq: seq, count: 1, cause };
            losses.push(Loss { file: reader.container().path.clone(), kind });
            return None;
        }
        if sensor.frame_id().is_none_or(|wanted| wanted == scan.header().frame_id) {
            break;
        }
        reader.recycle(message);
        seq += 1;
    }
    let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
    // Ordinary with many drivers, so no note of each revolution; but others mean that nothing is known.
    let (range_m, ranges) = match &scan {
        ScanMessage::Scan(scan) => ([scan.range_min, scan.range_max], &scan.ranges[..]),
        ScanMessage::Cloud(_) => ([0.0, f32::INFINITY], &[][..]),
    };
    let not_numbers = ranges.iter().filter(|range| range.is_nan()).count();
    if not_numbers > 0 {
        notes.add(format!("{} of range NaN read as no return", counted(not_numbers as u64, "beam")));
    }
    sensor.message(&scan, &mut revolution, &mut notes);
    let sweep = revolution.sweep.get_or_insert_default();
    Some(ScanDescription {
        frame_id: revolution.frame_id.clone(),
        beams: sweep.len(),
        returns: revolution.points_m.len(),
        step_rad: sweep.step_rad,
        field_of_view_rad: if sweep.step_rad < TAU {
            sweep.step_rad * sweep.len().saturating_sub(1) as f64
        } else {
            0.0
        },
        full_turn: sweep.view().full_turn,
        range_m,
        notes: notes.iter().map(str::to_owned).collect(),
    })
}
