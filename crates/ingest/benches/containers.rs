//! Megabytes per second from a file to revolutions, on one core: `cargo bench -p crosscut-ingest -- FLIGHT...`, or an MCAP
//! of its own. Each line has the best of several passes over a file in the page cache. Of an MCAP it also has the rate at
//! which the `mcap` crate's own reader gives the messages, undecoded.
//!
//! Rates are per second of processor time, so they hold on a machine that has other work as well. Linux only.

use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::fs::{self, File};
use std::hint::black_box;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{CDR_ENCODING, Endian, Header, LaserScan, Message, SCAN_TOPIC, SCHEMA_ENCODING, Time};
use crosscut_sensor::Sensor;
use crosscut_stage::{Notes, Revolution, Source as _};
use mcap::records::MessageHeader;

const SCANS: u64 = 10_000;
const BEAMS: usize = 1080;
const PERIOD_NS: u64 = 25_000_000;
const START_NS: u64 = 1_700_000_000_000_000_000;
const PASSES: usize = 5;

fn main() {
    println!("{:<28}{:>8}{:>13}{:>10}{:>14}", "", "MB", "revolutions", "MB/s", "mcap, MB/s");
    // Cargo adds `--bench`.
    let given: Vec<PathBuf> = std::env::args_os().skip(1).filter(|word| word != "--bench").map(PathBuf::from).collect();
    given.iter().for_each(|path| print_best(path));
    if given.is_empty() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("flight.mcap");
        write_flight(&path).expect("writable");
        print_best(&path);
    }
}

/// Scans of 1080 beams with intensities.
fn write_flight(path: &Path) -> Result<(), mcap::McapError> {
    let options = mcap::WriteOptions::new().compression(None);
    let mut mcap = options.create(BufWriter::new(File::create(path)?))?;
    let schema = mcap.add_schema(LaserScan::SCHEMA_NAME, SCHEMA_ENCODING, LaserScan::SCHEMA_TEXT.as_bytes())?;
    let channel_id = mcap.add_channel(schema, SCAN_TOPIC, CDR_ENCODING, &BTreeMap::new())?;
    let step_rad = TAU / BEAMS as f32;
    for i in 0..SCANS {
        let log_time = START_NS + i * PERIOD_NS;
        let range_m = |beam: usize| 5.0 + 4.0 * (i as f32 * 0.01 + beam as f32 * 0.02).sin();
        let scan = LaserScan {
            header: Header { stamp: Time::from_ns(log_time), frame_id: "laser".to_owned() },
            angle_min: -TAU / 2.0,
            angle_max: -TAU / 2.0 + step_rad * (BEAMS - 1) as f32,
            angle_increment: step_rad,
            range_max: 30.0,
            ranges: (0..BEAMS).map(range_m).collect(),
            intensities: (0..BEAMS).map(|beam| (beam % 256) as f32).collect(),
            ..LaserScan::default()
        };
        let header = MessageHeader { channel_id, sequence: i as u32, log_time, publish_time: log_time };
        mcap.write_to_known_channel(&header, &scan.encode(Endian::Little))?;
    }
    mcap.finish()?;
    Ok(())
}

fn print_best(path: &Path) {
    let mb = fs::metadata(path).expect("a file").len() as f64 / 1e6;
    let (count, rate) = best(mb, || revolutions_in(path));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    print!("{name:<28}{mb:>8.0}{count:>13}{rate:>10.0}");
    match fs::read(path).expect("a file") {
        bytes if bytes.starts_with(mcap::MAGIC) => println!("{:>14.0}", best(mb, || messages_in(path)).1),
        _ => println!("{:>14}", "-"),
    }
}

/// What `read` counts, and its best rate in MB/s.
fn best(mb: f64, read: impl Fn() -> u64) -> (u64, f64) {
    let (mut count, mut least_s) = (0, f64::INFINITY);
    for _ in 0..PASSES {
        let start_s = processor_s();
        count = black_box(read());
        least_s = least_s.min(processor_s() - start_s);
    }
    (count, mb / least_s)
}

fn revolutions_in(path: &Path) -> u64 {
    let options = ReadOptions::default();
    let mut recording = Recording::open(&[path.to_owned()], &options, Sensor::default()).expect("a recording");
    let (mut revolution, mut notes, mut count) = (Revolution::default(), Notes::default(), 0);
    while recording.next(&mut revolution, &mut notes).expect("a source without errors") {
        notes.clear();
        count += 1;
    }
    count
}

fn messages_in(path: &Path) -> u64 {
    let bytes = fs::read(path).expect("a file");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP");
    messages.map(|message| black_box(message.expect("a message").data.len()).min(1) as u64).sum()
}

/// Time that the main thread, the only one, had a processor.
fn processor_s() -> f64 {
    let stat = fs::read_to_string("/proc/self/schedstat").expect("Linux");
    stat.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}
