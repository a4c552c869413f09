//! The library that reads recordings: every value as the frame held it, in any batching, from damaged files as well.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use crosscut_rrd::{Damage, ReadError, Recording, Row, Value};
use crosscut_stage::Frame;
use crosscut_stage::NoteCode::N101;
use rerun::StoreKind;
use rerun::external::arrow::ipc::root_as_message;
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{DecoderApp, Encoder, EncodingOptions};
use rerun::log::{Chunk, LogMsg};

use crate::frames;
use crate::reading::record;

/// A flight of 20 revolutions, one of them empty, and where it was recorded to.
fn flight(folder: &Path) -> (Vec<Frame>, PathBuf) {
    let mut frames: Vec<Frame> = (0..20).map(frames::frame).collect();
    frames[9] = frames::empty_frame(9);
    frames[4].notes.add(N101, "first");
    frames[4].notes.add(N101, "second");
    let path = folder.join("flight.rrd");
    record(&path, &frames);
    (frames, path)
}

/// The values of an entity by revolution, those of its main component.
fn values(recording: &Recording, entity: &str) -> Vec<(i64, Value)> {
    let component = recording.values_component(entity).expect("readable");
    let rows = recording.rows(entity).expect("readable").map(|row| row.expect("readable"));
    rows.flat_map(|row| {
        let values: Vec<_> = row.values(component).map(|value| (row.revolution, value.expect("readable"))).collect();
        values
    })
    .collect()
}

/// Entities that have their numbers at every revolution.
const NUMBERS: [&str; 18] = [
    "/scan/ranges",
    "/scan/seen",
    "/scan/returns",
    "/scan/openings",
    "/affinity/degrees",
    "/spectral/eigenvalues",
    "/spectral/tolerance",
    "/spectral/k",
    "/spectral/U",
    "/kmeans/labels",
    "/kmeans/centroids",
    "/report/junctions",
    "/report/confidence",
    "/timing/ingest",
    "/timing/affinity",
    "/timing/spectral",
    "/timing/kmeans",
    "/timing/report",
];

#[test]
fn words_read_back_as_words_each_as_often_as_it_was_said() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let recording = Recording::open(&path).unwrap();
    let notes: Vec<_> = values(&recording, "/log").into_iter().filter(|(revolution, _)| *revolution == 4).collect();
    assert_eq!(notes, ["first", "second"].map(|note| (4, Value::Texts(vec![note.to_owned()]))));
    assert_eq!(values(&recording, "/report/place")[0].1, Value::Texts(vec!["tee".to_owned()]));
    assert_eq!(recording.config_toml().as_deref(), Some("[affinity]\nkind = \"rbf\"\n"));
}

#[test]
fn what_is_not_there_is_an_error_that_names_what_is() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let recording = Recording::open(&path).unwrap();
    let error = recording.rows("/affinity/X").unwrap_err().to_string();
    assert!(error.contains("/affinity/X") && error.contains("/affinity/W"), "{error}");
    let row: Row = recording.rows("/affinity/W").unwrap().next().unwrap().unwrap();
    let error = row.value("Tensor:data").unwrap_err().to_string();
    assert!(error.contains("EncodedDepthImage:blob"), "{error}");
    let open = |name: &str| Recording::open(&folder.path().join(name)).unwrap_err();
    assert!(matches!(open("none.rrd"), ReadError::Open { .. }));
    std::fs::write(folder.path().join("words.rrd"), "these are no bytes of a recording").unwrap();
    assert!(matches!(open("words.rrd"), ReadError::Open { .. }));
    std::fs::write(folder.path().join("empty.rrd"), "").unwrap();
    assert!(matches!(open("empty.rrd"), ReadError::Open { .. }));
}

/// The recording once more, every row in a chunk of its own and the last rows first.
pub(crate) fn with_other_chunks(path: &Path) -> PathBuf {
    let mut rows = Vec::new();
    let mut others = Vec::new();
    for message in
        DecoderApp::decode_eager(std::io::BufReader::new(File::open(path).expect("readable"))).expect("readable")
    {
        match message.expect("readable") {
            LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                let chunk = Chunk::from_arrow_msg(&message).expect("readable");
                let slices = (0..chunk.num_rows()).map(|row| chunk.row_sliced_deep(row, 1));
                rows.extend(slices.map(|row| LogMsg::ArrowMsg(store.clone(), row.to_arrow_msg().expect("readable"))));
            }
            other => others.push(other),
        }
    }
    let other = path.with_extension("other.rrd");
    let file = File::create(&other).expect("readable");
    let mut encoder =
        Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, file).expect("readable");
    others.iter().chain(rows.iter().rev()).for_each(|message| {
        encoder.append(message).expect("readable");
    });
    encoder.finish().expect("readable");
    other
}

#[test]
fn rows_come_by_revolution_whatever_the_chunks_they_were_written_in() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let other = Recording::open(&with_other_chunks(&path)).unwrap();
    let recording = Recording::open(&path).unwrap();
    for entity in NUMBERS.into_iter().chain(["/affinity/W", "/report/place"]) {
        assert!(values(&recording, entity) == values(&other, entity), "{entity}");
        let revolutions: Vec<i64> = values(&other, entity).into_iter().map(|(revolution, _)| revolution).collect();
        assert_eq!(revolutions, (0..20).collect::<Vec<_>>());
    }
}

