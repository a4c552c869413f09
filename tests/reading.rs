//! `crosscut rrd`: recordings listed, exported, recomputed and compared.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crosscut_messages::LaserScan;

use crate::flight::{Writing, bytes, file, tunnel_scan};
use crate::program::{Ran, lines, run, shipped_flight};

/// Records every eighth revolution of the shipped flight with these settings; returns the results.
fn recorded(path: &Path, settings: &[&str]) -> Vec<Value> {
    let (input, path) = (shipped_flight().display().to_string(), path.display().to_string());
    let fixed = ["run", &input, "--preset", "paper", "--every", "8", "--quiet", "--out", "-", "--save", &path];
    lines(&run(fixed.iter().chain(settings)).expect_code(0).stdout)
}

fn rrd(args: &[&str]) -> Ran {
    run([&["rrd"], args].concat())
}

/// `crosscut rrd get FLIGHT ENTITY --out FILE ...`.
fn get(flight: &Path, entity: &str, out: &Path, more: &[&str]) -> Ran {
    let (flight, out) = (flight.display().to_string(), out.display().to_string());
    rrd(&[&["get", &flight, entity, "--out", &out], more].concat())
}

/// A folder with a recording of the shipped flight.
fn folder() -> (tempfile::TempDir, PathBuf, Vec<Value>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = folder.path().join("tee.rrd");
    let results = recorded(&flight, &[]);
    (folder, flight, results)
}

/// The cells of a CSV file without quotes, below its header.
fn cells(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).expect("exported");
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn a_recording_is_listed_with_its_entities_versions_and_configuration() {
    let (_folder, flight, results) = folder();
    let flight = flight.to_str().expect("UTF-8");
    let listed = rrd(&["ls", flight]).expect_code(0).stdout;
    let last = results.last().expect("results")["seq"].to_string();
    for word in ["/affinity/W", "/spectral/U", "Rerun 0.36", concat!("crosscut ", env!("CARGO_PKG_VERSION")), &last] {
        assert!(listed.contains(word), "{word} in:\n{listed}");
    }
    assert!(!listed.contains("radii") && !listed.contains("[affinity]"));
    let more = rrd(&["ls", flight, "/scan/returns", "--config"]).expect_code(0).stdout;
    assert!(more.contains("radii") && more.contains("[affinity]"));
    let described = run(["info", flight]).expect_code(0).stdout;
    assert!(described.starts_with(&listed) && described.contains("next: crosscut view"), "{described}");
    let settings = rrd(&["ls", flight, "--config"]).expect_code(0).stdout;
    assert!(settings.starts_with("# crosscut") && !settings.contains("/scan/returns"), "{settings}");
}

#[test]
fn unknown_entities_and_files_are_refused_with_alternatives() {
    let (folder, flight, _) = folder();
    let wrong = get(&flight, "/affinity/w", &folder.path().join("w.npy"), &[]).expect_code(2).stderr;
    assert!(wrong.contains("/affinity/W,") && !wrong.contains("/spectral"), "{wrong}");
    let input = shipped_flight().display().to_string();
    let wrong = rrd(&["ls", &input]).expect_code(1).stderr;
    assert!(wrong.contains("it is an MCAP recording"), "{wrong}");
}

#[test]
fn exported_eigenvalues_agree_with_the_results() {
    let (folder, flight, results) = folder();
    for more in [&[][..], &["--exact"]] {
        let out = folder.path().join("eigenvalues.csv");
        get(&flight, "/spectral/eigenvalues", &out, more).expect_code(0);
        let exported = cells(&out);
        let of_revolutions: Vec<_> = exported.chunk_by(|a, b| a[0] == b[0]).collect();
        assert_eq!(of_revolutions.len(), results.len());
        for (rows, result) in of_revolutions.into_iter().zip(&results) {
            assert_eq!(rows[0][..2], [result["seq"].to_string(), result["stamp_ns"].to_string()]);
            let all: Vec<f64> = rows.iter().map(|row| row[3].parse().expect("a number")).collect();
            let expected = numbers(&result["eigenvalues"]);
            // The parser of JSON may be off by the last bit.
            let agree = |(a, b): (&f64, &f64)| (a - b).abs() <= 2.0 * f64::EPSILON * b.abs();
            assert!(
                all.len() >= expected.len() && all.iter().zip(&expected).all(agree),
                "{more:?}: {all:?} {expected:?}"
            );
        }
    }
}

