//! How the frames of a recording lie to each other, at any time.

use std::collections::BTreeMap;

use crosscut_messages::ros::{self, plain_frame};
use crosscut_messages::{TfMessage, TransformStamped};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::container::{ChannelId, Container, TopicReader, Wait};

/// A transform that moves holds for this long before the first and after the last time that it was sent.
const LONGEST_NS: u64 = 1_000_000_000;
/// A tree of frames is not deeper.
const DEEPEST: usize = 100;

/// Of a stream, this many poses of a frame are kept.
const MOST_POSES: usize = 20_000;

/// All transforms of a recording; of a stream, those that came so far.
#[derive(Default)]
pub(super) struct Frames {
    /// By child frame.
    edges: BTreeMap<String, Edge>,
    /// What a stream's are read from, with their encodings.
    stream: Vec<(TopicReader, Channels)>,
}

/// Of each channel of transforms its encoding, and whether they do not move.
type Channels = BTreeMap<ChannelId, (String, bool)>;

/// Poses of a frame in its parent.
#[derive(Debug)]
struct Edge {
    parent: String,
    /// By stamp; one if it does not move, and none if no rotation was stated.
    poses: Vec<(u64, Isometry3<f64>)>,
}

/// Whether the transforms of a topic do not move.
fn is_static(topic: &str) -> bool {
    topic.ends_with("_static")
}

impl Frames {
    /// Reads the transforms in these files; of a stream, those that are there.
    pub(super) fn read(containers: Vec<Box<dyn Container>>, is_stream: bool) -> Self {
        Self::read_topics(containers, is_stream, |_| true)
    }

    /// Reads those that do not move.
    pub(super) fn read_static(containers: Vec<Box<dyn Container>>, is_stream: bool) -> Self {
        Self::read_topics(containers, is_stream, is_static)
    }

    fn read_topics(containers: Vec<Box<dyn Container>>, is_stream: bool, is_read: impl Fn(&str) -> bool) -> Self {
        let mut frames = Self::default();
        for container in containers {
            let channels = container.contents().channels.iter();
            let transforms: Channels = channels
                .filter(|(_, topic)| is_read(&topic.name) && ros::is_transforms(&topic.type_name, &topic.encoding))
                .map(|(&id, topic)| (id, (topic.encoding.clone(), is_static(&topic.name))))
                .collect();
            if transforms.is_empty() {
                continue;
            }
            let mut reader = TopicReader::new(container, transforms.keys().copied().collect());
            if is_stream {
                reader.container.wait(Wait::Never);
                frames.stream.push((reader, transforms));
            } else {
                frames.read_all(&mut reader, &transforms);
            }
        }
        frames.read_on();
        frames.sort();
        frames
    }

    /// Reads those that a stream has had since the last call.
    pub(super) fn read_on(&mut self) {
        let mut stream = std::mem::take(&mut self.stream);
        let count = |frames: &Self| frames.edges.values().map(|edge| edge.poses.len()).sum::<usize>();
        let before = count(self);
        stream.iter_mut().for_each(|(reader, transforms)| self.read_all(reader, transforms));
        if count(self) > before {
            self.sort();
        }
        for edge in self.edges.values_mut().filter(|edge| !stream.is_empty() && edge.poses.len() > MOST_POSES) {
            edge.poses.drain(..MOST_POSES / 2);
        }
        self.stream = stream;
    }

    fn read_all(&mut self, reader: &mut TopicReader, transforms: &Channels) {
        while let Some(message) = reader.next() {
            if let Some((encoding, is_static)) = transforms.get(&message.channel)
                && let Ok(sent) = ros::decode::<TfMessage>(encoding, &message.data)
            {
                sent.transforms.iter().for_each(|transform| self.add(transform, *is_static));
            }
            reader.container.recycle(message);
        }
    }

    fn sort(&mut self) {
        self.edges.values_mut().for_each(|edge| edge.poses.sort_by_key(|(stamp_ns, _)| *stamp_ns));
    }

    /// Adds a transform. Of those that do not move, the last one counts.
    pub(super) fn add(
        &mut self,
        TransformStamped { header, child_frame_id, transform }: &TransformStamped,
        is_static: bool,
    ) {
        let (place_m, turn) = (transform.translation, transform.rotation);
        let parent = plain_frame(&header.frame_id);
        let edge = self.edges.entry(plain_frame(child_frame_id).to_owned());
        let edge = edge.or_insert_with(|| Edge { parent: parent.to_owned(), poses: Vec::new() });
        let Some(rotation) = UnitQuaternion::try_new(Quaternion::new(turn.w, turn.x, turn.y, turn.z), 1e-9) else {
            return;
        };
        let pose = Isometry3::from_parts(Translation3::new(place_m.x, place_m.y, place_m.z), rotation);
        if is_static {
            *edge = Edge { parent: parent.to_owned(), poses: Vec::new() };
        }
        // Fixed transforms are sent again and again, on topics of any name.
        let is_known = edge.poses.len() == 1 && edge.poses[0].1 == pose;
        if edge.parent == parent && !is_known {
            edge.poses.push((header.stamp.to_ns().unwrap_or(0), pose));
        }
    }

