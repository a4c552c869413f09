//! Files that hold several recordings, and recordings without a timeline.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use crosscut_rrd::{ReadError, Recording, differences};
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{DecoderApp, Encoder, EncodingOptions};
use rerun::log::{Chunk, LogMsg};

use crate::frames;
use crate::reading::record;

fn messages(path: &Path) -> Vec<LogMsg> {
    let file = BufReader::new(File::open(path).expect("readable"));
    DecoderApp::decode_eager(file).expect("an .rrd").map(|message| message.expect("a message")).collect()
}

fn write(path: &Path, messages: impl IntoIterator<Item = LogMsg>) {
    let file = File::create(path).expect("writable");
    let mut encoder =
        Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, file).expect("open");
    for message in messages {
        encoder.append(&message).expect("written");
    }
    encoder.finish().expect("written");
}

/// Flights of 3 and of 5 revolutions, and both merged into one file.
fn flights(folder: &Path) -> [PathBuf; 3] {
    let [a, b, merged] = ["a.rrd", "b.rrd", "merged.rrd"].map(|name| folder.join(name));
    record(&a, &(0..3).map(frames::frame).collect::<Vec<_>>());
    record(&b, &(0..5).map(frames::frame).collect::<Vec<_>>());
    write(&merged, messages(&a).into_iter().chain(messages(&b)));
    [a, b, merged]
}

#[test]
fn a_file_with_several_recordings_names_them_and_gives_each_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, merged] = flights(folder.path());
    let Err(ReadError::Several { ids, .. }) = Recording::open(&merged) else { panic!("they are mixed") };
    assert_eq!(ids.len(), 2);
    for (id, alone) in ids.iter().zip([a, b]) {
        let (chosen, alone) = (Recording::open_one(&merged, id).unwrap(), Recording::open(&alone).unwrap());
        assert_eq!(chosen.damages(), []);
        assert_eq!(chosen.entities()["/scan/ranges"].rows, alone.entities()["/scan/ranges"].rows);
        let found = differences(&chosen, &alone, 0.0).unwrap();
        assert!(found.components.is_empty() && found.compared > 60, "{found:?}");
    }
}

#[test]
fn an_identifier_that_no_recording_has_is_an_error_with_those_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let [a, _, merged] = flights(folder.path());
    for path in [a, merged] {
        let error = Recording::open_one(&path, "nobody").unwrap_err();
        let ReadError::NoSuchRecording { ids, .. } = &error else { panic!("{error}") };
        assert!(ids.iter().all(|id| error.to_string().contains(id)), "{error}");
    }
}

#[test]
fn a_missing_stamp_is_no_stamp_and_not_zero() {
    let folder = tempfile::tempdir().unwrap();
    let [a, _, _] = flights(folder.path());
    let without = folder.path().join("without.rrd");
    let no_stamps = |message| match message {
        LogMsg::ArrowMsg(store, arrow) => {
            let mut chunk = Chunk::from_arrow_msg(&arrow).expect("a chunk");
            if !chunk.is_static() {
                chunk = chunk.timelines_sliced(&["revolution".into()].into_iter().collect());
            }
            LogMsg::ArrowMsg(store, chunk.to_arrow_msg().expect("a chunk"))
        }
        other => other,
    };
    write(&without, messages(&a).into_iter().map(no_stamps));
    let found = differences(&Recording::open(&a).unwrap(), &Recording::open(&without).unwrap(), 0.0).unwrap();
    let [stamp] = found.components.as_slice() else { panic!("{found:?}") };
    let expected = format!("{} ns and none", frames::stamp_ns(0));
    assert_eq!((stamp.component.as_str(), stamp.how.as_str()), ("stamp", expected.as_str()));
}
