//! Small flights, built in memory.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{Endian, Header, LaserScan, Message, Time};
use crosscut_sensor::{PARAMS, Sensor, VEHICLE_PARAMS};
use crosscut_stage::{Notes, Params, Revolution, Source, Value};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

pub(crate) const START_NS: u64 = 1_700_000_000_000_000_000;
pub(crate) const STEP_NS: u64 = 100_000_000;
const SCAN_TYPE: (&str, &str) = (LaserScan::SCHEMA_NAME, "cdr");

/// A message as it goes into a recording.
#[derive(Clone)]
pub(crate) struct Record {
    pub(crate) topic: &'static str,
    pub(crate) type_name: &'static str,
    pub(crate) encoding: &'static str,
    pub(crate) log_time_ns: u64,
    pub(crate) data: Vec<u8>,
}

/// Scan number `i`: eight beams, told apart by the first range.
pub(crate) fn scan(i: u64) -> LaserScan {
    let mut ranges = vec![1.0 + i as f32 / 64.0, 2.0, 3.0, f32::NAN, 5.0, 6.0, 7.0, 8.0];
    ranges[7] -= (i % 5) as f32;
    LaserScan {
        header: Header { stamp: Time::from_ns(time_ns(i)), frame_id: "laser".to_owned() },
        angle_max: 0.7,
        angle_increment: 0.1,
        range_max: 30.0,
        ranges,
        ..LaserScan::default()
    }
}

pub(crate) fn time_ns(i: u64) -> u64 {
    START_NS + i * STEP_NS
}

pub(crate) fn record_at(topic: &'static str, log_time_ns: u64, scan: &LaserScan) -> Record {
    let (type_name, encoding) = SCAN_TYPE;
    Record { topic, type_name, encoding, log_time_ns, data: scan.encode(Endian::Little) }
}

/// The same scan as ROS 1 writes it.
pub(crate) fn ros1_record_at(topic: &'static str, log_time_ns: u64, scan: &LaserScan) -> Record {
    let LaserScan { header: Header { stamp, frame_id }, ranges, intensities, .. } = scan;
    let mut data = Vec::new();
    for number in [7, stamp.sec as u32, stamp.nanosec, frame_id.len() as u32] {
        data.extend(number.to_le_bytes());
    }
    data.extend(frame_id.as_bytes());
    for number in [scan.angle_min, scan.angle_max, scan.angle_increment, scan.time_increment, scan.scan_time] {
        data.extend(number.to_le_bytes());
    }
    data.extend([scan.range_min, scan.range_max].into_iter().flat_map(f32::to_le_bytes));
    for sequence in [ranges, intensities] {
        data.extend((sequence.len() as u32).to_le_bytes());
        data.extend(sequence.iter().copied().flat_map(f32::to_le_bytes));
    }
    Record { topic, type_name: LaserScan::ROS1_SCHEMA_NAME, encoding: "ros1", log_time_ns, data }
}

/// `count` scans on /scan, one every 0.1 s.
pub(crate) fn plain_flight(count: u64) -> Vec<Record> {
    (0..count).map(|i| record_at("/scan", time_ns(i), &scan(i))).collect()
}

/// How a recording is written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    pub(crate) compression: Option<Compression>,
    pub(crate) chunked: bool,
    pub(crate) summary: bool,
}

impl Form {
    pub(crate) const CHUNKED: Self = Self { compression: None, chunked: true, summary: true };