    /// The frame and those that it lies in, each the parent of the one before.
    pub(super) fn line<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let parent = |frame: &&'a str| self.edges.get(*frame).map(|edge| edge.parent.as_str());
        std::iter::successors(Some(plain_frame(frame)), parent).take(DEEPEST).collect()
    }

    /// The nearest frame in which all of these lie.
    pub(super) fn common(&self, frames: &[&str]) -> Option<String> {
        let (first, others) = frames.split_first()?;
        let lines: Vec<_> = others.iter().map(|frame| self.line(frame)).collect();
        let is_common = |frame: &&str| lines.iter().all(|line| line.contains(frame));
        self.line(first).into_iter().find(is_common).map(str::to_owned)
    }

    /// The pose of `frame` in `parent`, in which it lies, at a time.
    pub(super) fn pose(&self, frame: &str, parent: &str, stamp_ns: u64) -> Option<Isometry3<f64>> {
        let mut pose = Isometry3::identity();
        for frame in self.line(frame) {
            if frame == parent {
                return Some(pose);
            }
            pose = self.edges.get(frame)?.at(stamp_ns)? * pose;
        }
        None
    }
}

impl Edge {
    fn at(&self, stamp_ns: u64) -> Option<Isometry3<f64>> {
        let after = self.poses.partition_point(|(at_ns, _)| *at_ns <= stamp_ns);
        let near = |(at_ns, pose): &(u64, _)| (at_ns.abs_diff(stamp_ns) <= LONGEST_NS).then_some(*pose);
        match (&self.poses[..after], &self.poses[after..]) {
            ([(_, only)], []) | ([], [(_, only)]) => Some(*only),
            ([.., (from_ns, from)], [(to_ns, to), ..]) => {
                let share = (stamp_ns - from_ns) as f64 / (to_ns - from_ns) as f64;
                // Of quaternions of either sign, the shorter turn.
                from.try_lerp_slerp(to, share, 1e-9)
            }
            ([], [first, ..]) => near(first),
            ([.., last], []) => near(last),
            ([], []) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use crosscut_messages::{Header, Quaternion, Time, Transform, Vector3};
    use crosscut_stage::Point;

    use super::*;

    fn frames(edges: &[(&str, &str, u64, [f64; 2], f64)]) -> Frames {
        let mut frames = Frames::default();
        for &(parent, child, stamp_ns, [x, y], yaw_rad) in edges {
            let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: parent.to_owned() };
            let rotation = Quaternion::from_yaw_rad(yaw_rad);
            let transform = Transform { translation: Vector3 { x, y, z: 0.0 }, rotation };
            frames.add(&TransformStamped { header, child_frame_id: child.to_owned(), transform }, false);
        }
        frames
    }

    #[test]
    fn the_common_frame_is_the_nearest_in_which_all_lie() {
        let tree = frames(&[
            ("odom", "base", 5, [9.0, 9.0], 1.0),
            ("base", "/front", 0, [1.0, 0.0], 0.0),
            ("base", "mast", 0, [-1.0, 0.0], FRAC_PI_2),
            ("mast", "rear", 0, [0.0, 1.0], FRAC_PI_2),
        ]);
        assert_eq!(tree.common(&["front", "/rear"]).as_deref(), Some("base"));
        assert_eq!(tree.common(&["rear", "mast"]).as_deref(), Some("mast"));
        assert_eq!(tree.common(&["front", "other"]), None);
        let seen = tree.pose("rear", "base", 7).expect("known") * Point::new(2.0, 0.0, 0.0);
        assert!((seen - Point::new(-4.0, 0.0, 0.0)).norm() < 1e-12, "{seen}");
        assert_eq!(tree.pose("base", "rear", 7), None, "it does not lie in it");
    }

    #[test]
    fn a_moving_frame_is_between_the_poses_around_a_time() {
        let second = 1_000_000_000;
        let tree =
            frames(&[("base", "mast", second, [0.0, 0.0], 0.0), ("base", "mast", 2 * second, [2.0, 0.0], FRAC_PI_2)]);
        let pose = tree.pose("mast", "base", second * 3 / 2).expect("known");
        assert!((pose.translation.x - 1.0).abs() < 1e-12 && (pose.rotation.angle() - FRAC_PI_2 / 2.0).abs() < 1e-9);
        assert!(tree.pose("mast", "base", 3 * second).is_some());
        assert_eq!(tree.pose("mast", "base", 3 * second + 1), None, "not known so long after");
    }

    #[test]
    fn frames_in_a_circle_end() {
        let tree = frames(&[("a", "b", 0, [0.0; 2], 0.0), ("b", "a", 0, [0.0; 2], 0.0)]);
        assert_eq!(tree.common(&["a", "c"]), None);
    }
}
