//! The parts of a flight: folders, bags, and parts that are missing, gone, or of another kind.

use crosscut_ingest::{Found, IngestError, LossKind, ReadOptions, Recording, parts_in, recordings_in};

use crate::flight::{Folder, Form, drain, expected, plain_flight, record_at, scan, sensor, time_ns};

fn options(topic: Option<&str>) -> ReadOptions {
    ReadOptions { topic: topic.map(str::to_owned), ..ReadOptions::default() }
}

#[test]
fn a_folder_is_one_flight_in_natural_order_and_seq_counts_on() {
    let folder = Folder::new();
    let flight = plain_flight(15);
    let mut parts = flight.chunks(5);
    for name in ["flight_1.mcap", "flight_2.mcap", "flight_10.mcap"] {
        folder.add(name, &Form::CHUNKED.write(parts.next().expect("three parts")));
    }
    folder.add("metadata.yaml", b"rosbag2_bagfile_information:\n");
    let mut recording =
        Recording::open(&[folder.path().to_owned()], &ReadOptions::default(), sensor(&[])).expect("a flight");
    assert_eq!(recording.total_revolutions(), Some(15));
    assert_eq!(drain(&mut recording), expected(15));
}

/// What was lost of a flight in this folder, and how many revolutions there are.
fn losses(folder: &Folder) -> (Vec<String>, usize) {
    let mut recording = Recording::open(&[folder.path().to_owned()], &options(None), sensor(&[])).expect("a flight");
    let revolutions = drain(&mut recording).len();
    let losses = recording.losses().iter();
    assert!(losses.clone().all(|loss| matches!(loss.kind, LossKind::File { .. })));
    (losses.map(ToString::to_string).collect(), revolutions)
}

#[test]
fn a_part_that_is_no_recording_is_a_loss_in_a_folder_and_refused_where_it_was_named() {
    let folder = Folder::new();
    folder.add("f_1.mcap", &Form::CHUNKED.write(&plain_flight(5)));
    folder.add("f_2.mcap", b"");
    assert!(matches!(&losses(&folder), (lost, 5) if lost.len() == 1));
    folder.add("f_3.mcap", b"PK\x03\x04");
    folder.add("f_4.mcap.zstd", b"\x28\xb5\x2f\xfd and more");
    let (lost, revolutions) = losses(&folder);
    assert_eq!((lost.len(), revolutions), (3, 5), "{lost:?}");
    assert!(lost[1].contains("ZIP") && lost[2].contains("f_4.mcap.zstd"), "{lost:?}");
    folder.add("f_4.mcap", &Form::CHUNKED.write(&[record_at("/scan", time_ns(9), &scan(9))]));
    assert!(matches!(&losses(&folder), (lost, 6) if lost.len() == 2), "decompressed, and the other kept");
    let named = ["f_1.mcap", "f_3.mcap"].map(|name| folder.path().join(name));
    let refused = Recording::open(&named, &options(None), sensor(&[])).err();
    assert!(
        matches!(refused, Some(IngestError::NotRecording { found: Found::Known(kind), .. }) if kind.contains("ZIP"))
    );
}

#[test]
fn parts_of_a_bag_come_in_the_order_of_its_metadata_and_one_that_it_names_and_is_not_there_is_a_loss() {
    let folder = Folder::new();
    let part = |seqs: std::ops::Range<u64>| -> Vec<u8> {
        Form::CHUNKED.write(&seqs.map(|i| record_at("/scan", time_ns(i), &scan(i))).collect::<Vec<_>>())
    };
    folder.add("zeta.mcap", &part(0..2));
    folder.add("alpha.mcap", &part(2..4));
    folder.add("mid.mcap", &part(4..6));
    let metadata = |names: &str| format!("rosbag2_bagfile_information:\n  relative_file_paths: [{names}]\n");
    let stamps_ns = |folder: &Folder| {
        let mut recording =
            Recording::open(&[folder.path().to_owned()], &options(None), sensor(&[])).expect("a flight");
        drain(&mut recording).stamps_ns
    };
    let in_order: Vec<u64> = (0..6).map(time_ns).collect();
    assert_ne!(stamps_ns(&folder), in_order, "by name");
    folder.add("metadata.yaml", metadata("zeta.mcap, alpha.mcap, mid.mcap").as_bytes());
    assert_eq!(stamps_ns(&folder), in_order);
    assert_eq!(losses(&folder), (Vec::new(), 6));
    folder.add("metadata.yaml", metadata("zeta.mcap, alpha.mcap, beta.mcap, mid.mcap").as_bytes());
    assert_eq!(stamps_ns(&folder), in_order);
    folder.add("beta.mcap.zst", b"\x28\xb5\x2f\xfd and more");
    let (lost, _) = losses(&folder);
    assert!(lost.len() == 1 && lost[0].contains("beta.mcap.zst"), "compressed, not missing: {lost:?}");
    std::fs::remove_file(folder.path().join("beta.mcap.zst")).expect("it is there");
    let (lost, revolutions) = losses(&folder);
    assert!(lost.len() == 1 && lost[0].contains("beta.mcap") && lost[0].contains("metadata.yaml"), "{lost:?}");
    assert_eq!(revolutions, 6);
}

