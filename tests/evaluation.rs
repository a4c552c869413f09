//! `crosscut compare` where the truth is known, on recordings of this project and on others.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use crosscut_messages::{
    CDR_ENCODING, Endian, JSON_ENCODING, JSON_SCHEMA_ENCODING, LaserScan, Message, SCHEMA_ENCODING,
};
use mcap::records::MessageHeader;
use serde_json::Value;

use crate::flight::{PERIOD_NS, file, tunnel_scan};
use crate::program::{Ran, root, run, shipped_flight};

/// The truth of [`tunnel_scan`], as another program would write it: two walls, and openings ahead and behind.
fn tunnel_truth() -> Value {
    let label = |(beam, range): (usize, &f32)| if range.is_finite() { i32::from(beam >= 90) } else { -1 };
    let labels: Vec<_> = tunnel_scan(0).ranges.iter().enumerate().map(label).collect();
    let opening =
        |bearing_rad: f64| serde_json::json!({"bearing_rad": bearing_rad, "width_m": 6.0, "name": "an opening"});
    let openings = [opening(-std::f64::consts::PI), opening(0.0)];
    serde_json::json!({"walls": 2, "islands": 0, "openings": openings, "labels": labels, "author": "by hand"})
}

/// A recording of tunnel scans with these truths, as another program would write it: another topic of scans, and all
/// truths after all scans.
fn recording(folder: &Path, name: &str, truths: &[Option<Value>]) -> PathBuf {
    let mut writer =
        mcap::WriteOptions::new().chunk_size(Some(8 * 1024)).create(Cursor::new(Vec::new())).expect("memory");
    let schema = writer.add_schema(LaserScan::SCHEMA_NAME, SCHEMA_ENCODING, LaserScan::SCHEMA_TEXT.as_bytes());
    let scans = writer.add_channel(schema.expect("memory"), "/front/scan", CDR_ENCODING, &Default::default());
    let schema = writer.add_schema("Truth", JSON_SCHEMA_ENCODING, b"{}").expect("memory");
    let truth_channel = writer.add_channel(schema, "/truth", JSON_ENCODING, &Default::default()).expect("memory");
    let mut write = |channel_id: u16, i: usize, data: &[u8]| {
        let log_time = (i as u64 + 1) * PERIOD_NS;
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: 0 };
        writer.write_to_known_channel(&header, data).expect("memory");
    };
    let scans = scans.expect("memory");
    for i in 0..truths.len() {
        write(scans, i, &tunnel_scan(i as u64).encode(Endian::Big));
    }
    for (i, truth) in truths.iter().enumerate() {
        if let Some(truth) = truth {
            write(truth_channel, i, truth.to_string().as_bytes());
        }
    }
    writer.finish().expect("memory");
    file(folder, name, &writer.into_inner().into_inner())
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn evaluate(input: &Path, more: &[&str]) -> Ran {
    run([&["compare", input.to_str().expect("a path in UTF-8")], more].concat())
}

fn json_of(ran: &Ran) -> Value {
    serde_json::from_str(&ran.stdout).expect("the output is JSON")
}

#[test]
fn a_tunnel_recorded_and_labelled_elsewhere_is_right() {
    let folder = folder();
    let input = recording(folder.path(), "tunnel.mcap", &vec![Some(tunnel_truth()); 5]);
    let figures = &json_of(&evaluate(&input, &["--json", "-"]).expect_code(0))["families"][0]["results"][0]["figures"];
    assert_eq!((&figures["right"]["hits"], &figures["right"]["of"]), (&5.into(), &5.into()), "{figures:#}");
    assert_eq!(figures["labels"]["share"], 1.0);
    assert_eq!((&figures["openings"]["missed"]["of"], &figures["openings"]["missed"]["hits"]), (&10.into(), &0.into()));
}

#[test]
fn configurations_stand_side_by_side_by_family_and_in_all() {
    let folder = folder();
    recording(folder.path(), "tunnel.mcap", &vec![Some(tunnel_truth()); 3]);
    std::fs::copy(shipped_flight(), folder.path().join("tee.mcap")).expect("a copy");
    // No wall has this many returns, so none is found.
    let blind = file(folder.path(), "blind.toml", b"[report]\nmin_returns = 1000\n");
    let with = ["--with", "paper", "--with", blind.to_str().expect("a path in UTF-8")];
    let json = json_of(&evaluate(folder.path(), &[&with[..], &["--json", "-"]].concat()).expect_code(0));
    let families: Vec<_> = json["families"].as_array().expect("a list").iter().map(|f| f["family"].clone()).collect();
    assert_eq!(families, ["tee", "tunnel"]);
    assert_eq!(json["configurations"][1]["name"], "blind");
    assert!(json["configurations"][1]["settings"].as_str().expect("TOML").contains("min_returns = 1000"));
    let figures = |family: usize, column: usize| &json["families"][family]["results"][column]["figures"];
    assert_eq!(figures(1, 0)["right"]["share"], 1.0);
    assert_eq!(figures(1, 1)["under_count"]["share"], 1.0);
    let all = &json["all"][0]["figures"]["revolutions"];
    assert_eq!(all.as_u64(), figures(0, 0)["revolutions"].as_u64().map(|tee| tee + 3));

    let table = evaluate(folder.path(), &with).expect_code(0).stdout;
    let row = table.lines().find(|line| line.trim_start().starts_with("tunnel")).expect("a row for the tunnel");
    assert!(row.contains("100.0 [43.9, 100.0]") && row.contains("0.0 [0.0, 56.1]"), "{table}");
}

