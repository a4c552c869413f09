//! Any recording as a clean MCAP of ROS 2: scans or clouds, odometry and transforms in CDR, and the truth if there is one.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Seek, Write};
use std::path::PathBuf;

use crosscut_messages::{
    CDR_ENCODING, DecodeError, Echo, Endian, Fields, LaserScan, Message, ODOMETRY_TOPIC, Odometry, POINTS_TOPIC,
    PointCloud2, ROS1_ENCODING, SCAN_TOPIC, SCHEMA_ENCODING, ScanDecoder, ScanMessage, ScanType, TF_TOPIC,
    TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT, TRUTH_MAP_TOPIC, TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, TRUTH_TOPIC,
    TfMessage, ros,
};
use mcap::records::MessageHeader;

use crate::container::{self, ChannelId, Contents, TopicReader};
use crate::parts::OpenParts;
use crate::topics::{scan_topic, topics_of};
use crate::{IngestError, Loss, ReadOptions, TopicInfo};

/// Why a recording could not be converted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// There is nothing that can be read.
    #[error(transparent)]
    Ingest(#[from] IngestError),
    /// The MCAP cannot be written.
    #[error("the MCAP cannot be written")]
    Write(#[from] mcap::McapError),
    /// No scan lies in the part of the recording that is asked for.
    #[error("no scan of {topic} is selected by --from, --to and --every")]
    NothingSelected {
        /// The scan topic.
        topic: String,
    },
    /// Not one scan can be decoded.
    #[error("none of the {messages} messages of {topic} can be decoded")]
    NoScan {
        /// The scan topic.
        topic: String,
        /// How many messages it has.
        messages: u64,
    },
}

/// What was converted.
#[derive(Debug, Default)]
pub struct Converted {
    /// Messages written on each topic.
    pub messages: BTreeMap<String, u64>,
    /// Messages of these topics that could not be decoded, and are left out.
    pub undecodable: BTreeMap<String, u64>,
    /// What was lost of the recording.
    pub losses: Vec<Loss>,
    /// Recordings of other kinds in the folders that it was read from (see [`Parts`](crate::Parts)).
    pub left_out: Vec<PathBuf>,
}

/// What is done with a message.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scan(ScanDecoder),
    Odometry,
    Transforms,
    /// The bytes are copied.
    Truth,
    TruthMap,
}

/// A topic of the recording, and what becomes of it.
struct Route {
    kind: Kind,
    from: TopicInfo,
    to: String,
}

/// The part of a recording that is asked for.
struct Selection<'a> {
    options: &'a ReadOptions,
    /// When the first scan was recorded.
    first_ns: Option<u64>,
    /// Scans up to now, and those of them that are selected.
    scans: u64,
    selected: u64,
}

impl Selection<'_> {
    /// Whether a message is asked for. What holds of the whole recording is, and so is all beside the scans in that time.
    fn holds(&mut self, route: &Route, log_time_ns: u64) -> bool {
        let ReadOptions { from_s, to_s, every, .. } = self.options;
        let is_scan = matches!(route.kind, Kind::Scan(_));
        if is_scan {
            self.first_ns.get_or_insert(log_time_ns);
        }
        if route.kind == Kind::TruthMap || route.to.ends_with("_static") {
            return true;
        }
        let since_first_s = self.first_ns.map(|first_ns| (i128::from(log_time_ns) - i128::from(first_ns)) as f64 / 1e9);
        let is_after = |from_s: f64| since_first_s.is_some_and(|since_s| since_s >= from_s);
        let is_before = |to_s: f64| since_first_s.is_none_or(|since_s| since_s <= to_s);
        let is_in_time = from_s.is_none_or(is_after) && to_s.is_none_or(is_before);
        if !is_scan {
            return is_in_time;
        }
        let is_selected = is_in_time && self.scans.is_multiple_of(every.get());
        self.scans += 1;
        self.selected += u64::from(is_selected);
        is_selected
    }
}

