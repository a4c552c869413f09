//! `rerun-importer-crosscut`, called as the Rerun viewer calls it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use crosscut_messages::{PointCloud2, SCHEMA_ENCODING};
use tempfile::TempDir;

use crate::flight::file;
use crate::program::{run, shipped_flight};

/// The exit code that tells the viewer to ask other importers.
const INCOMPATIBLE: i32 = 66;

/// The viewer's call for a file: of the program, by the name of a link.
fn importer(path: &Path) -> Command {
    static LINK: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, link) = LINK.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let link = folder.path().join(format!("rerun-importer-crosscut{}", std::env::consts::EXE_SUFFIX));
        #[cfg(unix)]
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_crosscut"), &link).expect("a link");
        #[cfg(not(unix))]
        std::fs::copy(env!("CARGO_BIN_EXE_crosscut"), &link).expect("a copy");
        (folder, link)
    });
    let mut command = Command::new(link);
    command.arg(path).args(["--application-id", "viewer", "--recording-id", "one", "--a-later-option", "5"]);
    command
}

fn import(path: &Path) -> Output {
    importer(path).output().expect("the importer starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn an_imported_flight_is_the_recording_that_run_saves() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = folder.path().join("tee.rrd").display().to_string();
    run(["run", &shipped_flight().display().to_string(), "--quiet", "--save", &saved]).expect_code(0);
    let imported = import(&shipped_flight());
    assert_eq!(imported.status.code(), Some(0), "{}", said(&imported));
    let written = file(folder.path(), "imported.rrd", &imported.stdout).display().to_string();
    run(["rrd", "diff", &saved, &written]).expect_code(0);
    for id in [&b"viewer"[..], b"one"] {
        let holds = imported.stdout.windows(id.len()).any(|bytes| bytes == id);
        assert!(holds, "the recording is part of the viewer's: {}", String::from_utf8_lossy(id));
    }
}

#[test]
fn logs_of_carmen_are_imported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let line = |i: u32| format!("FLASER 180 {}0 0 0 0 0 0 {i}.0 host {i}.0\n", "3.00 ".repeat(180));
    let flight = file(folder.path(), "hall.clf", (0..5).map(line).collect::<String>().as_bytes());
    let imported = import(&flight);
    assert_eq!(imported.status.code(), Some(0), "{}", said(&imported));
    assert!(imported.stdout.starts_with(b"RRF"));
}

#[test]
fn files_of_others_are_left_to_them_in_silence() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let of_others = [
        file(folder.path(), "empty.mcap", b""),
        file(folder.path(), "clouds.mcap", &clouds()),
        file(folder.path(), "build.log", b"Compiling crosscut\n"),
        file(folder.path(), "ranges.csv", b"1,2,3,4\n"),
        file(folder.path(), "picture.png", b"\x89PNG\r\n\x1a\n"),
        file(folder.path(), "flight.rrd", b"RRF2"),
        folder.path().to_owned(),
        folder.path().join("nothing.bag"),
    ];
    for path in of_others {
        let output = import(&path);
        assert_eq!(output.status.code(), Some(INCOMPATIBLE), "{}: {}", path.display(), said(&output));
        assert_eq!((output.stdout.len(), said(&output)), (0, String::new()), "{}", path.display());
    }
}

#[test]
fn a_bag_that_cannot_be_read_says_why() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = import(&file(folder.path(), "old.bag", b"#ROSBAG V1.1\n"));
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("rosbag fix"), "{}", said(&output));
}

#[test]
fn the_flight_ends_when_the_viewer_stops_reading() {
    let mut process =
        importer(&shipped_flight()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("started");
    drop(process.stdout.take());
    let output = process.wait_with_output().expect("it ends");
    assert!(said(&output).contains("interrupted after"), "{:?}: {}", output.status.code(), said(&output));
}

/// An MCAP with one cloud, which the viewer shows without us.
fn clouds() -> Vec<u8> {
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).expect("memory");
    let text = PointCloud2::SCHEMA_TEXT.as_bytes();
    let schema = writer.add_schema(PointCloud2::SCHEMA_NAME, SCHEMA_ENCODING, text).expect("memory");
    let channel_id = writer.add_channel(schema, "/points", "cdr", &Default::default()).expect("memory");
    let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
    let cloud = PointCloud2::default().encode(crosscut_messages::Endian::Little);
    writer.write_to_known_channel(&header, &cloud).expect("memory");
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}
