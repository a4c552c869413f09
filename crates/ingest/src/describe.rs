//! What is in a recording, without running it.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use crosscut_messages::{NS_PER_S, ScanDecoder, ScanMessage};
use crosscut_sensor::Sensor;
use crosscut_stage::{Notes, Revolution, Sweep, counted};

use crate::clock::Clock;
use crate::container::{self, Contents, TopicReader};
use crate::topics::{channels_of_each, topics_of};
use crate::turns::{Turn, Turns};
use crate::{IngestError, Loss, LossKind, ReadOptions, TopicInfo, limits};

/// At least this many revolutions of a topic are looked at, and as many as show its parts of turns and blind sectors.
const SCANS_SAMPLED: usize = 50;
/// Fewer clouds, once so many bytes of them were.
const BYTES_SAMPLED: usize = 16 << 20;

/// What is in one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Name of its format, such as `MCAP`.
    pub format: &'static str,
    /// What else there is to say of the file: a name (`index`) and its value, empty if the file does not say.
    pub properties: Vec<(&'static str, String)>,
    /// First and last log time, nanoseconds since the epoch, if there are messages; without those that cannot be right.
    pub log_time_ns: Option<[u64; 2]>,
    /// Whether there are log times that cannot be right.
    pub has_odd_times: bool,
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
    /// Its first scan of those that the sensor takes, if it carries any. Only the first 256 topics with scans are looked at.
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
    /// Share of beams without a return in the first scans of the topic.
    pub missing: f64,
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

/// Looks into one file; scans are described as `sensor` sees them. Of `options`, the geometry of tables is used, and what
/// topics without a schema are to be read as.
///
/// # Errors
/// When it cannot be opened or is of no format that can be read.
pub fn describe(path: &Path, sensor: &Sensor, options: &ReadOptions) -> Result<Description, IngestError> {
    let mut container = container::open(path, &options.csv)?;
    let Contents { bytes, format, properties, losses, .. } = container.contents().clone();
    let (log_time_ns, has_odd_times) = span(container.contents());
    let (path, topics) = (path.to_owned(), Vec::new());
    let mut description = Description { path, bytes, format, properties, log_time_ns, has_odd_times, topics, losses };
    let duration_s = description.duration_s().filter(|duration_s| *duration_s > 0.0);
    let topics = topics_of(std::iter::once(container.contents()));
    let channels = channels_of_each(container.contents());
    let mut described = 0;
    for (info, channels) in topics.into_iter().zip(channels) {
        let spans = info.messages.map(|messages| messages.saturating_sub(1) as f64);
        let rate_hz = spans.zip(duration_s).map(|(spans, duration_s)| spans / duration_s);
        let mut first_scan = None;
        let read_as = options.read_as.filter(|_| info.type_name.is_empty());
        if let Some(decoder) =
            info.decoder(read_as).filter(|_| info.messages != Some(0) && described < limits::DESCRIBED)
        {
            described += 1;
            let mut reader = TopicReader::new(container, channels);
            first_scan = describe_first(&mut reader, &info, decoder, sensor, &mut description.losses);
            container = reader.container;
        }
        description.topics.push(TopicDescription { info, rate_hz, first_scan });
    }
    Ok(description)
}

/// First and last log time without those that cannot be right, and whether there are any of these.
fn span(contents: &Contents) -> (Option<[u64; 2]>, bool) {
    let sample = || contents.log_times_ns.taken().iter().copied();
    let clock = Clock::new(&[], sample());
    match contents.log_times_ns.span_ns {
        Some(span) if !span.into_iter().all(|ns| clock.believes(ns)) => {
            let believed = || sample().filter(|ns| clock.believes(*ns));
            (believed().min().zip(believed().max()).map(|(first, last)| [first, last]), true)
        }
        span => (span, false),
    }
}

/// Describes the first scan of a topic that `sensor` takes; messages that are parts of a turn are joined.
fn describe_first(
    reader: &mut TopicReader,
    topic: &TopicInfo,
    mut decoder: ScanDecoder,
    sensor: &Sensor,
    losses: &mut Vec<Loss>,
) -> Option<ScanDescription> {
    decoder.echo = sensor.echo();
    let mut turns = Turns::new(!decoder.gives_clouds(), sensor.finds_blind_sectors());
    turns = if decoder.gives_clouds() { turns.limited(BYTES_SAMPLED as u64) } else { turns };
    let (mut sample, mut seq, mut bytes) = (Sample::default(), 0, 0);
    let is_enough = |sample: &Sample, bytes: usize| sample.scans > 0 && bytes > BYTES_SAMPLED;
    while (sample.scans < SCANS_SAMPLED && !is_enough(&sample, bytes)) || !turns.is_settled() {
        let message = reader.next();
        for loss in reader.take_losses() {
            if !losses.contains(&loss) {
                losses.push(loss);
            }
        }
        let Some(message) = message else { break };
        if message.damage.is_some() {
            seq += 1;
            continue;
        }
        let mut scan = turns.place();
        if let Err(cause) = decoder.decode_into(&message.data, &mut scan) {
            let kind = LossKind::Messages { topic: topic.name.clone(), first_seq: seq, count: 1, cause };
            losses.push(Loss { file: reader.container.contents().path.clone(), kind });
            break;
        }
        bytes += if decoder.gives_clouds() { message.data.len() } else { 0 };
        if sensor.frame_id().is_none_or(|wanted| wanted == scan.header().frame_id) {
            turns.push(Turn { scan: Ok(scan), ..Turn::new(seq, 0) }, sensor);
            sample.take(&mut turns, sensor);
        }
        reader.container.recycle(message);
        seq += 1;
    }
    turns.finish(sensor);
    sample.take(&mut turns, sensor);
    sample.describe()
}

/// The first revolutions of a topic.
#[derive(Default)]
struct Sample {
    scans: usize,
    beams: usize,
    returns: usize,
    first: Option<ScanDescription>,
    /// Whether messages of the first revolution are missing, as where a recording begins within a turn.
    is_first_partial: bool,
}

impl Sample {
    /// Looks at the revolutions that are complete. One with missing messages counts only if there is no other.
    fn take(&mut self, turns: &mut Turns, sensor: &Sensor) {
        while let Some(turn) = turns.pop(sensor) {
            let is_partial = turn.missing.contains(&true);
            if let Ok(scan) = &turn.scan
                && (self.first.is_none() || !is_partial)
            {
                let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
                turns.show(&turn, scan, None, sensor, &mut revolution, &mut notes);
                if self.first.is_none() || self.is_first_partial {
                    self.first = Some(describe_scan(scan, &revolution, &notes));
                    (self.is_first_partial, self.beams, self.returns) = (is_partial, 0, 0);
                }
                self.scans += 1;
                self.beams += revolution.sweep.as_ref().map_or(0, Sweep::len);
                self.returns += revolution.len();
            }
            turns.recycle(turn);
        }
    }

    fn describe(self) -> Option<ScanDescription> {
        let missing = if self.beams > 0 { 1.0 - self.returns as f64 / self.beams as f64 } else { 0.0 };
        self.first.map(|first| ScanDescription { missing, ..first })
    }
}

fn describe_scan(scan: &ScanMessage, revolution: &Revolution, notes: &Notes) -> ScanDescription {
    let (range_m, ranges) = match scan {
        ScanMessage::Scan(scan) => ([scan.range_min, scan.range_max], &scan.ranges[..]),
        ScanMessage::Cloud(_) => ([0.0, f32::INFINITY], &[][..]),
    };
    // Ordinary with many drivers, so no note of each revolution; but others mean that nothing is known.
    let not_numbers = ranges.iter().filter(|range| range.is_nan()).count() as u64;
    let of_nan = (not_numbers > 0).then(|| format!("{} of range NaN read as no return", counted(not_numbers, "beam")));
    let none = Sweep::default();
    let sweep = revolution.sweep.as_ref().unwrap_or(&none);
    let steps = sweep.len().saturating_sub(1) as f64;
    ScanDescription {
        frame_id: revolution.frame_id.clone(),
        beams: sweep.len(),
        returns: revolution.points_m.len(),
        missing: 0.0,
        step_rad: sweep.step_rad,
        field_of_view_rad: if sweep.step_rad < TAU { sweep.step_rad * steps } else { 0.0 },
        full_turn: sweep.view().full_turn,
        range_m,
        notes: of_nan.into_iter().chain(notes.iter().map(str::to_owned)).collect(),
    }
}
