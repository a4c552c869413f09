//! Why there is nothing to read.

use std::path::{Path, PathBuf};

use crosscut_stage::counted;

use crate::{Found, Loss, LossKind, TopicInfo, TopicList};

/// Why no revolution can be had: what was found instead, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IngestError {
    /// No file was named.
    #[error("no recording was given")]
    NoInput,
    /// Nothing has this name.
    #[error("there is no file or folder {}", path.display())]
    Missing {
        /// What was named.
        path: PathBuf,
    },
    /// A file or folder cannot be opened.
    #[error("cannot open {}", path.display())]
    Open {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A pipe, a device, or a folder where one file is asked for.
    #[error("not a file but a folder, a pipe or a device; give the file that it comes from or is saved to: {}", path.display())]
    NotAFile {
        /// What was named.
        path: PathBuf,
    },
    /// A file of a format that is read only once it is complete.
    #[error("only an MCAP can be followed while it is written: {}", path.display())]
    CannotFollow {
        /// The file.
        path: PathBuf,
    },
    /// A folder without recordings.
    #[error("{}: {}", without_recordings(*files, *folders), path.display())]
    NoRecordings {
        /// The folder.
        path: PathBuf,
        /// How many files it has.
        files: usize,
        /// How many folders.
        folders: usize,
    },
    /// A file of another kind.
    #[error("cannot be read as a recording: {found}: {}", path.display())]
    NotRecording {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: Found,
    },
    /// A table of ranges, without the settings that say where its beams look.
    #[error(
        "this table of ranges ({columns}) does not state the directions of its beams: give the bearings of the first and \
         the last one, for example --set csv.first_rad=-2.356 --set csv.last_rad=2.356: {}", path.display()
    )]
    NoGeometry {
        /// The file.
        path: PathBuf,
        /// What its columns were taken for.
        columns: String,
    },
    /// No topic at all.
    #[error("{}{}", if losses.is_empty() { "the recording has no messages" } else { "no message can be read" }, because(losses))]
    NothingReadable {
        /// Why.
        losses: Vec<Loss>,
    },
    /// Topics, but none with scans that can be read.
    #[error("no topic carries scans that can be read (LaserScan, MultiEchoLaserScan or PointCloud2 of ROS, LaserScan or PointCloud of Foxglove); the recording has\n{topics}{}", hint(&topics.0))]
    NoScanTopic {
        /// All topics.
        topics: TopicList,
    },
    /// More than one topic with scans.
    #[error("there are several scan topics; name one with --topic, or each of a vehicle's scanners:\n{topics}")]
    SeveralScanTopics {
        /// The topics with scans.
        topics: TopicList,
    },
    /// The topic that was asked for is not there.
    #[error("there is no topic {wanted}; the recording has\n{topics}")]
    NoSuchTopic {
        /// The topic.
        wanted: String,
        /// All topics, the nearest name first.
        topics: TopicList,
    },
    /// The topic that was asked for has no scans.
    #[error("{wanted} does not carry scans that can be read (LaserScan, MultiEchoLaserScan or PointCloud2 of ROS, LaserScan or PointCloud of Foxglove); the recording has\n{topics}{}", hint(&topics.0[..1]))]
    NotAScanTopic {
        /// The topic.
        wanted: String,
        /// All topics, that one first.
        topics: TopicList,
    },
    /// No truth to hold results against.
    #[error(
        "there is no truth in it: nothing in JSON on /truth, as `crosscut simulate` writes it (`crosscut compare` needs none): {}",
        path.display()
    )]
    NoTruth {
        /// The file.
        path: PathBuf,
    },
    /// A live robot can no longer be heard.
    #[error("{cause}: {}", path.display())]
    NotHeard {
        /// Its address.
        path: PathBuf,
        /// Why.
        cause: String,
    },
    /// The scan topic has no messages.
    #[error("{topic} has no messages{}", because(losses))]
    NoScans {
        /// The topic.
        topic: String,
        /// What was lost, which may be why.
        losses: Vec<Loss>,
    },
}

impl IngestError {
    /// A file or folder that cannot be opened, or is not there.
    pub(crate) fn cannot_open(path: &Path, source: std::io::Error) -> Self {
        let path = path.to_owned();
        match source.kind() {
            std::io::ErrorKind::NotFound => Self::Missing { path },
            _ => Self::Open { path, source },
        }
    }

    /// Whether a recording that is still being written may have been looked at before its first scan.
    pub(crate) fn may_be_too_early(&self) -> bool {
        match self {
            Self::NotRecording { found, .. } => matches!(found, Found::Empty | Found::CutMcap),
            Self::NothingReadable { .. }
            | Self::NoScans { .. }
            | Self::NoScanTopic { .. }
            | Self::NoSuchTopic { .. } => true,
            _ => false,
        }
    }

    /// As a loss, if the run can go on without this file when others can be read: a crash may have left it behind, or it
    /// was not named itself (`is_named`) but lies in a folder that was.
    pub fn as_loss(&self, is_named: bool) -> Option<Loss> {
        match self {
            Self::NotRecording { path, found } if found.may_be_a_wreck() || !is_named => {
                let kind = LossKind::File { cause: format!("cannot be read as a recording: {found}") };
                Some(Loss { file: path.clone(), kind })
            }
            Self::NothingReadable { losses } => losses.first().filter(|_| losses.len() == 1).cloned(),
            _ => None,
        }
    }
}

fn without_recordings(files: usize, folders: usize) -> String {
    match (files, folders) {
        (0, 0) => "the folder is empty".to_owned(),
        (0, _) => format!("no file in this folder, but {}; name that of the flight", counted(folders as u64, "folder")),
        _ => format!(
            "none of the {files} files in this folder is a recording of a robot (.mcap, .db3, .bag, .clf, .pcd, .ply); a table or \
             a recording of crosscut (.rrd) is given by its name"
        ),
    }
}

fn because(losses: &[Loss]) -> String {
    losses.iter().map(|loss| format!("; {loss}")).collect()
}

fn hint(topics: &[TopicInfo]) -> &'static str {
    let ends = |topic: &TopicInfo, names: &[&str]| names.iter().any(|name| topic.type_name.ends_with(name));
    if topics.iter().any(|topic| ends(topic, &["LaserScan", "LaserScan_", "PointCloud2", "PointCloud2_", "PointCloud"]))
    {
        "\nscans are read in cdr (ROS 2), ros1, and those of Foxglove in json and protobuf; if a type only has another name, \
         --topic TOPIC --as LaserScan reads it (or --as PointCloud2)"
    } else if topics.iter().any(|topic| topic.type_name.is_empty()) {
        "\na topic without a schema may carry scans: --topic TOPIC --as LaserScan reads it (or --as PointCloud2)"
    } else {
        ""
    }
}