#[test]
fn without_truth_evaluation_fails_and_writes_nothing() {
    let folder = folder();
    let input = recording(folder.path(), "unlabelled.mcap", &[None, None]);
    let json = folder.path().join("out.json");
    let ran = evaluate(&input, &["--json", json.to_str().expect("a path in UTF-8")]).expect_code(2);
    assert!(ran.stderr.contains("/truth") && ran.stderr.contains("unlabelled.mcap"), "{}", ran.stderr);
    assert!(!json.exists());
}

#[test]
fn scans_that_cannot_be_compared_are_reported_with_code_3() {
    let folder = folder();
    let (good, short) =
        (tunnel_truth(), serde_json::json!({"walls": 2, "islands": 0, "openings": [], "labels": [0, 1]}));
    let truths = [Some(good.clone()), None, Some(short), Some(serde_json::json!("two")), Some(good)];
    let input = recording(folder.path(), "gaps.mcap", &truths);
    let ran = evaluate(&input, &["--json", "-", "--with", "paper", "--with", "default"]).expect_code(3);
    assert_eq!(json_of(&ran)["all"][0]["figures"]["right"]["of"], 2);
    assert_eq!(ran.stderr.matches("no truth has the log time of 1 scan,").count(), 1, "once for both: {}", ran.stderr);
    assert!(ran.stderr.contains("2 scans cannot be compared") && ran.stderr.contains("revolution 2"), "{}", ran.stderr);
    let page = folder.path().join("gaps.html");
    run([Path::new("report"), &input, Path::new("--out"), &page]).expect_code(3);
    assert!(std::fs::read_to_string(&page).expect("written").contains("<li>2 scans cannot be compared"));
}

#[test]
fn truths_that_belong_to_no_scan_are_a_failure() {
    let folder = folder();
    let short = serde_json::json!({"walls": 0, "islands": 0, "openings": [], "labels": []});
    let input = recording(folder.path(), "foreign.mcap", &[Some(short.clone()), Some(short)]);
    let ran = evaluate(&input, &[]).expect_code(1);
    assert!(ran.stderr.contains("no scan could be compared"), "{}", ran.stderr);
}

#[test]
fn a_truncated_recording_is_evaluated_to_its_end() {
    let folder = folder();
    let whole = std::fs::read(shipped_flight()).expect("it ships");
    let input = file(folder.path(), "cut.mcap", &whole[..whole.len() * 2 / 3]);
    let ran = evaluate(&input, &["--json", "-"]).expect_code(3);
    let compared = json_of(&ran)["all"][0]["figures"]["revolutions"].as_u64().expect("a number");
    let of_whole = json_of(&evaluate(&shipped_flight(), &["--json", "-"]))["all"][0]["figures"]["revolutions"].clone();
    assert!(compared > 0 && Some(compared) < of_whole.as_u64(), "{compared} of {of_whole}");
    assert!(ran.stderr.contains("cut off"), "{}", ran.stderr);
}

#[test]
fn wrong_usage_is_refused_before_anything_runs() {
    let flight = shipped_flight();
    let refused = |more: &[&str]| evaluate(&flight, more).expect_code(2).stderr;
    assert!(refused(&["--with", "papper"]).contains("there are: paper, default"));
    assert!(refused(&["--json", "-", "--csv", "-"]).contains("would be overwritten"));
    assert!(refused(&["--json", flight.to_str().expect("a path in UTF-8")]).contains("would be overwritten"));
    assert!(refused(&["--with", "paper", "--set", "affinity.sigma=1"]).contains("did you mean sigma_per_m2?"));
    assert!(root().join("recordings/tee.mcap").metadata().expect("it is still there").len() > 1000);
}

