//! What a recording takes: processor time and bytes a revolution, memory.
//!
//! `cargo bench --workspace --bench recording` records the shipped flight, 1200 revolutions at 10 Hz in a round; `... -- N` takes
//! N. Columns are parted by commas. Beside each recording, in turn, a plain loop of `RecordingStream::log` logs the same
//! rows, which were read back from it: what Rerun itself takes to batch, encode and write them. Times are processor time
//! of all threads, the medians of five rounds. `method` is the time of the stages without a recording.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crosscut_detector::{Config, Engine, Preset, Registry};
use crosscut_ingest::{ReadOptions, Recording};
use crosscut_recorder::{Detail, Recorder, RecorderOptions, Scope};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Observer as _, Source as _};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::log::{Chunk, ChunkBatcherConfig, LogMsg};
use rerun::{EntityPath, RecordingStreamBuilder, SerializedComponentBatch, StoreKind};

const REVOLUTIONS: u64 = 1200;
const ROUNDS: usize = 5;
/// Exact W of every revolution takes 0.5 MB each: a tenth of the revolutions shows as much.
const FULL_SHARE: u64 = 10;
const PERIOD_NS: u64 = 100_000_000;
/// Rows of a revolution go to the file together with those of this many others, as in a recording.
const FLUSH_AFTER: u64 = 25;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Fallible<()> {
    let asked = std::env::args().skip(1).find_map(|arg| arg.parse().ok());
    println!(
        "preset ,level  ,returns,method ms,recording ms,plain loop ms,ratio,kB a revolution,MB a 6000,peak MB so far"
    );
    for preset in ["paper", "default"] {
        let (mut frames, method_ms) = shipped_flight(preset)?;
        for detail in [Detail::Light, Detail::Default, Detail::Full] {
            let revolutions = asked.unwrap_or(REVOLUTIONS) / if detail == Detail::Full { FULL_SHARE } else { 1 };
            let measured = measure(&mut frames, detail, revolutions)?;
            measured.print(preset, detail, median(frames.iter().map(|frame| frame.revolution.len())), method_ms);
        }
    }
    Ok(())
}

/// The frames of the shipped flight, and the milliseconds that the stages took for each.
fn shipped_flight(preset: &str) -> Fallible<(Vec<Frame>, f64)> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/tee.mcap"));
    let registry = Registry::standard();
    let config = Config::preset(Preset::named(preset)?, &registry)?;
    let mut engine = Engine::new(&config, &registry);
    let sensor = Sensor::default();
    let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor)?;
    let (mut frames, mut times_ms) = (Vec::new(), Vec::new());
    loop {
        let mut frame = Frame::default();
        if !recording.next(&mut frame.revolution, &mut frame.notes)? {
            return Ok((frames, median(times_ms)));
        }
        engine.process(&mut frame)?;
        let stages_ns = crosscut_stage::Step::ALL[1..].iter().map(|step| frame.timings.ns(*step)).sum::<u64>();
        times_ms.push(stages_ns as f64 / 1e6);
        frames.push(frame);
    }
}

/// What one preset and level takes a revolution.
struct Measured {
    recording_ms: f64,
    plain_ms: f64,
    ratio: f64,
    kb: f64,
}

impl Measured {
    fn print(&self, preset: &str, detail: Detail, returns: usize, method_ms: f64) {
        let Self { recording_ms, plain_ms, ratio, kb } = self;
        println!(
            "{preset:<7},{:<7},{returns:>7},{method_ms:>9.3},{recording_ms:>12.3},{plain_ms:>13.3},{ratio:>5.2},\
            {kb:>15.1},{:>9.1},{:>14}",
            format!("{detail:?}").to_lowercase(),
            kb * 6.0,
            peak_mb().map_or_else(|| "-".to_owned(), |mb| mb.to_string()),
        );
    }
}

fn measure(frames: &mut [Frame], detail: Detail, revolutions: u64) -> Fallible<Measured> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("flight.rrd");
    record(frames, detail, revolutions, &path)?;
    let kb = path.metadata()?.len() as f64 / 1e3 / revolutions as f64;
    let rows = rows_of(&path, revolutions)?;
    let mut rounds = Vec::new();
    for _ in 0..ROUNDS {
        let recording_ms = record(frames, detail, revolutions, &path)? / revolutions as f64;
        let plain_ms = log_again(&rows, &folder.path().join("plain.rrd"))? / revolutions as f64;
        rounds.push([recording_ms, plain_ms, recording_ms / plain_ms]);
    }
    let [recording_ms, plain_ms, ratio] = [0, 1, 2].map(|at| median(rounds.iter().map(|round| round[at])));
    Ok(Measured { recording_ms, plain_ms, ratio, kb })
}

