//! Input: MCAP files in every form, damaged files, and files of other formats.

use std::ffi::OsStr;
use std::path::Path;

use crosscut_messages::Endian;

use crate::flight::{Writing, bytes, file, tunnel, tunnel_scan};
use crate::program::{Ran, column, crosscut, results_of, run, shipped_flight};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn every_way_of_writing_gives_the_same_results() {
    let folder = folder();
    let ways = [
        ("plain", Writing::default()),
        ("zstd", Writing { compression: Some(mcap::Compression::Zstd), ..Writing::default() }),
        ("lz4", Writing { compression: Some(mcap::Compression::Lz4), ..Writing::default() }),
        ("unchunked", Writing { chunked: false, ..Writing::default() }),
        ("big_endian", Writing { endian: Endian::Big, ..Writing::default() }),
    ];
    let mut reference: Option<String> = None;
    for (name, writing) in ways {
        let flight = file(folder.path(), &format!("{name}.mcap"), &tunnel(10, &writing));
        let stdout = results_of(&flight, &["--quiet"]).0.expect_code(0).stdout;
        assert_eq!(stdout.lines().count(), 10, "{name}");
        assert!(reference.get_or_insert_with(|| stdout.clone()) == &stdout, "{name} differs from plain");
    }
}

#[test]
fn beams_beyond_a_full_turn_change_only_the_labels() {
    let folder = folder();
    let scans: Vec<_> = (0..5).map(tunnel_scan).collect();
    let answers = |more: usize| {
        let mut wound = scans.clone();
        for scan in &mut wound {
            scan.ranges.extend_from_within(..more);
            scan.angle_max += more as f32 * scan.angle_increment;
        }
        let flight = file(folder.path(), &format!("{more}.mcap"), &bytes(&wound, &Writing::default()));
        let mut lines = results_of(&flight, &["--preset", "default"]).1;
        for line in &mut lines {
            let labels = line["labels"].as_array_mut().expect("labels");
            assert!(labels.drain(180..).eq(std::iter::repeat_n(-1, more)), "{more} more beams");
            line["notes"] = serde_json::json!([]);
        }
        lines
    };
    let expected = answers(0);
    assert!(expected.iter().all(|line| line["place"] == "corridor"), "{expected:?}");
    for more in [1, 20, 150] {
        assert_eq!(answers(more), expected, "{more} more beams");
    }
}

#[test]
fn a_recording_cut_inside_a_chunk_gives_every_complete_scan() {
    let folder = folder();
    let whole = tunnel(40, &Writing { compression: Some(mcap::Compression::Zstd), ..Writing::default() });
    let flight = file(folder.path(), "cut.mcap", &whole[..whole.len() / 2]);
    let (ran, lines) = results_of(&flight, &[]);
    let ran = ran.expect_code(3);
    assert!(lines.len() > 5 && lines.len() < 40, "{} lines", lines.len());
    assert!(column(&lines, "seq").into_iter().eq(0..lines.len() as u64));
    assert!(ran.stderr.contains("lost:") && ran.stderr.contains("cut.mcap"), "{}", ran.stderr);
}

#[test]
fn an_unreadable_message_has_an_empty_line() {
    let folder = folder();
    let mut scans: Vec<_> = (0..3).map(tunnel_scan).collect();
    scans[1].ranges.clear();
    let mut broken = bytes(&scans, &Writing { chunked: false, ..Writing::default() });
    // The empty scan's length of ranges, found by the range_max before it: make it claim 4 billion beams.
    let mark = [12.0f32.to_le_bytes(), [0; 4]].concat();
    let at = broken.windows(8).position(|window| window == mark).expect("the empty scan is there");
    broken[at + 4..at + 8].fill(0xFF);
    let flight = file(folder.path(), "broken.mcap", &broken);
    let (ran, lines) = results_of(&flight, &[]);
    ran.expect_code(3);
    assert_eq!(column(&lines, "seq"), [0, 1, 2]);
    assert_eq!(lines[1]["returns"], 0);
    assert!(!lines[1]["notes"].as_array().expect("notes").is_empty(), "{}", lines[1]);
    assert_eq!(lines[2]["junctions"], 2, "what comes after is read");
}