#[test]
fn a_recording_without_truth_does_not_stop_the_others() {
    let folder = folder();
    recording(folder.path(), "hand.mcap", &[Some(tunnel_truth())]);
    recording(folder.path(), "none.mcap", &[None]);
    file(folder.path(), "torn.mcap", b"no recording");
    let ran = evaluate(folder.path(), &["--json", "-"]).expect_code(1);
    assert_eq!(json_of(&ran)["all"][0]["figures"]["revolutions"], 1);
    let left_out = json_of(&ran)["problems"].as_array().expect("a list").clone();
    assert_eq!(left_out.len(), 2, "{left_out:?}");
    assert!(ran.stderr.contains("left out: there is no truth") && ran.stderr.contains("torn.mcap"), "{}", ran.stderr);
    std::fs::remove_file(folder.path().join("hand.mcap")).expect("there");
    let said = evaluate(folder.path(), &[]).expect_code(1).stderr;
    assert_eq!((said.matches("error: ").count(), said.matches("torn.mcap").count()), (2, 1), "{said}");
}

#[test]
fn settings_that_change_the_scans_are_noted() {
    let said = |more: &[&str]| evaluate(&shipped_flight(), more).expect_code(0).stderr;
    let masked = said(&["--set", "ingest.masked_sectors_rad=[[1,2]]"]);
    assert!(masked.contains("default sets ingest.masked_sectors_rad=[[1.0, 2.0]]"), "{masked}");
    assert!(!said(&[]).contains("note:"));
}

#[test]
fn a_flight_through_a_known_mine_is_judged_as_a_flight() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = folder.path().join("tee.mcap");
    run(["simulate".as_ref(), "tee".as_ref(), "--out".as_ref(), flight.as_os_str()]).expect_code(0);
    let json = folder.path().join("figures.json");
    let by_odometry = "default,flight.pose=odometry".as_ref();
    let with =
        ["--with".as_ref(), "default".as_ref(), "--with".as_ref(), by_odometry, "--json".as_ref(), json.as_os_str()];
    let ran = run([&["compare".as_ref(), flight.as_os_str()], &with[..]].concat()).expect_code(0);
    assert!(ran.stdout.contains("flights: % of the revolutions whose place is right"), "{}", ran.stdout);
    assert!(ran.stdout.contains("every change") && ran.stdout.contains("8 m radius"), "{}", ran.stdout);
    let figures: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).expect("written")).expect("JSON");
    let flight = &figures["families"][0]["results"][0]["flight"];
    assert_eq!(flight["map"]["false_merges"], 0, "{flight}");
    assert_eq!(flight["map"]["recall"]["share"], 1.0, "the tee is found: {flight}");
    assert!(flight["here"]["passage"]["share"].as_f64().is_some_and(|share| share > 0.9), "{flight}");
    let by_odometry = &figures["families"][0]["results"][1]["flight"];
    assert_eq!(by_odometry["map"]["recall"]["share"], 1.0, "the recording has odometry: {by_odometry}");
}

#[test]
fn several_configurations_begin_with_a_verdict_on_each_by_family() {
    let folder = folder();
    recording(folder.path(), "tunnel.mcap", &vec![Some(tunnel_truth()); 3]);
    std::fs::copy(shipped_flight(), folder.path().join("tee.mcap")).expect("a copy");
    let with = ["--with", "default", "--with", "paper", "--with", "mine=default,report.min_returns=1000"];
    let ran = evaluate(folder.path(), &with).expect_code(0);
    let first = ran.stdout.lines().next().expect("a line");
    assert!(
        first.starts_with("against default: paper mends 0 and breaks 70 of 144") && first.contains("Holm"),
        "{first}"
    );
    assert!(ran.stdout.contains("mine mends 0 and breaks 144 of 144"), "{}", ran.stdout);
    assert!(ran.stdout.contains("what paper mends and breaks against default, revolutions"), "{}", ran.stdout);
    let json = json_of(&evaluate(folder.path(), &[&with[..], &["--json", "-"]].concat()).expect_code(0));
    let families = json["verdicts"][1]["families"].as_array().expect("a list");
    let broken: Vec<_> =
        families.iter().map(|of| (of["family"].as_str(), of["broken"].as_array().map(Vec::len))).collect();
    assert_eq!(broken, [(Some("tee"), Some(141)), (Some("tunnel"), Some(3))]);
    let alone = evaluate(folder.path(), &[]).expect_code(0).stdout;
    assert!(!alone.contains("mends"), "there is nothing to compare: {alone}");
}

#[test]
fn flights_of_one_name_are_named_by_their_paths() {
    let folder = folder();
    for sub in ["a", "b"] {
        std::fs::create_dir(folder.path().join(sub)).expect("made");
        recording(folder.path(), &format!("{sub}/tunnel.mcap"), &[Some(tunnel_truth())]);
    }
    let both = ["a", "b"].map(|sub| folder.path().join(sub).join("tunnel.mcap").display().to_string());
    let families = json_of(&run(["compare", &both[0], &both[1], "--json", "-"]).expect_code(0))["families"].clone();
    let names: Vec<_> = families.as_array().expect("a list").iter().filter_map(|of| of["family"].as_str()).collect();
    assert_eq!(names, both);
}