#[test]
fn repaired_bearings_are_recomputed_exactly() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scans: Vec<_> = (0..3).map(tunnel_scan).collect();
    scans[0].angle_increment = f32::NAN;
    scans[1].angle_increment = 0.0;
    scans[1].angle_max = 1.3; // other bearings
    let flight = file(folder.path(), "repaired.mcap", &bytes(&scans, &Writing::default()));
    let (flight, saved) = (flight.to_str().expect("UTF-8"), folder.path().join("repaired.rrd"));
    let out = folder.path().join("w.csv");
    for mounting in [&["--quiet"][..], &["--quiet", "--set", "ingest.upside_down=true", "--set", "ingest.yaw_rad=2.5"]]
    {
        run([&["run", flight, "--save", saved.to_str().expect("UTF-8")], mounting].concat()).expect_code(0);
        get(&saved, "/affinity/W", &out, &["--exact"]).expect_code(0);
        assert_eq!(cells(&out).chunk_by(|a, b| a[0] == b[0]).count(), 3);
    }
}

#[test]
fn an_export_has_the_selected_revolutions() {
    let (folder, flight, _) = folder();
    let out = folder.path().join("junctions.csv");
    let count = |more: &[&str]| {
        get(&flight, "/report/junctions", &out, more).expect_code(0);
        std::fs::read_to_string(&out).expect("exported").lines().count() - 1
    };
    assert_eq!(count(&["--at", "16"]), 1);
    assert_eq!(count(&["--from", "1.5", "--to", "3.3"]), 3); // revolutions 16, 24 and 32, at 10 Hz
    let text = std::fs::read_to_string(&out).expect("exported");
    assert!(text.starts_with("revolution,stamp_ns,value\n16,1700000001600000000,"), "{text}");
    get(&flight, "/report/junctions", &out, &["--at", "17"]).expect_code(2);
}

#[test]
fn arrays_have_a_dimension_of_revolutions_unless_one_is_selected() {
    let (folder, flight, results) = folder();
    let out = folder.path().join("array.npy");
    let header = |entity: &str, more: &[&str]| {
        get(&flight, entity, &out, more).expect_code(0);
        let bytes = std::fs::read(&out).expect("exported");
        (String::from_utf8_lossy(&bytes[..192]).into_owned(), bytes.len() - 192)
    };
    let (n, revolutions) = (results[2]["returns"].as_u64().expect("a number") as usize, results.len());
    let (text, bytes) = header("/affinity/W", &["--exact", "--at", "16"]);
    assert!(text.contains("'<f8'") && text.contains(&format!("({n}, {n}, )")) && bytes == 8 * n * n, "{text}");
    let (text, bytes) = header("/scan/ranges", &[]);
    assert!(text.contains("'<f4'") && text.contains(&format!("({revolutions}, 360, )")), "{text}");
    assert_eq!(bytes, 4 * 360 * revolutions);
    let ran = get(&flight, "/affinity/degrees", &out, &[]).expect_code(2);
    assert!(ran.stderr.contains("--at"), "lengths differ: {}", ran.stderr);
}

#[test]
fn a_failed_export_leaves_the_old_file() {
    let (folder, flight, _) = folder();
    let out = folder.path().join("keep.npy");
    std::fs::write(&out, "good").expect("written");
    get(&flight, "/affinity/degrees", &out, &[]).expect_code(2); // of different lengths
    get(&flight, "/report/junctions", &out, &["--at", "17"]).expect_code(2); // not recorded
    assert_eq!(std::fs::read_to_string(&out).expect("still there"), "good");
    let files = || std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(files(), 2, "the recording and what was there");
    get(&flight, "/report/junctions", &out, &[]).expect_code(0);
    assert!(std::fs::read(&out).expect("replaced").starts_with(b"\x93NUMPY"));
    assert_eq!(files(), 2);
}