#[test]
fn an_empty_scan_has_a_line() {
    let folder = folder();
    let mut scans: Vec<_> = (0..3).map(tunnel_scan).collect();
    scans[1].ranges.clear();
    scans[2].ranges.fill(f32::NAN);
    let flight = file(folder.path(), "empty.mcap", &bytes(&scans, &Writing::default()));
    let (ran, lines) = results_of(&flight, &[]);
    ran.expect_code(0);
    assert_eq!(column(&lines, "returns")[1..], [0, 0]);
    assert_eq!(column(&lines, "junctions")[1..], [0, 0]);
    assert!(lines[1]["margin"].is_null());
    assert_eq!(lines[2]["labels"].as_array().map(Vec::len), Some(180));
}

#[test]
fn a_run_says_what_was_noted_of_its_scans() {
    let folder = folder();
    let mut scans: Vec<_> = (0..3).map(tunnel_scan).collect();
    scans[1].ranges.fill(0.0);
    scans[2].ranges[..7].fill(0.0);
    let flight = file(folder.path(), "zeros.mcap", &bytes(&scans, &Writing::default()));
    let ran = run(["run".as_ref(), flight.as_os_str()]).expect_code(0);
    assert!(ran.stdout.contains("2  180 beams of range 0 read as no return"), "{}", ran.stdout);
}

fn refused(name: &str, content: &[u8]) -> Ran {
    let folder = folder();
    let input = file(folder.path(), name, content);
    let ran = run(["run".as_ref(), input.as_os_str()]).expect_code(1);
    assert!(ran.stderr.contains(name), "the file is named: {}", ran.stderr);
    ran
}