/// Writes the recordings in `inputs` into `out` as one MCAP: the scans that `options` select on `/scan`, clouds on
/// `/points`, odometry on `/odom`, transforms on `/tf` and `/tf_static`. Values and times stay as they are; of several
/// echoes of a beam, `echo` is its range. `written` is called for each message.
///
/// # Errors
/// When there are no scans that can be read, or `out` cannot be written.
pub fn convert(
    inputs: &[PathBuf],
    options: &ReadOptions,
    echo: Echo,
    out: impl Write + Seek,
    mut written: impl FnMut(),
) -> Result<Converted, ConvertError> {
    let OpenParts { containers, losses, left_out } = OpenParts::open(inputs, &options.csv)?;
    let routes = routes(topics_of(containers.iter().map(|container| container.contents())), options, echo)?;
    let mut converted = Converted { losses, left_out, ..Converted::default() };
    let mut mcap = mcap::WriteOptions::new().profile("ros2").library("crosscut").create(out)?;
    let mut channels = BTreeMap::new();
    let mut selection = Selection { options, first_ns: None, scans: 0, selected: 0 };
    for container in containers {
        let routed = routed(container.contents(), &routes);
        let mut reader = TopicReader::new(container, routed.keys().copied().collect::<BTreeSet<_>>());
        while let Some(message) = reader.next() {
            let Some(route) = routed.get(&message.channel).filter(|route| selection.holds(route, message.log_time_ns))
            else {
                reader.container.recycle(message);
                continue;
            };
            match recoded(route, &message) {
                Ok(data) => {
                    let (channel, count) = match channels.get_mut(&route.to) {
                        Some(known) => known,
                        None => channels.entry(route.to.clone()).or_insert((add_channel(&mut mcap, route)?, 0)),
                    };
                    let (log_time, publish_time) = (message.log_time_ns, message.log_time_ns);
                    let header = MessageHeader { channel_id: *channel, sequence: *count, log_time, publish_time };
                    mcap.write_to_known_channel(&header, &data)?;
                    *count = count.wrapping_add(1);
                    *converted.messages.entry(route.to.clone()).or_default() += 1;
                    written();
                }
                Err(_) => *converted.undecodable.entry(route.to.clone()).or_default() += 1,
            }
            reader.container.recycle(message);
        }
        converted.losses.extend(reader.take_losses());
    }
    mcap.finish()?;
    let scans = routes.into_iter().find(|route| matches!(route.kind, Kind::Scan(_)));
    match scans.filter(|route| !converted.messages.contains_key(&route.to)) {
        Some(Route { from, .. }) if selection.scans > 0 && selection.selected == 0 => {
            Err(ConvertError::NothingSelected { topic: from.name })
        }
        Some(Route { from, to, .. }) => {
            let messages = converted.undecodable.get(&to).copied().unwrap_or(0);
            Err(ConvertError::NoScan { topic: from.name, messages })
        }
        None => Ok(converted),
    }
}

/// The topics that are converted: one of scans, one of odometry, and those of transforms and truth.
fn routes(topics: Vec<TopicInfo>, options: &ReadOptions, echo: Echo) -> Result<Vec<Route>, ConvertError> {
    let (scans, mut decoder) = scan_topic(topics.clone(), options.topic.as_deref(), options.read_as)?;
    decoder.echo = echo;
    let to = if decoder.gives_clouds() { POINTS_TOPIC } else { SCAN_TOPIC };
    let mut routes = vec![Route { kind: Kind::Scan(decoder), from: scans, to: to.to_owned() }];
    let odometry = topics.iter().find(|topic| topic.has_odometry());
    routes.extend(odometry.map(|topic| Route {
        kind: Kind::Odometry,
        from: topic.clone(),
        to: ODOMETRY_TOPIC.to_owned(),
    }));
    for topic in topics.iter().filter(|topic| topic.has_transforms()) {
        let is_static = topic.name.ends_with("_static");
        let to = if is_static { format!("{TF_TOPIC}_static") } else { TF_TOPIC.to_owned() };
        routes.push(Route { kind: Kind::Transforms, from: topic.clone(), to });
    }
    for (kind, name) in [(Kind::Truth, TRUTH_TOPIC), (Kind::TruthMap, TRUTH_MAP_TOPIC)] {
        let truth = topics.iter().find(|topic| topic.name == name);
        routes.extend(truth.map(|topic| Route { kind, from: topic.clone(), to: name.to_owned() }));
    }
    Ok(routes)
}