#[test]
fn a_part_that_is_gone_before_it_is_read_is_a_loss_with_an_index_or_without() {
    for form in Form::all() {
        let folder = Folder::new();
        folder.add("f_1.mcap", &form.write(&plain_flight(5)));
        folder.add("f_2.mcap", &form.write(&plain_flight(5)));
        let mut recording =
            Recording::open(&[folder.path().to_owned()], &options(None), sensor(&[])).expect("a flight");
        std::fs::remove_file(folder.path().join("f_2.mcap")).expect("it is there");
        assert_eq!(drain(&mut recording).len(), 5);
        let [loss, ..] = recording.losses() else { panic!("nothing is said") };
        assert!(loss.file.ends_with("f_2.mcap"), "{loss}");
    }
}

#[test]
fn a_part_without_scans_on_the_topic_is_told() {
    let folder = Folder::new();
    folder.add("f_1.mcap", &Form::CHUNKED.write(&plain_flight(5)));
    folder.add("f_2.mcap", &Form::CHUNKED.write(&[record_at("/scan_filtered", time_ns(9), &scan(9))]));
    let of =
        |topic| Recording::open(&[folder.path().to_owned()], &options(Some(topic)), sensor(&[])).expect("a flight");
    assert_eq!(of("/scan").without_topic(), [folder.path().join("f_2.mcap")]);
    assert_eq!(of("/scan_filtered").without_topic(), [folder.path().join("f_1.mcap")]);
}

#[test]
fn parts_that_overlap_keep_their_seq_when_the_first_is_left_early() {
    let folder = Folder::new();
    folder.add("f_1.mcap", &Form::CHUNKED.write(&plain_flight(20)));
    folder.add("f_2.mcap", &Form::CHUNKED.write(&plain_flight(2)));
    let options = ReadOptions { to_s: Some(0.1), ..ReadOptions::default() };
    let mut recording = Recording::open(&[folder.path().to_owned()], &options, sensor(&[])).expect("a flight");
    assert_eq!(drain(&mut recording).seqs, [0, 1, 20, 21]);
    assert!(recording.losses().is_empty());
}

#[test]
fn numbers_in_names_count_as_numbers() {
    let folder = Folder::new();
    let sorted = [
        "e_11.mcap",
        "f.mcap",
        "f_1.mcap",
        "f_02.mcap",
        "f_2.mcap",
        "f_2_b.mcap",
        "f_10.mcap",
        "g_99999999999999999999999.mcap",
        "g_100000000000000000000000.mcap",
    ];
    sorted.iter().rev().for_each(|name| drop(folder.add(name, b"")));
    let parts = recordings_in(&[folder.path().to_owned()]).expect("recordings");
    assert_eq!(parts.iter().filter_map(|part| part.file_name()).collect::<Vec<_>>(), sorted);
}

#[test]
fn a_folder_without_recordings_names_what_it_has_instead() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = || recordings_in(&[folder.path().to_owned()]).expect_err("no recording").to_string();
    assert!(error().starts_with("the folder is empty: "), "{}", error());
    std::fs::create_dir(folder.path().join("bag")).expect("writable");
    assert!(error().contains("1 folder; name that of the flight"), "{}", error());
    std::fs::write(folder.path().join("notes.txt"), b"").expect("writable");
    assert!(error().contains("none of the 1 files"), "{}", error());
}

#[test]
fn a_folder_stands_for_the_first_kind_of_recordings_in_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let names = || {
        let parts = recordings_in(&[folder.path().to_owned()]).unwrap_or_default();
        parts.iter().map(|part| part.file_name().unwrap_or_default().to_owned()).collect::<Vec<_>>()
    };
    let add = |name: &str| std::fs::write(folder.path().join(name), b"").expect("writable");
    ["f.clf", "f_1.bag.active", "f_0.bag"].into_iter().for_each(add);
    assert_eq!(names(), ["f_0.bag", "f_1.bag.active"]);
    ["f_0.db3.zstd", "f_1.db3", "f_1.db3-wal"].into_iter().for_each(add);
    assert_eq!(names(), ["f_0.db3.zstd", "f_1.db3"]);
    ["f_0.mcap.active", "f_1.mcap.zstd", "f_1.mcap", "notes.txt"].into_iter().for_each(add);
    assert_eq!(names(), ["f_0.mcap.active", "f_1.mcap"], "decompressed, and the other kept");
    let parts = parts_in(&[folder.path().to_owned()]).expect("recordings");
    let left_out: Vec<_> = parts.left_out.iter().filter_map(|path| path.file_name()).collect();
    assert_eq!(left_out, ["f.clf", "f_0.bag", "f_0.db3.zstd", "f_1.bag.active", "f_1.db3"]);
}