#[test]
fn a_file_that_is_no_recording_is_identified() {
    refused("empty.mcap", b"");
    refused("noise.mcap", &[7; 4096]);
    let ran = run(["run", "nowhere.mcap"]).expect_code(1);
    assert_eq!(ran.stderr, "error: there is no file or folder nowhere.mcap\n");
    let ran = refused("flight.bag", b"#ROSRECORD V1.2\nand more");
    assert!(ran.stderr.contains("rosbag fix"), "{}", ran.stderr);
    let ran = refused("flight.mcap", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n");
    assert!(ran.stderr.contains("git lfs pull"), "{}", ran.stderr);
}

#[test]
fn a_recording_without_scans_is_told_what_it_has_instead() {
    let folder = folder();
    let mut other = bytes(&[tunnel_scan(0)], &Writing { chunked: false, topics: &["/points"], ..Writing::default() });
    let (from, to) = (b"sensor_msgs/msg/LaserScan", b"sensor_msgs/msg/PointClou");
    while let Some(at) = other.windows(from.len()).position(|window| window == from) {
        other[at..at + to.len()].copy_from_slice(to);
    }
    let flight = file(folder.path(), "cloud.mcap", &other);
    let ran = run(["run".as_ref(), flight.as_os_str()]).expect_code(1);
    assert!(ran.stderr.contains("/points") && ran.stderr.contains("PointClou"), "{}", ran.stderr);
}

#[test]
fn several_scan_topics_are_listed_and_one_can_be_chosen() {
    let folder = folder();
    let writing = Writing { topics: &["/front/scan", "/rear/scan"], ..Writing::default() };
    let flight = file(folder.path(), "two.mcap", &tunnel(4, &writing));
    let ran = run(["run".as_ref(), flight.as_os_str()]).expect_code(1);
    assert!(ran.stderr.contains("/front/scan") && ran.stderr.contains("/rear/scan"), "{}", ran.stderr);
    let (ran, lines) = results_of(&flight, &["--topic", "/rear/scan"]);
    ran.expect_code(0);
    assert_eq!(lines.len(), 4);
    let ran = run(["run".as_ref(), flight.as_os_str(), "--topic".as_ref(), "/rear/scn".as_ref()]).expect_code(1);
    assert!(ran.stderr.contains("/rear/scan"), "{}", ran.stderr);
}

#[test]
fn several_files_are_one_flight() {
    let folder = folder();
    let first: Vec<_> = (0..3).map(tunnel_scan).collect();
    let second: Vec<_> = (3..5).map(tunnel_scan).collect();
    let parts = [
        file(folder.path(), "flight_0.mcap", &bytes(&first, &Writing::default())),
        file(folder.path(), "flight_1.mcap", &bytes(&second, &Writing::default())),
    ];
    let ran = run(["run".as_ref(), parts[0].as_os_str(), parts[1].as_os_str(), "--out".as_ref(), "-".as_ref()]);
    let lines = crate::program::lines(&ran.expect_code(0).stdout);
    assert_eq!(column(&lines, "seq"), [0, 1, 2, 3, 4]);
}

#[test]
fn standard_input_is_read_by_every_configuration_and_for_every_topic() {
    let folder = folder();
    let writing = Writing { topics: &["/front", "/rear"], ..Writing::default() };
    let flight = file(folder.path(), "flight.mcap", &tunnel(5, &writing));
    let out = folder.path().join("report.html");
    let piped = |input: &Path, command: &str| {
        let command = command.split(' ').map(|word| if word == "OUT" { out.as_os_str() } else { word.as_ref() });
        let input = std::fs::File::open(input).expect("a recording");
        Ran::from(crosscut(command).stdin(input).output().expect("the program starts")).expect_code(0).stdout
    };
    let lines = piped(&flight, "run - --topic /front --topic /rear --out -");
    assert!(lines.contains("joined with /rear"), "{lines}");
    let compared = piped(&shipped_flight(), "compare - --with default --with threshold --json -");
    assert!(compared.contains("same_count"), "{compared}");
    piped(&shipped_flight(), "report - --out OUT");
    assert!(std::fs::read_to_string(&out).expect("written").contains("Against the truth in the recording"));
}

#[test]
#[cfg(unix)]
fn a_flight_may_have_more_parts_than_open_files() {
    let folder = folder();
    for part in 0..60 {
        let chunked = part % 2 == 0; // the others have no index
        let writing = Writing { chunked, ..Writing::default() };
        file(folder.path(), &format!("flight_{part:02}.mcap"), &bytes(&[tunnel_scan(part)], &writing));
    }
    let crosscut = crosscut(["compare", "--with", "default", "--with", "threshold", "--json", "-"]);
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", "ulimit -n 40; exec \"$0\" \"$@\""]).arg(crosscut.get_program()).args(crosscut.get_args());
    let ran = Ran::from(limited.arg(folder.path()).output().expect("a shell")).expect_code(0);
    let compared: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!(compared["comparisons"][0]["figures"]["same_count"]["of"], 60);
}

#[test]
fn info_describes_parts_after_an_unreadable_one() {
    let folder = folder();
    let whole = tunnel(10, &Writing::default());
    for (name, content) in [("flight_0.mcap", &whole[..]), ("flight_1.mcap", b""), ("flight_2.mcap", &whole)] {
        file(folder.path(), name, content);
    }
    let ran = run(["info".as_ref(), folder.path().as_os_str()]).expect_code(3);
    assert!(ran.stdout.contains("flight_0.mcap") && ran.stdout.contains("flight_2.mcap"), "{}", ran.stdout);
    assert!(ran.stderr.contains("lost: ") && ran.stderr.contains("flight_1.mcap"), "{}", ran.stderr);
    let wrecks = self::folder();
    for name in ["flight_0.mcap", "flight_1.mcap"] {
        file(wrecks.path(), name, b"");
    }
    run(["info".as_ref(), wrecks.path().as_os_str()]).expect_code(1);
    let parts = ["flight_0.mcap", "nowhere.mcap", "flight_2.mcap"].map(|name| folder.path().join(name));
    let ran = run(["info".as_ref()].into_iter().chain(parts.iter().map(|part| part.as_os_str()))).expect_code(1);
    assert!(ran.stdout.contains("flight_2.mcap") && ran.stderr.contains("nowhere.mcap"), "{}", ran.stderr);
}