/// The message in CDR.
fn in_cdr<M: Message>(topic: &TopicInfo, data: &[u8]) -> Result<Vec<u8>, DecodeError> {
    Ok(ros::decode::<M>(&topic.encoding, data)?.encode(Endian::Little))
}

/// The route of each channel of a file that is converted.
fn routed<'a>(contents: &Contents, routes: &'a [Route]) -> BTreeMap<ChannelId, &'a Route> {
    let channels_of = |route: &'a Route| route.from.channels_in(contents).into_iter().map(move |id| (id, route));
    routes.iter().flat_map(channels_of).collect()
}

fn recoded(route: &Route, message: &container::Message) -> Result<Vec<u8>, DecodeError> {
    match route.kind {
        Kind::Scan(decoder) => {
            let mut scan = ScanMessage::default();
            decoder.decode_into(&message.data, &mut scan)?;
            match (scan, route.from.encoding.as_str()) {
                (ScanMessage::Scan(scan), _) => Ok(scan.encode(Endian::Little)),
                // Other fields of the points are kept.
                (ScanMessage::Cloud(cloud), _) if decoder.scan_type() != ScanType::PointCloud2 => {
                    Ok(PointCloud2::from(&cloud).encode(Endian::Little))
                }
                (_, ROS1_ENCODING) => Ok(PointCloud2::read(&mut Fields::ros1(&message.data))?.encode(Endian::Little)),
                (_, CDR_ENCODING) => Ok(PointCloud2::read(&mut Fields::cdr(&message.data)?)?.encode(Endian::Little)),
                (ScanMessage::Cloud(cloud), _) => Ok(PointCloud2::from(&cloud).encode(Endian::Little)),
            }
        }
        Kind::Odometry => in_cdr::<Odometry>(&route.from, &message.data),
        Kind::Transforms => in_cdr::<TfMessage>(&route.from, &message.data),
        Kind::Truth | Kind::TruthMap => Ok(message.data.clone()),
    }
}

fn add_channel<W: Write + Seek>(mcap: &mut mcap::Writer<W>, route: &Route) -> Result<u16, mcap::McapError> {
    let (type_name, text) = match route.kind {
        Kind::Scan(decoder) if decoder.gives_clouds() => (PointCloud2::SCHEMA_NAME, PointCloud2::SCHEMA_TEXT),
        Kind::Scan(_) => (LaserScan::SCHEMA_NAME, LaserScan::SCHEMA_TEXT),
        Kind::Odometry => (Odometry::SCHEMA_NAME, Odometry::SCHEMA_TEXT),
        Kind::Transforms => (TfMessage::SCHEMA_NAME, TfMessage::SCHEMA_TEXT),
        Kind::Truth => (TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT),
        Kind::TruthMap => (TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT),
    };
    let (schema_encoding, encoding) = match route.kind {
        Kind::Truth | Kind::TruthMap => (crosscut_messages::JSON_SCHEMA_ENCODING, crosscut_messages::JSON_ENCODING),
        _ => (SCHEMA_ENCODING, CDR_ENCODING),
    };
    let schema = mcap.add_schema(type_name, schema_encoding, text.as_bytes())?;
    mcap.add_channel(schema, &route.to, encoding, &BTreeMap::new())
}