    pub(crate) fn all() -> Vec<Self> {
        let mut forms = Vec::new();
        for summary in [true, false] {
            for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
                forms.push(Self { compression, chunked: true, summary });
            }
            forms.push(Self { compression: None, chunked: false, summary });
        }
        forms
    }

    pub(crate) fn is_indexed(self) -> bool {
        self.chunked && self.summary
    }

    /// An MCAP with five messages a chunk.
    pub(crate) fn write(self, records: &[Record]) -> Vec<u8> {
        self.write_with(WriteOptions::new(), records)
    }

    /// An MCAP with five messages a chunk and no checksums.
    #[allow(dead_code)] // for the seeds of fuzzing
    pub(crate) fn write_unchecked(self, records: &[Record]) -> Vec<u8> {
        let options = WriteOptions::new().calculate_chunk_crcs(false).calculate_data_section_crc(false);
        self.write_with(options.calculate_summary_section_crc(false), records)
    }

    fn write_with(self, options: WriteOptions, records: &[Record]) -> Vec<u8> {
        let options = options
            .profile("ros2")
            .library("test")
            .compression(self.compression)
            .use_chunks(self.chunked)
            .chunk_size(None)
            .emit_summary_records(self.summary)
            .emit_summary_offsets(self.summary);
        let mut writer = options.create(Cursor::new(Vec::new())).expect("in memory");
        for (i, record) in records.iter().enumerate() {
            let schema = writer.add_schema(record.type_name, "ros2msg", b"").expect("a schema");
            let channel =
                writer.add_channel(schema, record.topic, record.encoding, &BTreeMap::new()).expect("a channel");
            let header = MessageHeader {
                channel_id: channel,
                sequence: i as u32,
                log_time: record.log_time_ns,
                publish_time: record.log_time_ns,
            };
            writer.write_to_known_channel(&header, &record.data).expect("in memory");
            if self.chunked && i % 5 == 4 {
                writer.flush().expect("in memory");
            }
        }
        writer.finish().expect("in memory");
        writer.into_inner().into_inner()
    }
}

/// Where each message ends in a file that does not compress them.
pub(crate) fn message_ends(bytes: &[u8], records: &[Record]) -> Vec<usize> {
    let end_of = |data: &[u8]| bytes.windows(data.len()).position(|found| found == data).map(|at| at + data.len());
    records.iter().map(|record| end_of(&record.data).expect("the message is there")).collect()
}

/// A folder that goes away with the test.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn add(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        // Some file systems write a file to the disk at once if it was emptied first; a new one may wait.
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, bytes).expect("a temporary file");
        path
    }
}

pub(crate) fn sensor(given: &[(&str, Value)]) -> Sensor {
    let mut params = Params::defaults(PARAMS);
    for (name, value) in given {
        params.set(name, value.clone()).expect("allowed");
    }
    Sensor::new(&params, &Params::defaults(VEHICLE_PARAMS))
}

/// What came out of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Read {
    pub(crate) seqs: Vec<u64>,
    pub(crate) stamps_ns: Vec<u64>,
    /// Ranges of each revolution, bit by bit.
    pub(crate) ranges: Vec<Vec<u32>>,
    pub(crate) notes: Vec<Vec<String>>,
}

impl Read {
    pub(crate) fn len(&self) -> usize {
        self.seqs.len()
    }
}

/// Reads to the end.
pub(crate) fn drain(recording: &mut Recording) -> Read {
    let (mut out, mut revolution) = (Read::default(), Revolution::default());
    loop {
        let mut notes = Notes::default();
        if !recording.next(&mut revolution, &mut notes).expect("the source goes on") {
            return out;
        }
        out.seqs.push(revolution.seq);
        out.stamps_ns.push(revolution.stamp_ns);
        let sweep = revolution.sweep.as_ref().expect("a scan has beams");
        out.ranges.push(sweep.ranges_m.iter().map(|range| range.to_bits()).collect());
        out.notes.push(notes.iter().map(str::to_owned).collect());
    }
}

/// Opens one file with nothing asked for.
pub(crate) fn open(path: &Path) -> Result<Recording, crosscut_ingest::IngestError> {
    Recording::open(&[path.to_owned()], &ReadOptions::default(), sensor(&[]))
}

/// What the first `count` scans of [`plain_flight`] read as.
pub(crate) fn expected(count: u64) -> Read {
    Read {
        seqs: (0..count).collect(),
        stamps_ns: (0..count).map(time_ns).collect(),
        ranges: (0..count).map(|i| scan(i).ranges.iter().map(|range| range.to_bits()).collect()).collect(),
        notes: vec![Vec::new(); count as usize],
    }
}
