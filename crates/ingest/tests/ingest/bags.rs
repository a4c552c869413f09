//! Bags of ROS 1 and rosbag2 databases, built in memory, and where in them each message ends.

use std::collections::BTreeMap;
use std::io::Write as _;

use crate::flight::Record;

/// A file, and how many of its bytes must be there for each message to be whole.
pub(crate) struct Built {
    pub(crate) bytes: Vec<u8>,
    pub(crate) ends: Vec<usize>,
}

/// How the chunks of a bag of ROS 1 are compressed.
pub(crate) const BAG_COMPRESSIONS: [&str; 3] = ["none", "bz2", "lz4"];

const MESSAGES_A_CHUNK: usize = 5;
/// A bag's first record is padded to this size.
const BAG_HEADER_BYTES: usize = 256;

/// A bag of ROS 1 with five messages a chunk; without an index as a recorder leaves it that was killed.
pub(crate) fn ros1_bag(records: &[Record], compression: &str, indexed: bool) -> Built {
    let mut connections: BTreeMap<&str, u32> = BTreeMap::new();
    let (mut bytes, mut ends, mut infos) = (b"#ROSBAG V2.0\n".to_vec(), Vec::new(), Vec::new());
    let header_at = bytes.len();
    bytes.resize(header_at + BAG_HEADER_BYTES, b' ');
    for messages in records.chunks(MESSAGES_A_CHUNK) {
        let (mut data, mut ends_in_data) = (Vec::new(), Vec::new());
        let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
        for record in messages {
            let next = connections.len() as u32;
            let connection = *connections.entry(record.topic).or_insert_with(|| {
                data.extend(connection_record(next, record));
                next
            });
            let fields = [("op", &[2][..]), ("conn", &connection.to_le_bytes()), ("time", &time(record.log_time_ns))];
            data.extend(bag_record(&fields, &record.data));
            ends_in_data.push(data.len());
            *counts.entry(connection).or_default() += 1;
        }
        let packed = compressed(&data, compression);
        let chunk_at = bytes.len() as u64;
        let size = (data.len() as u32).to_le_bytes();
        let fields = [("op", &[5][..]), ("compression", compression.as_bytes()), ("size", &size)];
        bytes.extend(bag_record(&fields, &packed));
        let data_at = bytes.len() - packed.len();
        ends.extend(ends_in_data.iter().map(|end| if compression == "none" { data_at + end } else { bytes.len() }));
        bytes.extend(bag_record(&[("op", &[4]), ("ver", &[1, 0, 0, 0]), ("conn", &[0; 4]), ("count", &[0; 4])], b""));
        let times = messages.iter().map(|record| record.log_time_ns);
        let (first, last) = (times.clone().min().expect("some"), times.max().expect("some"));
        let pairs: Vec<u8> =
            counts.iter().flat_map(|(id, count)| [id.to_le_bytes(), count.to_le_bytes()].concat()).collect();
        let fields = [
            ("op", &[6][..]),
            ("ver", &[1, 0, 0, 0]),
            ("chunk_pos", &chunk_at.to_le_bytes()),
            ("start_time", &time(first)),
            ("end_time", &time(last)),
            ("count", &(counts.len() as u32).to_le_bytes()),
        ];
        infos.push(bag_record(&fields, &pairs));
    }
    let index_at = if indexed { bytes.len() as u64 } else { 0 };
    if indexed {
        for (topic, id) in &connections {
            let record = records.iter().find(|record| record.topic == *topic).expect("it has a connection");
            bytes.extend(connection_record(*id, record));
        }
        infos.iter().for_each(|info| bytes.extend(info));
    }
    let counts = [connections.len(), infos.len()].map(|count| (if indexed { count as u32 } else { 0 }).to_le_bytes());
    let fields = [
        ("op", &[3][..]),
        ("index_pos", &index_at.to_le_bytes()),
        ("conn_count", &counts[0]),
        ("chunk_count", &counts[1]),
    ];
    let bare = bag_record(&fields, b"").len();
    let header = bag_record(&fields, &vec![b' '; BAG_HEADER_BYTES - bare]);
    bytes[header_at..header_at + BAG_HEADER_BYTES].copy_from_slice(&header);
    Built { bytes, ends }
}