#[test]
fn static_entities_are_exported_once_without_a_revolution() {
    let (folder, flight, _) = folder();
    let text = |name: &str, entity: &str, more: &[&str]| {
        let out = folder.path().join(name);
        get(&flight, entity, &out, more).expect_code(0);
        std::fs::read_to_string(out).expect("exported")
    };
    let config = text("config.csv", "/config", &[]);
    assert!(config.starts_with("revolution,stamp_ns,item,value\n,,0,") && config.contains("[affinity]"), "{config}");
    let extent = text("extent.csv", "/layout/extent", &["--at", "16"]);
    assert!(extent.starts_with("revolution,stamp_ns,") && extent.lines().nth(1).is_some_and(|l| l.starts_with(",,0,")));
    get(&flight, "/config", &folder.path().join("config.npy"), &[]).expect_code(2);
}

#[test]
fn what_cannot_be_exported_is_said_with_what_can() {
    let (folder, flight, _) = folder();
    let says = |ran: Ran, word: &str| assert!(ran.stderr.contains(word), "{}", ran.stderr);
    let out = folder.path().join("x.csv");
    says(get(&flight, "/affinity/X", &out, &[]).expect_code(2), "/affinity/W");
    says(get(&flight, "/affinity/W:Tensor:data", &out, &[]).expect_code(2), "EncodedDepthImage:blob");
    says(get(&flight, "/report/place", &out, &["--exact"]).expect_code(2), "/spectral/U");
    says(get(&flight, "/affinity/W", &folder.path().join("x.txt"), &[]).expect_code(2), ".npy");
    says(get(&flight, "/report/place", &folder.path().join("x.npy"), &[]).expect_code(2), ".csv");
    says(get(&flight, "/report/place", &folder.path().join("x.jsonl"), &[]).expect_code(2), ".npy, .csv or .md");
    says(get(&flight, "/affinity/W", &flight, &[]).expect_code(2), "overwritten");
    let light = folder.path().join("light.rrd");
    let arguments =
        ["run", "--quiet", "--to", "0.5", "--set", "recording.detail=light", "--save"].map(std::ffi::OsString::from);
    run(arguments.into_iter().chain([light.clone().into(), shipped_flight().into()])).expect_code(0);
    says(get(&light, "/affinity/W", &out, &[]).expect_code(2), "--exact recomputes it");
}

#[test]
fn a_matrix_too_large_to_draw_exports_no_zeros() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [input, flight, out] = ["many.mcap", "many.rrd", "w.npy"].map(|name| folder.path().join(name));
    let many = LaserScan { angle_increment: 2.0 * PI / 1100.0, ranges: vec![3.0; 1100], ..tunnel_scan(1) };
    std::fs::write(&input, bytes(&[tunnel_scan(0), many], &Writing::default())).expect("a file");
    let [input, saved] = [&input, &flight].map(|path| path.to_str().expect("UTF-8"));
    run(["run", input, "--quiet", "--save", saved]).expect_code(0);
    let w = |more: &[&str]| get(&flight, "/affinity/W", &out, more);
    let refused = w(&["--at", "1"]).expect_code(2).stderr;
    assert!(refused.contains("more than 1024") && refused.contains("--exact") && !out.exists(), "{refused}");
    assert!(w(&[]).expect_code(0).stderr.contains("no picture of 1 revolution"));
    w(&["--at", "1", "--exact"]).expect_code(0);
    // The Laplacian of returns without edges is 0, and is drawn.
    let alone = recorded(&flight, &["--set", "affinity.sigma_per_m2=1e6"]).len();
    let zeros = get(&flight, "/spectral/L", &out, &[]).expect_code(0).stderr;
    assert!(alone > 0 && !zeros.contains("no picture"), "{zeros}");
}

#[test]
fn diff_finds_the_first_stage_that_differs() {
    let (folder, flight, _) = folder();
    let other = folder.path().join("other.rrd");
    let compare =
        |code| rrd(&["diff", flight.to_str().expect("UTF-8"), other.to_str().expect("UTF-8")]).expect_code(code).stdout;
    recorded(&other, &["--set", "pipeline.workers=1"]);
    assert!(compare(0).contains("pipeline.workers = 1"), "settings that differ are said");
    recorded(&other, &["--set", "recording.part_revolutions=5"]);
    assert!(compare(0).contains("recording.part_revolutions = 5"), "split into parts");
    recorded(&other, &["--set", "affinity.sigma_per_m2=1.4"]);
    let said = compare(1);
    assert!(said.contains("different first at revolution 0, in affinity"), "{said}");
    std::fs::write(&other, "no recording").expect("written");
    compare(2);
}