/// Records the flight again and again; milliseconds of processor time.
fn record(frames: &mut [Frame], detail: Detail, revolutions: u64, path: &Path) -> Fallible<f64> {
    let scope = Scope { detail, ..Scope::default() };
    let path = Some(path.to_owned());
    let mut recorder = Recorder::new(RecorderOptions { path, scope, ..RecorderOptions::default() })?;
    let (start_ms, first_ns) = (processor_ms()?, frames[0].revolution.stamp_ns);
    for seq in 0..revolutions {
        let at = seq as usize % frames.len();
        frames[at].revolution.seq = seq;
        frames[at].revolution.stamp_ns = first_ns + PERIOD_NS * seq;
        recorder.observe(&frames[at])?;
    }
    frames[0].revolution.stamp_ns = first_ns;
    recorder.finish()?;
    Ok(processor_ms()? - start_ms)
}

/// A row of a recording: where it belongs, and its components.
type Row = (EntityPath, Vec<SerializedComponentBatch>);

/// The rows of each revolution, read back.
fn rows_of(path: &Path, revolutions: u64) -> Fallible<Vec<Vec<Row>>> {
    let mut rows = vec![Vec::new(); revolutions as usize];
    for message in DecoderApp::decode_eager(std::io::BufReader::new(std::fs::File::open(path)?))? {
        let LogMsg::ArrowMsg(store, message) = message? else { continue };
        let chunk = Chunk::from_arrow_msg(&message)?;
        let Some(times) = chunk.timelines().get(&"revolution".into()) else { continue };
        if store.kind() != StoreKind::Recording {
            continue;
        }
        for (at, &revolution) in times.times_raw().iter().enumerate() {
            let row = chunk.row_sliced_deep(at, 1);
            let batch = |column: &rerun::SerializedComponentColumn| {
                let array = row.component_batch_raw(column.descriptor.component, 0)?.ok()?;
                Some(SerializedComponentBatch { array, descriptor: column.descriptor.clone() })
            };
            let batches = row.components().values().filter_map(batch).collect();
            rows[revolution as usize].push((chunk.entity_path().clone(), batches));
        }
    }
    Ok(rows)
}

/// Logs rows as any program would; milliseconds of processor time.
fn log_again(rows: &[Vec<Row>], path: &Path) -> Fallible<f64> {
    let batches = ChunkBatcherConfig { flush_tick: Duration::MAX, ..ChunkBatcherConfig::DEFAULT };
    let rec = RecordingStreamBuilder::new("plain").batcher_config(batches).save(path)?;
    let start_ms = processor_ms()?;
    for (seq, rows) in (0..).zip(rows) {
        rec.set_time_sequence("revolution", seq);
        rec.set_timestamp_nanos_since_epoch("stamp", seq * PERIOD_NS.cast_signed());
        for (entity, batches) in rows {
            rec.log_serialized_batches(entity.clone(), false, batches.iter().cloned())?;
        }
        if (seq.unsigned_abs() + 1).is_multiple_of(FLUSH_AFTER) {
            rec.flush_blocking()?;
        }
    }
    rec.flush_blocking()?;
    Ok(processor_ms()? - start_ms)
}

/// Processor time of all threads of this process so far.
fn processor_ms() -> Fallible<f64> {
    /// Linux counts it in hundredths of a second.
    const TICK_MS: f64 = 10.0;
    let stat = std::fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit_once(')').ok_or("no process name")?.1;
    let mut ticks = after_name.split_whitespace().skip(11).map(str::parse::<f64>); // user, then system
    match (ticks.next(), ticks.next()) {
        (Some(user), Some(system)) => Ok(TICK_MS * (user? + system?)),
        _ => Err("no times".into()),
    }
}

fn median<T: PartialOrd + Copy>(values: impl IntoIterator<Item = T>) -> T {
    let mut values: Vec<T> = values.into_iter().collect();
    values.sort_by(|a, b| a.partial_cmp(b).expect("times and counts can be ordered"));
    values[values.len() / 2]
}

/// The largest memory of this process so far, where the system reports it.
fn peak_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kb: u64 =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()?;
    Some(kb / 1000)
}