#[test]
fn a_file_cut_anywhere_gives_the_rows_before_the_cut_and_says_that_it_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let whole = std::fs::read(&path).unwrap();
    let intact = Recording::open(&path).unwrap();
    assert_eq!(intact.damages(), []);
    let all: BTreeMap<&str, _> = NUMBERS.into_iter().map(|entity| (entity, values(&intact, entity))).collect();
    let cut_path = folder.path().join("cut.rrd");
    for cut in (12..whole.len()).step_by(whole.len() / 59) {
        std::fs::write(&cut_path, &whole[..cut]).unwrap();
        let recording = Recording::open(&cut_path).unwrap();
        assert!(matches!(recording.damages(), [Damage::Unfinished { .. } | Damage::CutOff { .. }]), "at byte {cut}");
        for (entity, all) in all.iter().filter(|(entity, _)| recording.entities().contains_key(**entity)) {
            assert!(all.starts_with(&values(&recording, entity)), "{entity}, cut at byte {cut}");
        }
    }
}

/// Decodes every value, whether it can be or not.
fn read_all(recording: &Recording) {
    for entity in recording.entities().keys() {
        for row in recording.rows(entity).expect("readable") {
            let row = row.expect("readable");
            row.components().for_each(|component| drop(row.value(component)));
        }
    }
}

#[test]
fn many_damaged_bytes_never_end_in_a_panic_nor_in_want_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let damaged_path = folder.path().join("damaged.rrd");
    for whole in [std::fs::read(&path).unwrap(), uncompressed(&path)] {
        let mut state = 1_u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for _ in 0..60 {
            let mut damaged = whole.clone();
            for _ in 0..=random(40) {
                let at = 12 + random(whole.len() - 12);
                let stretch = damaged[at..].iter_mut().take(1 + random(16));
                stretch.for_each(|byte| *byte = [0, 0xFF, random(256) as u8][random(3)]);
            }
            std::fs::write(&damaged_path, damaged).unwrap();
            if let Ok(recording) = Recording::open(&damaged_path) {
                read_all(&recording);
            }
        }
    }
}

#[test]
fn a_damaged_byte_never_ends_in_a_panic_and_costs_no_more_than_its_message_where_lengths_are_intact() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let whole = std::fs::read(&path).unwrap();
    let damaged_path = folder.path().join("damaged.rrd");
    let mut damaged_files = 0;
    for at in (12..whole.len()).step_by(whole.len() / 61) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0xFF;
        std::fs::write(&damaged_path, damaged).unwrap();
        let recording = Recording::open(&damaged_path).unwrap();
        damaged_files += usize::from(!recording.damages().is_empty());
        read_all(&recording);
    }
    // Nothing tells that a digit of a number is wrong, and most of this short flight is an exact W.
    assert!(damaged_files > 3, "{damaged_files} of 61 were noticed");
}

/// The recording at `path` once more, its messages not compressed.
fn uncompressed(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(File::open(path).expect("readable"));
    let messages: Vec<LogMsg> =
        DecoderApp::decode_eager(file).expect("readable").map(|message| message.expect("readable")).collect();
    let mut bytes = Vec::new();
    let mut encoder =
        Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_UNCOMPRESSED, &mut bytes).expect("memory");
    for message in &messages {
        encoder.append(message).expect("memory");
    }
    encoder.finish().expect("memory");
    drop(encoder);
    bytes
}

#[test]
fn a_message_that_claims_more_bytes_than_there_are_costs_itself_alone_and_no_memory() {
    const CONTINUATION: [u8; 4] = [0xFF; 4];
    let folder = tempfile::tempdir().unwrap();
    let (_, path) = flight(folder.path());
    let whole = uncompressed(&path);
    let damaged_path = folder.path().join("damaged.rrd");
    let starts = (12..whole.len() - 8).filter(|&at| whole[at..].starts_with(&CONTINUATION));
    let mut claims = 0;
    for at in starts.step_by(7) {
        let bytes = u32::from_le_bytes(whole[at + 4..][..4].try_into().unwrap()) as usize;
        let Some(metadata) = whole.get(at + 8..at + 8 + bytes) else { continue };
        let metadata = metadata.to_vec(); // aligned
        let Ok(message) = root_as_message(&metadata) else { continue };
        let claimed = message.bodyLength().to_le_bytes();
        let Some(field) = metadata.windows(8).position(|word| message.bodyLength() > 0 && word == claimed) else {
            continue;
        };
        let mut damaged = whole.clone();
        damaged[at + 8 + field..][..8].copy_from_slice(&(1_i64 << 60).to_le_bytes());
        std::fs::write(&damaged_path, damaged).unwrap();
        let recording = Recording::open(&damaged_path).unwrap();
        let [Damage::Unreadable { cause, .. }] = recording.damages() else { panic!("{:?}", recording.damages()) };
        assert!(cause.contains("more than there are"), "{cause}");
        claims += 1;
    }
    assert!(claims > 3, "{claims} messages were found");
}

#[test]
fn a_tensor_whose_shape_does_not_fit_its_numbers_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let rec = rerun::RecordingStreamBuilder::new("crosscut").save(&path).unwrap();
    rec.set_time_sequence("revolution", 0);
    let numbers = rerun::TensorBuffer::F64((0..11).map(f64::from).collect::<Vec<_>>().into());
    rec.log("spectral/U", &rerun::Tensor::new(rerun::TensorData::new(vec![3, 4], numbers))).unwrap();
    rec.flush_blocking().unwrap();
    drop(rec);
    let recording = Recording::open(&path).unwrap();
    let component = recording.values_component("/spectral/U").unwrap();
    let rows: Vec<_> = recording.rows("/spectral/U").unwrap().map(Result::unwrap).collect();
    let errors: Vec<String> =
        rows.iter().flat_map(|row| row.values(component)).map(|value| value.unwrap_err().to_string()).collect();
    assert!(errors.len() == 1 && errors[0].contains("does not fit its 11 numbers"), "{errors:?}");
}