#[test]
fn a_truncated_recording_is_read_with_code_3() {
    let (folder, flight, _) = folder();
    let whole = std::fs::read(&flight).expect("recorded");
    let cut = folder.path().join("cut.rrd");
    std::fs::write(&cut, &whole[..whole.len() / 2]).expect("written");
    let (flight, cut) = (flight.to_str().expect("UTF-8"), cut.to_str().expect("UTF-8"));
    let listed = rrd(&["ls", cut]).expect_code(3);
    assert!(listed.stdout.contains("/scan/ranges") && listed.stderr.contains("cut off"), "{}", listed.stderr);
    let out = folder.path().join("ranges.csv");
    get(Path::new(cut), "/scan/ranges", &out, &[]).expect_code(3);
    assert!(std::fs::read_to_string(out).expect("exported").lines().count() > 360);
    rrd(&["diff", flight, cut]).expect_code(3);
}

/// The messages of a recording: between the header of the file (12 bytes) and its end. Each has a header of two u64,
/// kind and length; kind 0 is the end.
fn messages(recording: &Path) -> Vec<u8> {
    let bytes = std::fs::read(recording).expect("recorded");
    let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"));
    let mut end = 12;
    while word(end) != 0 {
        end += 16 + word(end + 8) as usize;
    }
    bytes[12..end].to_vec()
}

#[test]
fn a_file_with_several_recordings_asks_which_one_is_meant() {
    let (folder, flight, _) = folder();
    let [other, merged, out] = ["other.rrd", "merged.rrd", "junctions.csv"].map(|name| folder.path().join(name));
    recorded(&other, &["--set", "affinity.sigma_per_m2=1.25", "--to", "3"]);
    let header = std::fs::read(&flight).expect("recorded")[..12].to_vec();
    std::fs::write(&merged, [header, messages(&flight), messages(&other), vec![0; 16]].concat()).expect("written");
    let merged_name = merged.to_str().expect("UTF-8");

    let asked = get(&merged, "/report/junctions", &out, &[]).expect_code(2).stderr;
    assert!(asked.contains("--recording ID") && !out.exists(), "{asked}");
    let listed = rrd(&["ls", merged_name]).expect_code(0).stdout;
    let ids: Vec<&str> = listed.lines().filter_map(|line| line.strip_prefix("recording   ")).collect();
    assert!(ids.len() == 2 && ids.iter().all(|id| asked.contains(id)), "{asked}{listed}");
    let rows = ids.iter().map(|id| {
        get(&merged, "/report/junctions", &out, &["--recording", id]).expect_code(0);
        std::fs::read_to_string(&out).expect("exported").lines().count() - 1
    });
    assert_eq!(rows.collect::<Vec<_>>(), [18, 4]);
    get(&merged, "/report/junctions", &out, &["--recording", "nobody"]).expect_code(2);

    let diff = |files: [&Path; 2], chosen: &[&str]| {
        let options = chosen.iter().flat_map(|id| ["--recording", id]);
        let files = files.map(|path| path.to_str().expect("UTF-8"));
        rrd(&["diff"].into_iter().chain(files).chain(options).collect::<Vec<_>>())
    };
    assert!(diff([&merged, &flight], &[]).expect_code(2).stderr.contains("--recording ID"));
    assert!(diff([&flight, &merged], &[ids[0]]).expect_code(0).stdout.starts_with("the same"));
    diff([&merged, &merged], &ids).expect_code(1);
    diff([&flight, &other], &[ids[0]]).expect_code(2);
    let asked = run(["run", &shipped_flight().display().to_string(), "--config", merged_name]).expect_code(2).stderr;
    assert!(asked.contains("several recordings"), "{asked}");
}

/// Paths of the shipped flight in three parts.
fn in_parts(folder: &Path) -> [PathBuf; 3] {
    let parts = ["tee.rrd", "tee-2.rrd", "tee-3.rrd"].map(|name| folder.join(name));
    recorded(&parts[0], &["--set", "recording.part_revolutions=8"]);
    parts
}