#[test]
fn info_counts_clouds_that_are_alike() {
    let folder = folder();
    let cloud = |points: usize| {
        let header =
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n";
        let rows: String = (0..points).map(|at| format!("{at} 1 0\n")).collect();
        format!("{header}WIDTH {points}\nPOINTS {points}\nDATA ascii\n{rows}")
    };
    for stamp in 1..=4 {
        file(folder.path(), &format!("{stamp}.0.pcd"), cloud(10 + stamp).as_bytes());
    }
    let shown = run(["info".as_ref(), folder.path().as_os_str()]).expect_code(0).stdout;
    assert!(shown.contains("11 points") && shown.contains("4 beams, 4 returns"), "{shown}");
    assert!(
        shown.contains("\n3 files more like it, to ") && shown.contains("4.0.pcd") && !shown.contains("2.0.pcd"),
        "{shown}"
    );
}

#[test]
fn info_shows_the_topics_and_what_a_scan_looks_like() {
    let folder = folder();
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(10, &Writing::default()));
    let ran = run(["info".as_ref(), flight.as_os_str()]).expect_code(0);
    for fact in ["/scan", "sensor_msgs/msg/LaserScan", "10", "180", "lidar"] {
        assert!(ran.stdout.contains(fact), "{fact} is missing:\n{}", ran.stdout);
    }
}

#[test]
fn an_empty_selection_fails_and_names_the_time_of_scans() {
    let folder = folder();
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let said = |selection: &[&str]| {
        let (ran, lines) = results_of(&flight, selection);
        assert!(lines.is_empty());
        ran.expect_code(1).stderr
    };
    let text = said(&["--from", "100"]);
    assert!(
        text.contains("no scan of /scan was recorded from 100 s on; the last one before that is at 0.4 s"),
        "{text}"
    );
    let text = said(&["--from", "0.25", "--to", "0.26"]);
    assert!(text.contains("from 0.25 s to 0.26 s; the last one before that is at 0.2 s"), "{text}");
    let text = said(&["--from", "0.1", "--every", "9"]);
    assert!(text.contains("whose number is a multiple of 9 "), "{text}");
}

#[test]
fn control_characters_in_topics_are_escaped() {
    let folder = folder();
    let writing = Writing { topics: &["/scan\u{1b}[31m", "/rear"], ..Writing::default() };
    let flight = file(folder.path(), "odd.mcap", &tunnel(1, &writing));
    let flight = flight.to_str().expect("UTF-8");
    let shown = run(["info", flight]).expect_code(0).stdout;
    let said = run(["run", flight]).expect_code(1).stderr;
    for text in [shown, said] {
        assert!(!text.contains('\u{1b}') && text.contains(r"/scan\u{1b}[31m"), "{text:?}");
    }
}

#[test]
fn one_of_a_thing_is_not_told_in_the_plural() {
    let folder = folder();
    let writing = Writing { topics: &["/front", "/rear"], ..Writing::default() };
    let flight = file(folder.path(), "one.mcap", &tunnel(1, &writing));
    let said = run(["run".as_ref(), flight.as_os_str()]).expect_code(1).stderr;
    assert!(said.contains("1 message") && !said.contains("1 messages"), "{said}");
    let (ran, _) = results_of(&flight, &["--topic", "/rear"]);
    assert!(ran.stderr.starts_with("1 revolution in "), "{}", ran.stderr);
}

#[test]
fn data_after_the_end_of_a_recording_is_reported() {
    let folder = folder();
    let whole = tunnel(10, &Writing::default());
    let flight = file(folder.path(), "two.mcap", &[whole.clone(), whole.clone()].concat());
    let (ran, lines) = results_of(&flight, &["--quiet"]);
    assert_eq!(lines.len(), 10);
    let said = ran.expect_code(3).stderr;
    assert!(said.contains(&format!("ends at byte {0}; {0} bytes behind", whole.len())), "{said}");
}

