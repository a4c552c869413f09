//! The odometry that a recording holds beside its scans: `nav_msgs/Odometry`, or transforms from the frame `odom`.

use std::collections::VecDeque;

use crosscut_messages::ros::plain_frame;
use crosscut_messages::{DecodeError, ODOMETRY_TOPIC};
use crosscut_sensor::{Odometry, StatedPose, VehiclePose, pose_in};

use crate::container::{self, Container, Contents, Message, TopicReader, Wait};
use crate::topics::topics_of;
use crate::{CsvGeometry, LossKind, TopicInfo};

/// Odometry recorded this long after a scan is not read for it: its stamps are of another clock.
const AHEAD_NS: u64 = 2_000_000_000;

/// This many poses are read ahead at most, where the times of recording are of no use.
const MOST_AHEAD: usize = 100_000;

/// A stamp that comes so often in a row stands still.
const STANDING: u32 = 3;

/// Gives the pose of the vehicle at the time of each scan.
pub(crate) struct OdometryReader {
    topic: TopicInfo,
    csv: CsvGeometry,
    /// Files that are not opened yet.
    files: VecDeque<Contents>,
    reader: Option<TopicReader>,
    poses: Odometry,
    /// The frame that they are of, by the last message.
    frame_id: String,
    /// How many messages cannot be read, and why the first cannot.
    unreadable: Option<(u64, DecodeError)>,
    any_read: bool,
    last_stamp_ns: Option<u64>,
    /// How often that came in a row.
    same_stamps: u32,
}

impl OdometryReader {
    /// Of the topic `wanted`, else of `/odom`, else of the first topic of odometry, else of the transforms on `/tf`; `None`
    /// if there is none. The files are opened a second time.
    pub(crate) fn new(containers: &[Box<dyn Container>], csv: &CsvGeometry, wanted: &str) -> Option<Self> {
        let contents = || containers.iter().map(|container| container.contents());
        let topics = topics_of(contents());
        let is_dynamic = |topic: &&TopicInfo| topic.has_transforms() && !topic.name.ends_with("_static");
        let candidates = topics.iter().filter(|topic| topic.has_odometry()).chain(topics.iter().filter(is_dynamic));
        let candidates = candidates.filter(|topic| topic.messages != Some(0));
        let is_wanted = |topic: &&TopicInfo| wanted.is_empty() || topic.name == wanted;
        let rank = |topic: &&TopicInfo| (!topic.has_odometry(), topic.name != ODOMETRY_TOPIC);
        let topic = candidates.filter(is_wanted).min_by_key(rank)?.clone();
        // A stream is one, and cannot be opened again.
        let stream = containers.iter().find_map(|container| container.again());
        let reader = stream.map(|stream| {
            let channels = topic.channels_in(stream.contents());
            TopicReader::new(stream, channels)
        });
        let has_topic = |contents: &&Contents| reader.is_none() && !topic.channels_in(contents).is_empty();
        let files = contents().filter(has_topic).cloned().collect();
        Some(Self {
            topic,
            csv: csv.clone(),
            files,
            reader,
            poses: Odometry::default(),
            frame_id: String::new(),
            unreadable: None,
            any_read: false,
            last_stamp_ns: None,
            same_stamps: 0,
        })
    }

    /// The poses at the first and last of `stamps_ns`, which are times of a scan that was recorded at `recorded_ns`. Scans are
    /// asked for in order.
    pub(crate) fn at(&mut self, stamps_ns: [u64; 2], recorded_ns: u64) -> Option<[VehiclePose; 2]> {
        let [first_ns, last_ns] = stamps_ns;
        self.poses.forget_before(first_ns);
        if let Some(reader) = &mut self.reader {
            reader.container.wait(Wait::Recorded(recorded_ns.saturating_add(AHEAD_NS)));
        }
        while self.poses.last_ns().is_none_or(|read_ns| read_ns < last_ns) && self.poses.len() < MOST_AHEAD {
            let Some(message) = self.next_message() else { break };
            let log_time_ns = message.log_time_ns;
            match pose_in(self.topic.has_odometry(), &self.topic.encoding, &message.data) {
                Ok(Some(StatedPose { stamp_ns: pose_ns, frame_id, pose })) => {
                    self.any_read = true;
                    self.frame_id = frame_id;
                    // A stamp that is missing, or stands still, is replaced as that of a scan.
                    let is_same = self.last_stamp_ns.replace(pose_ns) == Some(pose_ns);
                    self.same_stamps = if is_same { self.same_stamps + 1 } else { 0 };
                    let stands = self.same_stamps >= STANDING;
                    self.poses.push(if pose_ns == 0 || stands { log_time_ns } else { pose_ns }, pose);
                }
                Ok(None) => {}
                Err(cause) => self.unreadable.get_or_insert((0, cause)).0 += 1,
            }
            if let Some(reader) = &mut self.reader {
                reader.container.recycle(message);
            }
            if log_time_ns > recorded_ns.saturating_add(AHEAD_NS) {
                break;
            }
        }
        Some([self.poses.at(first_ns)?, self.poses.at(last_ns)?])
    }

    /// Whether the poses that were read last are those of this frame.
    pub(crate) fn is_of(&self, frame_id: &str) -> bool {
        !self.frame_id.is_empty() && self.frame_id == plain_frame(frame_id)
    }

    /// What could not be read of it, once it is read: how many messages of which topic, and why the first.
    pub(crate) fn unreadable(&mut self) -> Option<LossKind> {
        let (count, cause) = self.unreadable.take()?;
        Some(LossKind::Messages { topic: self.topic.name.clone(), first_seq: 0, count, cause })
    }

    /// That none of those that were read can be used, if that is so.
    pub(crate) fn unusable(&mut self) -> Option<LossKind> {
        let (_, cause) = self.unreadable.take_if(|_| !self.any_read)?;
        Some(LossKind::NoneUsable { topic: self.topic.name.clone(), cause })
    }

    /// The next message, from whichever file is at hand. A file that can no longer be opened has none.
    fn next_message(&mut self) -> Option<Message> {
        loop {
            if let Some(message) = self.reader.as_mut().and_then(TopicReader::next) {
                return Some(message);
            }
            let contents = self.files.pop_front()?;
            let channels = self.topic.channels_in(&contents);
            self.reader =
                container::reopen_file(&contents, &self.csv).ok().map(|file| TopicReader::new(file, channels));
        }
    }
}