fn connection_record(id: u32, record: &Record) -> Vec<u8> {
    let data = fields_of(&[("topic", record.topic.as_bytes()), ("type", record.type_name.as_bytes())]);
    bag_record(&[("op", &[7]), ("conn", &id.to_le_bytes()), ("topic", record.topic.as_bytes())], &data)
}

fn bag_record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = fields_of(fields);
    let [header_bytes, data_bytes] = [header.len(), data.len()].map(|length| (length as u32).to_le_bytes());
    [&header_bytes[..], &header, &data_bytes, data].concat()
}

fn fields_of(fields: &[(&str, &[u8])]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| {
        let entry = [name.as_bytes(), b"=", value].concat();
        [&(entry.len() as u32).to_le_bytes()[..], &entry].concat()
    };
    fields.iter().flat_map(field).collect()
}

fn time(ns: u64) -> [u8; 8] {
    let [seconds, rest] = [ns / 1_000_000_000, ns % 1_000_000_000].map(|part| (part as u32).to_le_bytes());
    let mut bytes = [0; 8];
    bytes[..4].copy_from_slice(&seconds);
    bytes[4..].copy_from_slice(&rest);
    bytes
}

fn compressed(data: &[u8], compression: &str) -> Vec<u8> {
    match compression {
        "bz2" => {
            let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            encoder.write_all(data).expect("in memory");
            encoder.finish().expect("in memory")
        }
        "lz4" => {
            let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).expect("in memory");
            encoder.write_all(data).expect("in memory");
            encoder.finish().0
        }
        _ => data.to_vec(),
    }
}

const PAGE_BYTES: usize = 512;

/// A rosbag2 database, as SQLite lays out a table to which rows are appended: pages 2 and 3 are the roots of the tables.
pub(crate) fn rosbag2(records: &[Record]) -> Built {
    let mut topics: Vec<&Record> = Vec::new();
    for record in records {
        if topics.iter().all(|known| known.topic != record.topic) {
            topics.push(record);
        }
    }
    let table = |name: &str, root: i64, columns: &str| {
        row(&[text("table"), text(name), text(name), integer(root), text(&format!("CREATE TABLE {name}({columns})"))])
    };
    let tables = [
        table(
            "topics",
            2,
            "id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,serialization_format TEXT NOT NULL",
        ),
        table(
            "messages",
            3,
            "id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL",
        ),
    ];
    let topic_rows: Vec<_> = topics
        .iter()
        .map(|record| row(&[(0, Vec::new()), text(record.topic), text(record.type_name), text(record.encoding)]))
        .collect();
    let mut file = Database { pages: vec![Vec::new(); 3], leaves: Vec::new(), ends: Vec::new() };
    file.pages[0] = leaf(&cells(&tables, 1), 100);
    file.pages[1] = leaf(&cells(&topic_rows, 1), 0);
    let mut waiting = Vec::new();
    for (record, id) in records.iter().zip(1..) {
        let topic = topics.iter().position(|known| known.topic == record.topic).expect("listed") as i64 + 1;
        let payload = row(&[(0, Vec::new()), integer(topic), integer(record.log_time_ns as i64), blob(&record.data)]);
        let cell = file.cell(&payload, id);
        let used: usize = waiting.iter().map(|cell: &Vec<u8>| cell.len() + 2).sum();
        if used + cell.len() + 2 > PAGE_BYTES - 8 {
            file.close_leaf(&mut waiting, id - 1);
        }
        waiting.push(cell);
    }
    file.close_leaf(&mut waiting, records.len() as i64);
    file.pages[2] = file.root();
    let count = file.pages.len() as u32;
    let mut bytes: Vec<u8> = file.pages.concat();
    bytes[..16].copy_from_slice(b"SQLite format 3\0");
    bytes[16..18].copy_from_slice(&(PAGE_BYTES as u16).to_be_bytes());
    bytes[28..32].copy_from_slice(&count.to_be_bytes());
    bytes[56..60].copy_from_slice(&1u32.to_be_bytes());
    Built { bytes, ends: file.ends }
}

struct Database {
    pages: Vec<Vec<u8>>,
    /// Leaves of the messages, each with its last row.
    leaves: Vec<(u32, i64)>,
    ends: Vec<usize>,
}

