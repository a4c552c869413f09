//! Files that hold one point cloud: PCD and PLY. Such a file is one message, a PointCloud2. Its stamp is in the name of the
//! file, as `pointcloud_to_pcd` of ROS and others write it, or nowhere.
//!
//! The crates for PCD and PLY reserve memory on the word of the header and end at the first damage; of LZF, which PCD is
//! compressed with, the only pure Rust crate is no longer kept.

mod layout;
mod pcd;
mod ply;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read as _, Seek as _};
use std::mem;
use std::path::Path;

use crosscut_messages::{Endian, POINTS_TOPIC, PointCloud2, Time};
use crosscut_stage::counted;

use super::resting_file::RestingFile;
use super::{ChannelId, Container, Contents, Message, Topic};
use crate::{Damage, Loss, LossKind, limits};

/// The only channel.
const POINTS: ChannelId = 0;

/// What the bytes of a file hold.
struct Parsed<'a> {
    cloud: PointCloud2<'a>,
    /// `ascii`, `binary`...
    encoding: String,
    losses: Vec<LossKind>,
}

/// A format of files with one cloud.
#[derive(Clone, Copy)]
pub(super) enum Format {
    Pcd,
    Ply,
}

/// A file with one cloud.
pub(super) struct SingleCloud {
    file: RestingFile,
    format: Format,
    contents: Contents,
    /// By the name of the file; 0 if it has none.
    stamp_ns: u64,
    is_due: bool,
    losses: Vec<Loss>,
}

impl SingleCloud {
    /// Looks through `file`; `path` names it in losses.
    ///
    /// # Errors
    /// When no point can be found.
    pub(super) fn open(path: &Path, mut file: RestingFile, format: Format) -> Result<Self, Damage> {
        let name = match format {
            Format::Pcd => "PCD",
            Format::Ply => "PLY",
        };
        let length = file.length()?;
        let mut contents = Contents { path: path.to_owned(), bytes: length, format: name, ..Contents::default() };
        let bytes = bytes_of(&mut file)?;
        let Parsed { cloud, encoding, losses } = format.parse(&bytes)?;
        contents.properties = vec![("encoding", encoding), ("points", counted(u64::from(cloud.width), "point"))];
        contents.losses = losses.into_iter().map(|kind| Loss { file: path.to_owned(), kind }).collect();
        contents.channels.insert(POINTS, Topic::in_cdr(POINTS_TOPIC, PointCloud2::SCHEMA_NAME));
        contents.counts = Some(BTreeMap::from([(POINTS, 1)]));
        let stamp_ns = path.file_stem().and_then(|name| stamp_in(&name.to_string_lossy())).unwrap_or(0);
        if stamp_ns > 0 {
            contents.properties.push(("stamp", "by the name of the file".to_owned()));
        }
        contents.log_times_ns.add(stamp_ns);
        file.rest()?;
        Ok(Self { stamp_ns, file, format, contents, is_due: false, losses: Vec::new() })
    }

    fn read(&mut self) -> Result<Vec<u8>, Damage> {
        let bytes = bytes_of(&mut self.file)?;
        self.file.rest()?;
        let Parsed { mut cloud, .. } = self.format.parse(&bytes)?;
        cloud.header.stamp = Time::from_ns(self.stamp_ns);
        Ok(cloud.encode(Endian::Little))
    }
}

impl Format {
    fn parse(self, bytes: &[u8]) -> Result<Parsed<'_>, Damage> {
        match self {
            Self::Pcd => pcd::parse(bytes),
            Self::Ply => ply::parse(bytes),
        }
    }
}

/// The time since the epoch in the name of a file: seconds with a fraction or `_` and nanoseconds, or a whole number of
/// seconds, milliseconds, microseconds or nanoseconds of this century.
fn stamp_in(name: &str) -> Option<u64> {
    let mut runs =
        name.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty()).skip_while(|run| run.len() < 10);
    let whole = runs.next()?;
    let number: u64 = whole.parse().ok()?;
    let rest = runs.next().filter(|rest| rest.len() <= 9);
    let is_fraction = rest.is_some_and(|rest| name.contains(&format!("{whole}.{rest}")) || rest.len() == 9);
    match (whole.len(), rest) {
        (10, Some(rest)) if is_fraction => {
            number.checked_mul(1_000_000_000)?.checked_add(format!("{rest:0<9}").parse().ok()?)
        }
        (10, _) => number.checked_mul(1_000_000_000),
        (13, _) => number.checked_mul(1_000_000),
        (16, _) => number.checked_mul(1_000),
        (19, _) => Some(number),
        _ => None,
    }
}

/// All bytes of a file that is no larger than a message may be.
fn bytes_of(file: &mut RestingFile) -> Result<Vec<u8>, Damage> {
    let (bytes, limit) = (file.length()?, limits::MESSAGE_BYTES);
    if bytes > limit {
        return Err(Damage::TooLarge { bytes, limit });
    }
    let mut read = Vec::new();
    file.rewind()?;
    file.take(limit).read_to_end(&mut read)?;
    Ok(read)
}

impl Container for SingleCloud {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn contents_mut(&mut self) -> &mut Contents {
        &mut self.contents
    }

    fn select(&mut self, channels: &BTreeSet<ChannelId>) {
        self.is_due = channels.contains(&POINTS);
    }

    fn next(&mut self) -> Option<Message> {
        if !mem::take(&mut self.is_due) {
            return None;
        }
        match self.read() {
            Ok(data) => Some(Message { channel: POINTS, log_time_ns: self.stamp_ns, data, damage: None }),
            // The file was whole when it was looked through: since then it has changed, or it has gone.
            Err(damage) => {
                let kind = LossKind::Rest { at_byte: 0, damage };
                self.losses.push(Loss { file: self.contents.path.clone(), kind });
                None
            }
        }
    }

    fn is_by_log_time(&self) -> bool {
        true
    }

    fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_state_stamps_in_any_unit() {
        let ns = 1_700_000_000_500_000_000;
        for name in
            ["1700000000.5", "1700000000500", "1700000000500000", "cloud_1700000000500000000", "f_1700000000_500000000"]
        {
            assert_eq!(stamp_in(name), Some(ns), "{name}");
        }
        for name in ["cloud_0001", "20231114_221320", "20231114221320", "scan-7.5"] {
            assert_eq!(stamp_in(name), None, "{name}");
        }
    }
}
