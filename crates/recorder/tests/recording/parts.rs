//! A recording that goes on in a second file: read as one, and never mixed with what else lies beside.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crosscut_rrd::Recording;
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{DecoderApp, Encoder, EncodingOptions};
use rerun::log::{Chunk, LogMsg};

use crate::frames;
use crate::reading::record;

/// Writes the messages of a recording to two files: those from revolution 10 on to the second.
fn split(whole: &Path, first: &Path, second: &Path) {
    let mut encoders = [first, second].map(|path| {
        let file = File::create(path).expect("a file");
        Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, file).expect("an encoder")
    });
    for message in DecoderApp::decode_eager(BufReader::new(File::open(whole).expect("recorded"))).expect("an .rrd") {
        let message = message.expect("whole");
        let parts = match &message {
            LogMsg::ArrowMsg(_, arrow) => {
                let chunk = Chunk::from_arrow_msg(arrow).expect("a chunk");
                let times = chunk.timelines().get(&"revolution".into()).map_or(&[][..], rerun::TimeColumn::times_raw);
                if times.first().is_some_and(|&time| time >= 10) { 1..2 } else { 0..1 }
            }
            _ => 0..2,
        };
        encoders[parts].iter_mut().for_each(|encoder| {
            encoder.append(&message).expect("written");
        });
    }
    encoders.iter_mut().for_each(|encoder| encoder.finish().expect("written"));
}

fn revolutions(recording: &Recording) -> Vec<i64> {
    let rows = recording.rows("/scan/ranges").expect("ranges");
    rows.map(|row| row.expect("readable").revolution).collect()
}

#[test]
fn the_files_of_a_recording_are_read_as_one_and_those_of_another_recording_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, first, second] = ["whole.rrd", "flight.rrd", "flight-2.rrd"].map(|name| folder.path().join(name));
    let frames: Vec<_> = (0..90).map(frames::frame).collect();
    record(&whole, &frames);
    split(&whole, &first, &second);
    let expected: Vec<i64> = (0..90).collect();
    let both = Recording::open(&first).unwrap();
    assert_eq!(both.paths().collect::<Vec<_>>(), [&first, &second]);
    assert_eq!((revolutions(&both), both.damages()), (expected.clone(), &[][..]));
    assert_eq!(both.entities()["/affinity/W"].revolutions, Some([0, 89]));
    let later = revolutions(&Recording::open(&second).unwrap());
    assert!(!later.is_empty() && later.len() < 90 && expected.ends_with(&later), "{later:?}");
    record(&second, &frames[..3]);
    assert_eq!(
        revolutions(&Recording::open(&first).unwrap()),
        expected[..90 - later.len()],
        "an older file lies beside"
    );
}