impl Database {
    /// The cell of a row; what does not fit goes onto pages of its own.
    fn cell(&mut self, payload: &[u8], id: i64) -> Vec<u8> {
        let (usable, length) = (PAGE_BYTES, payload.len());
        let most = usable - 35;
        let least = (usable - 12) * 32 / 255 - 23;
        let wanted = least + length.saturating_sub(least) % (usable - 4);
        let local = if length <= most {
            length
        } else if wanted <= most {
            wanted
        } else {
            least
        };
        let mut cell = [varint(length as u64), varint(id as u64), payload[..local].to_vec()].concat();
        if local < length {
            cell.extend((self.pages.len() as u32 + 1).to_be_bytes());
            let mut parts = payload[local..].chunks(usable - 4).peekable();
            while let Some(part) = parts.next() {
                let next = if parts.peek().is_some() { self.pages.len() as u32 + 2 } else { 0 };
                let mut page = [&next.to_be_bytes()[..], part].concat();
                page.resize(PAGE_BYTES, 0);
                self.pages.push(page);
            }
        }
        cell
    }

    /// The leaf page comes behind the pages onto which its rows continue, so its end is that of its messages.
    fn close_leaf(&mut self, waiting: &mut Vec<Vec<u8>>, last: i64) {
        if waiting.is_empty() {
            return;
        }
        self.pages.push(leaf(waiting, 0));
        self.leaves.push((self.pages.len() as u32, last));
        self.ends.extend(std::iter::repeat_n(self.pages.len() * PAGE_BYTES, waiting.len()));
        waiting.clear();
    }

    fn root(&self) -> Vec<u8> {
        let (last, others) = self.leaves.split_last().expect("a leaf");
        let cells: Vec<Vec<u8>> =
            others.iter().map(|(page, row)| [page.to_be_bytes().to_vec(), varint(*row as u64)].concat()).collect();
        page(5, &cells, 0, &last.0.to_be_bytes())
    }
}

fn cells(rows: &[Vec<u8>], first: u64) -> Vec<Vec<u8>> {
    rows.iter().zip(first..).map(|(row, id)| [varint(row.len() as u64), varint(id), row.clone()].concat()).collect()
}

fn leaf(cells: &[Vec<u8>], header_at: usize) -> Vec<u8> {
    page(0x0d, cells, header_at, b"")
}

/// A page of a tree: cells grow from its end, their places from its start.
fn page(kind: u8, cells: &[Vec<u8>], header_at: usize, right: &[u8]) -> Vec<u8> {
    let mut page = vec![0; PAGE_BYTES];
    page[header_at] = kind;
    page[header_at + 3..header_at + 5].copy_from_slice(&(cells.len() as u16).to_be_bytes());
    page[header_at + 8..header_at + 8 + right.len()].copy_from_slice(right);
    let places_at = header_at + 8 + right.len();
    let mut at = PAGE_BYTES;
    for (i, cell) in cells.iter().enumerate() {
        at -= cell.len();
        assert!(at >= places_at + 2 * cells.len(), "the cells of a page fit");
        page[at..at + cell.len()].copy_from_slice(cell);
        page[places_at + 2 * i..places_at + 2 * i + 2].copy_from_slice(&(at as u16).to_be_bytes());
    }
    page
}

fn row(columns: &[(u64, Vec<u8>)]) -> Vec<u8> {
    let kinds: Vec<u8> = columns.iter().flat_map(|(kind, _)| varint(*kind)).collect();
    let header = [varint(kinds.len() as u64 + 1), kinds].concat();
    header.into_iter().chain(columns.iter().flat_map(|(_, value)| value.clone())).collect()
}

fn text(value: &str) -> (u64, Vec<u8>) {
    (13 + 2 * value.len() as u64, value.as_bytes().to_vec())
}

fn blob(value: &[u8]) -> (u64, Vec<u8>) {
    (12 + 2 * value.len() as u64, value.to_vec())
}

fn integer(value: i64) -> (u64, Vec<u8>) {
    (6, value.to_be_bytes().to_vec())
}

fn varint(value: u64) -> Vec<u8> {
    let mut bytes = vec![(value & 0x7f) as u8];
    let mut left = value >> 7;
    while left > 0 {
        bytes.insert(0, (left & 0x7f) as u8 | 0x80);
        left >>= 7;
    }
    bytes
}