#[test]
fn a_recording_without_readable_scans_fails_and_keeps_old_results() {
    let folder = folder();
    let mut damaged = tunnel(10, &Writing::default());
    damaged[2000] ^= 1; // inside the only chunk
    let flight = file(folder.path(), "flight.mcap", &damaged);
    let results = file(folder.path(), "results.jsonl", b"older\n");
    let said = run(["run".as_ref(), flight.as_os_str(), "--out".as_ref(), results.as_os_str()]).expect_code(1).stderr;
    assert!(said.contains("checksum") && said.contains("no scan could be read"), "{said}");
    assert_eq!(std::fs::read(results).expect("still there"), b"older\n");
}

#[test]
fn a_flight_of_which_no_scan_can_be_decoded_is_a_failure_and_older_results_stay() {
    let folder = folder();
    let mut broken = tunnel(9, &Writing { chunked: false, ..Writing::default() });
    for scan in 0..9 {
        // The header of CDR, and the stamp: seconds and nanoseconds.
        let stamp_ns = tunnel_scan(scan).header.stamp.nanosec.to_le_bytes();
        let start = [&[0, 1, 0, 0], &[0; 4], &stamp_ns[..]].concat();
        let at = broken.windows(start.len()).position(|bytes| bytes == start).expect("less than a second");
        broken[at + 1] = 0x77;
    }
    let flight = file(folder.path(), "flight.mcap", &broken);
    let results = file(folder.path(), "results.jsonl", b"older\n");
    let ran = run(["run".as_ref(), flight.as_os_str(), "--out".as_ref(), results.as_os_str()]).expect_code(1);
    assert!(ran.stderr.contains("can be decoded"), "{}", ran.stderr);
    assert_eq!(std::fs::read(results).expect("still there"), b"older\n");
}

#[test]
fn info_ends_with_the_command_that_runs_the_flight() {
    let folder = folder();
    let flight = file(folder.path(), "my flight.mcap", &tunnel(10, &Writing::default()));
    let shown = run(["info".as_ref(), flight.as_os_str()]).expect_code(0).stdout;
    assert!(shown.ends_with(&format!("next: crosscut run '{}'\n", flight.display())), "{shown}");
    let shown = run(["info".as_ref(), flight.as_os_str(), "--preset=paper".as_ref()]).expect_code(0).stdout;
    assert!(shown.ends_with(&format!("next: crosscut run '{}' --preset paper\n", flight.display())), "{shown}");
}

#[test]
fn a_converted_flight_gives_the_same_results() {
    let folder = folder();
    let flight =
        file(folder.path(), "flight.mcap", &tunnel(10, &Writing { endian: Endian::Big, ..Writing::default() }));
    let out = folder.path().join("converted.mcap");
    let convert =
        |input: &Path, out: &Path| run(["convert".as_ref(), input.as_os_str(), "--out".as_ref(), out.as_os_str()]);
    convert(&flight, &out).expect_code(0);
    let results = |path: &Path| results_of(path, &["--quiet"]).0.expect_code(0).stdout;
    assert_eq!(results(&out), results(&flight));
    let before = std::fs::read(&out).expect("converted");
    convert(&file(folder.path(), "empty.mcap", b""), &out).expect_code(1);
    assert_eq!(std::fs::read(&out).expect("still there"), before, "a failure replaces nothing");
    convert(&flight, &flight).expect_code(2);
    convert(&flight, Path::new("-")).expect_code(2);
    let other = file(folder.path(), "new.mcap.unfinished", b"of the user");
    convert(&flight, &folder.path().join("new.mcap")).expect_code(0);
    assert_eq!(std::fs::read(other).expect("still there"), b"of the user");
}