#[test]
fn parts_do_not_replace_another_recording_of_that_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [first, second, _] = in_parts(folder.path());
    recorded(&second, &["--to", "3"]);
    let kept = std::fs::read(&second).expect("recorded");
    for _ in ["beside it", "in place of its own parts"] {
        in_parts(folder.path());
        assert!(std::fs::read(&second).expect("still there") == kept);
        let names = std::fs::read_dir(folder.path()).expect("a folder").map(|file| file.expect("an entry").file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        assert_eq!(names, ["tee-2.rrd", "tee-3.rrd", "tee-4.rrd", "tee.rrd"]);
        let listed = rrd(&["ls", first.to_str().expect("UTF-8")]).expect_code(0);
        assert!(listed.stdout.contains("0 to 136") && listed.stderr.is_empty(), "{}", listed.stderr);
    }
}

#[test]
fn the_reasons_of_a_revolution_are_read_without_a_viewer() {
    let (folder, flight, results) = folder();
    let out = folder.path().join("why.md");
    get(&flight, "/report/why", &out, &[]).expect_code(0);
    let all = std::fs::read_to_string(&out).expect("exported");
    assert_eq!(all.matches("# Revolution ").count(), results.len());
    let printed = get(&flight, "/report/why", Path::new("-"), &["--at", "16"]).expect_code(0).stdout;
    assert!(!printed.is_empty() && all.contains(&printed) && !printed.starts_with("# Revolution"), "{printed}");
    let numbers = get(&flight, "/spectral/U", Path::new("-"), &["--at", "16"]).expect_code(2).stderr;
    assert!(numbers.contains("no text") && numbers.contains(".npy"), "{numbers}");
}

#[test]
fn a_recording_gives_its_settings_to_another_run() {
    let (folder, flight, _) = folder();
    let other = folder.path().join("other.rrd");
    recorded(&flight, &["--set", "affinity.sigma_per_m2=1.25"]);
    recorded(&other, &["--config", flight.to_str().expect("UTF-8")]);
    let same = rrd(&["diff", flight.to_str().expect("UTF-8"), other.to_str().expect("UTF-8")]).expect_code(0).stdout;
    assert!(same.starts_with("the same"), "{same}");
    let input = shipped_flight().display().to_string();
    let no_recording = run(["run", &input, "--config", "/nowhere/tee.rrd"]).expect_code(2).stderr;
    assert!(no_recording.contains("/nowhere/tee.rrd"), "{no_recording}");
}

#[test]
fn a_missing_part_is_reported_and_the_rest_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [first, second, third] = in_parts(folder.path());
    let listed = |code| rrd(&["ls", first.to_str().expect("UTF-8")]).expect_code(code);
    let away = folder.path().join("away");
    assert_eq!(listed(0).stderr, "");

    std::fs::rename(&second, &away).expect("moved");
    let gap = listed(3);
    assert!(gap.stderr.contains("part 2 is missing") && gap.stdout.contains("0 to 136"), "{}", gap.stderr);
    let ranges = folder.path().join("ranges.csv");
    get(&first, "/scan/ranges", &ranges, &[]).expect_code(3);
    let mut revolutions: Vec<usize> = cells(&ranges).iter().map(|row| row[0].parse().expect("a number")).collect();
    revolutions.dedup();
    assert!(revolutions.into_iter().eq((0..64).chain(128..141).step_by(8)));
    std::fs::rename(&away, &second).expect("moved");

    std::fs::rename(&third, &away).expect("moved");
    let cut = listed(3).stderr;
    assert!(cut.contains("part 3, which continues the recording, is missing"), "{cut}");
    std::fs::rename(&away, &third).expect("moved");

    let renamed = folder.path().join("other.rrd");
    std::fs::rename(&first, &renamed).expect("moved");
    let alone = rrd(&["ls", renamed.to_str().expect("UTF-8")]).expect_code(3).stderr;
    assert!(alone.contains("part 2, which continues the recording, is missing"), "{alone}");
    let later = rrd(&["ls", second.to_str().expect("UTF-8")]).expect_code(3).stderr;
    assert!(later.contains("part 1 is missing"), "{later}");
}