#[test]
fn info_describes_the_first_scan_of_the_selected_frame() {
    let folder = folder();
    let mut scans: Vec<_> = (0..4).map(tunnel_scan).collect();
    scans[2].header.frame_id = "rear".into();
    let flight = file(folder.path(), "flight.mcap", &bytes(&scans, &Writing::default()));
    let shown = |frame: &str| {
        let setting = format!("ingest.frame_id={frame}");
        run(["info".as_ref(), flight.as_os_str(), "--set".as_ref(), setting.as_ref()]).expect_code(0).stdout
    };
    assert!(shown("rear").contains("frame \"rear\"") && shown("lidar").contains("frame \"lidar\""));
    assert!(shown("front").contains("no selected scan on /scan"), "{}", shown("front"));
}

#[test]
fn recordings_of_another_kind_in_a_folder_are_noted() {
    let folder = folder();
    let others = self::folder();
    for name in ["a.mcap", "b.bag"] {
        std::fs::copy(crate::program::shipped_flight(), folder.path().join(name)).expect("writable");
    }
    let converted = others.path().join("out.mcap");
    let commands: [&[&OsStr]; 4] = [
        &["run".as_ref()],
        &["info".as_ref()],
        &["compare".as_ref()],
        &["convert".as_ref(), "--out".as_ref(), converted.as_os_str()],
    ];
    for command in commands {
        let said = run(command.iter().copied().chain([folder.path().as_os_str()])).expect_code(0).stderr;
        assert!(said.contains("left out 1 recording of another kind; name one to run it: "), "{command:?}: {said}");
    }
}

#[test]
fn every_topic_that_is_named_is_joined_to_the_first() {
    let folder = folder();
    let two = Writing { topics: &["/front", "/rear"], ..Writing::default() };
    let flight = file(folder.path(), "flight.mcap", &tunnel(4, &two));
    let notes_of = |topics: &[&str]| {
        let (ran, lines) = results_of(&flight, topics);
        ran.expect_code(0);
        lines.iter().map(|line| line["notes"].to_string()).collect::<Vec<_>>()
    };
    let alone = notes_of(&["--topic", "/front"]);
    let both = notes_of(&["--topic", "/front", "--topic", "/rear"]);
    assert_eq!((alone.len(), both.len()), (4, 4));
    assert!(both.iter().all(|notes| notes.contains("joined with /rear in frame `lidar`")), "{both:?}");
    assert!(alone.iter().all(|notes| !notes.contains("joined")), "{alone:?}");
}

/// An MCAP without chunks, index and messages, of this many scan topics.
fn empty_topics(count: u16) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let record = |opcode: u8, body: &[u8]| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let schema = [&1u16.to_le_bytes()[..], &text("sensor_msgs/msg/LaserScan"), &text("ros2msg"), &text("")].concat();
    let mut bytes = [mcap::MAGIC, &record(1, &[text(""), text("")].concat()), &record(3, &schema)].concat();
    for id in 1..=count {
        let ids = [id.to_le_bytes(), 1u16.to_le_bytes()].concat();
        bytes.extend(record(4, &[ids, text(&format!("/scan{id}")), text("cdr"), vec![0; 4]].concat()));
    }
    bytes.extend([&record(15, &[0; 4])[..], &record(2, &[0; 20]), mcap::MAGIC].concat());
    bytes
}

#[test]
fn many_topics_without_messages_cost_no_time() {
    let folder = folder();
    let flight = file(folder.path(), "topics.mcap", &empty_topics(20_000));
    let start = std::time::Instant::now();
    let info = run(["info".as_ref(), flight.as_os_str()]).expect_code(0);
    assert!(info.stdout.contains("/scan20000"), "{} bytes", info.stdout.len());
    let refused = run(["run".as_ref(), flight.as_os_str()]).expect_code(1).stderr;
    assert!(refused.contains("and 19900 more") && refused.lines().count() < 110, "{refused}");
    assert!(start.elapsed() < std::time::Duration::from_secs(40), "{:?}", start.elapsed()); // 3 min when it was quadratic
}
