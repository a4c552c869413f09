//! `crosscut compare`: the effect of a setting on a flight without truth.

use std::path::Path;

use serde_json::Value;

use crate::flight::{Writing, bytes, file, tunnel, tunnel_scan};
use crate::program::{Ran, column, crosscut, results_of, run, shipped_flight};

fn compare(input: &Path, with: &[&str], more: &[&str]) -> Ran {
    let with = with.iter().flat_map(|name| ["--with", name]);
    run(["compare", input.to_str().expect("a path in UTF-8")].into_iter().chain(with).chain(more.iter().copied()))
}

fn json(input: &Path, with: &[&str]) -> Value {
    let ran = compare(input, with, &["--json", "-"]).expect_code(0);
    serde_json::from_str(&ran.stdout).expect("the output is JSON")
}

#[test]
fn counts_and_stretches_agree_with_two_runs() {
    let flight = shipped_flight();
    let junctions = |preset: &str| column(&results_of(&flight, &["--preset", preset]).1, "junctions");
    let (default, paper) = (junctions("default"), junctions("paper"));
    let same = default.iter().zip(&paper).filter(|(a, b)| a == b).count();
    assert!(same > 0 && same < default.len(), "the flight tells nothing: {same} of {}", default.len());

    let found = &json(&flight, &["default", "paper"])["comparisons"][0];
    assert_eq!(found["figures"]["same_count"]["hits"], same);
    assert_eq!(found["figures"]["same_count"]["of"], default.len());
    // Every revolution whose counts differ is in a stretch with these counts.
    let stretches = found["figures"]["stretches"].as_array().expect("a list");
    for (seq, pair) in default.iter().zip(&paper).enumerate().filter(|(_, (a, b))| a != b) {
        let covers = |s: &&Value| (s["seq"][0].as_u64()..=s["seq"][1].as_u64()).contains(&Some(seq as u64));
        let stretch = stretches.iter().find(covers).unwrap_or_else(|| panic!("no stretch has revolution {seq}"));
        assert_eq!(stretch["junctions"], serde_json::json!([pair.0, pair.1]), "at revolution {seq}");
    }
    let in_stretches: u64 = stretches.iter().map(|s| s["revolutions"].as_u64().expect("a number")).sum();
    let alike = &found["figures"]["same_walls"];
    assert_eq!(alike["hits"].as_u64().expect("a number") + in_stretches, default.len() as u64);
}

#[test]
fn a_configuration_against_itself_differs_nowhere() {
    let found = json(&shipped_flight(), &["default", "default"]);
    let figures = &found["comparisons"][0]["figures"];
    for measure in ["same_count", "same_k", "same_walls", "returns_alike"] {
        assert_eq!(figures[measure]["share"], 1.0, "{measure}");
    }
    assert_eq!(figures["stretches"], serde_json::json!([]));
    let shown = compare(&shipped_flight(), &["default", "default"], &[]).expect_code(0).stdout;
    for nothing in ["settings that differ: none", "stretches where the walls of default and default differ: none"] {
        assert!(shown.contains(nothing), "{nothing} in:\n{shown}");
    }
}

#[test]
fn a_scan_left_out_shifts_no_answer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scans: Vec<_> = (0..12).map(tunnel_scan).collect();
    for (seq, scan) in scans.iter_mut().enumerate() {
        if seq % 3 == 0 {
            scan.header.frame_id = "front".into();
        } else {
            scan.ranges.fill(f32::INFINITY); // an answer that differs from those of the tunnel
        }
    }
    let input = file(folder.path(), "two.mcap", &bytes(&scans, &Writing::default()));
    for with in [["default", "default,ingest.frame_id=front"], ["default,ingest.frame_id=front", "default"]] {
        let figures = json(&input, &with)["comparisons"][0]["figures"].clone();
        assert_eq!(figures["same_walls"]["of"], 4, "{with:?}");
        assert_eq!(figures["same_walls"]["hits"], 4, "{with:?}");
        let by_one = if with[0] == "default" { [8, 0] } else { [0, 8] };
        assert_eq!(figures["answered_by_one"], serde_json::json!(by_one), "{with:?}");
    }
    let shown = compare(&input, &["default", "default,ingest.frame_id=front"], &[]).expect_code(0).stdout;
    assert!(shown.contains("by one only"), "{shown}");
}

#[test]
fn single_settings_make_a_configuration_and_the_table_shows_them() {
    let ran = compare(&shipped_flight(), &["paper", "paper,affinity.sigma_per_m2=3,kmeans.seed=7"], &[]).expect_code(0);
    let rows: Vec<Vec<_>> = ran.stdout.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(rows.contains(&vec!["affinity.sigma_per_m2", "1.5", "3.0"]), "{}", ran.stdout);
    assert!(rows.contains(&vec!["kmeans.seed", "0", "7"]), "{}", ran.stdout);
    let settings =
        rows.iter().skip_while(|row| row.first() != Some(&"setting")).skip(1).take_while(|row| !row.is_empty());
    let settings = settings.count();
    assert_eq!(settings, 2, "settings that are the same must not be shown: {}", ran.stdout);
}

#[test]
fn a_failing_configuration_ends_the_comparison_but_keeps_its_start() {
    // A dense W of 342 returns and its working memory need more than 2 MB.
    let small = ["default", "paper,pipeline.memory_mb=2"];
    let ran = compare(&shipped_flight(), &small, &["--json", "-"]).expect_code(1);
    assert!(
        ran.stderr.contains("error: paper,pipeline.memory_mb=2: affinity failed on revolution 0"),
        "{}",
        ran.stderr
    );
    let found: Value = serde_json::from_str(&ran.stdout).expect("the output is JSON");
    assert_eq!(found["comparisons"][0]["figures"]["same_count"]["of"], 0);
}

#[test]
fn a_truncated_recording_is_compared_to_its_end() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = std::fs::read(shipped_flight()).expect("it ships");
    let input = file(folder.path(), "cut.mcap", &whole[..whole.len() * 2 / 3]);
    let ran = compare(&input, &["default", "threshold"], &[]).expect_code(3);
    assert_eq!(ran.stderr.matches("lost: ").count(), 1, "once for both: {}", ran.stderr);
}

#[test]
fn comparing_parts_out_of_order_is_noted() {
    let flight = shipped_flight();
    let twice = compare(&flight, &["default", "default"], &[flight.to_str().expect("a path in UTF-8")]).expect_code(0);
    assert!(twice.stderr.contains("note: time goes back at 1 scan;"), "{}", twice.stderr);
    let once = compare(&flight, &["default", "default"], &[]).expect_code(0);
    assert!(!once.stderr.contains("goes back"), "{}", once.stderr);
}

#[test]
fn one_configuration_or_an_unknown_one_is_wrong_usage() {
    let flight = shipped_flight();
    let refused = |with: &[&str], more: &[&str]| compare(&flight, with, more).expect_code(2).stderr;
    assert!(refused(&["default"], &[]).contains("at least two"));
    assert!(refused(&["default", "papper"], &[]).contains("there are: paper, default"));
    assert!(refused(&["default", "paper,affinity.sigma=3"], &[]).contains("did you mean sigma_per_m2?"));
    for with in ["paper,mine.toml", "mine.toml"] {
        assert!(refused(&["default", with], &[]).contains("mine.toml: No such file"), "{with}");
    }
    assert!(refused(&["default", "paper,mine"], &[]).contains("\"mine\" is neither a preset"));
    let input = flight.to_str().expect("a path in UTF-8");
    assert!(refused(&["default", "paper"], &["--json", input]).contains("would be overwritten"));
}

#[test]
fn a_settings_file_overrides_the_preset_before_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = file(folder.path(), "finer.toml", b"[affinity]\nsigma_per_m2 = 3.0\n");
    let with = format!("paper,{}", settings.display());
    let figures =
        json(&shipped_flight(), &["paper,affinity.sigma_per_m2=3", &with])["comparisons"][0]["figures"].clone();
    assert_eq!(figures["same_walls"]["hits"], figures["same_walls"]["of"], "the same settings: {figures}");
    // Alone the file overrides preset `default`, whose affinity has no such parameter.
    compare(&shipped_flight(), &["paper", settings.to_str().expect("UTF-8")], &[]).expect_code(2);
}

#[test]
fn what_a_configuration_is_does_not_depend_on_the_files_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Files with the names of a preset and of a setting.
    for name in ["paper", "affinity.sigma_per_m2=3"] {
        file(folder.path(), name, b"[vehicle]\nwidth_m = 99\n");
    }
    let flight = shipped_flight();
    let args = ["compare", flight.to_str().expect("UTF-8"), "--every=20", "--json=-", "--with=paper", "--with"];
    let compared = |with: &str| {
        let ran = crosscut(args.into_iter().chain([with])).current_dir(folder.path()).output().expect("it starts");
        let ran = Ran::from(ran).expect_code(0);
        serde_json::from_str::<Value>(&ran.stdout).expect("JSON")["configurations"][1].clone()
    };
    let [plain, named] = ["paper,affinity.sigma_per_m2=3", "mine=paper,affinity.sigma_per_m2=3"].map(compared);
    assert_eq!((&plain["name"], &named["name"]), (&"paper,affinity.sigma_per_m2=3".into(), &"mine".into()));
    assert_eq!(plain["settings"], named["settings"]);
    assert!(plain["settings"].as_str().is_some_and(|settings| !settings.contains("99")));
}

#[test]
fn seconds_count_from_the_beginning_of_the_flight() {
    let flight = shipped_flight();
    let stamps_ns = column(&results_of(&flight, &[]).1, "stamp_ns");
    // The first selected scan is some time after 5.02 s.
    let shown = compare(&flight, &["default", "paper"], &["--from", "5.02", "--every", "4", "--all"]).expect_code(0);
    let (_, stretches) = shown.stdout.split_once("stretches where").expect("the table of stretches");
    let rows = stretches.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let rows: Vec<_> = rows.filter(|row| row.first().is_some_and(|cell| cell.parse::<u64>().is_ok())).collect();
    assert!(!rows.is_empty(), "{}", shown.stdout);
    for row in rows {
        let seq: usize = row[0].parse().expect("a number");
        let from_s = (stamps_ns[seq] - stamps_ns[0]) as f64 / 1e9;
        assert_eq!(row[2], format!("{from_s:.2}"), "at revolution {seq}: {}", shown.stdout);
    }
}

#[test]
fn an_unreadable_flight_fails_the_comparison() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut damaged = tunnel(20, &Writing { compression: Some(mcap::Compression::Zstd), ..Writing::default() });
    let magic = [0x28, 0xb5, 0x2f, 0xfd]; // of zstd: every chunk is lost
    let places: Vec<usize> = (0..damaged.len() - 4).filter(|&at| damaged[at..at + 4] == magic).collect();
    for at in places {
        damaged[at] ^= 0xff;
    }
    let input = file(folder.path(), "damaged.mcap", &damaged);
    let ran = compare(&input, &["default", "paper"], &[]).expect_code(1);
    assert!(ran.stderr.contains("error: no scan could be read"), "{}", ran.stderr);
    assert!(!ran.stderr.contains("no scan has a return"), "untrue: {}", ran.stderr);
}

/// Compares the shipped flight with what is kept in a folder.
fn golden(folder: &Path, more: &[&str]) -> Ran {
    let (flight, folder) = (shipped_flight().display().to_string(), folder.display().to_string());
    run(["compare", &flight, "--golden", &folder].into_iter().chain(more.iter().copied()))
}

#[test]
fn a_changed_gain_is_named_by_its_stage_against_what_was_kept() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    golden(folder.path(), &[]).expect_code(2); // nothing is kept
    golden(folder.path(), &["--update"]).expect_code(0);
    let same = golden(folder.path(), &[]).expect_code(0).stdout;
    assert!(same.contains("all 141 as kept"), "{same}");

    let xml = folder.path().join("golden.xml");
    let junit = ["--set", "affinity.leak=1.1e-8", "--junit", xml.to_str().expect("a path in UTF-8")];
    let ran = golden(folder.path(), &junit).expect_code(1);
    assert!(ran.stdout.starts_with("revolution 0 differs: affinity: W[2] was "), "{}", ran.stdout);
    assert!(ran.stdout.contains(" of 141 differ: "), "{}", ran.stdout);
    assert!(ran.stderr.contains("leak = 1.1e-8"), "{}", ran.stderr);
    let xml = std::fs::read_to_string(xml).expect("written");
    assert!(xml.contains("tests=\"141\"") && xml.contains("<failure message=\"affinity: W[2] was "), "{xml}");

    let ran =
        golden(folder.path(), &["--set", "kmeans.kind=kmeans++", "--set", "report.min_returns=40"]).expect_code(1);
    assert!(ran.stdout.contains("differs: report: "), "an earlier stage is blamed: {}", ran.stdout);
    let ran = golden(folder.path(), &["--to", "5"]).expect_code(1);
    assert!(ran.stdout.starts_with("revolution 51 differs: it is missing now"), "{}", ran.stdout);
}

#[test]
fn tolerances_are_by_value_stay_at_updates_and_are_checked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let update = |with: &str| golden(folder.path(), &["--with", with, "--update"]).expect_code(0);
    let with = |with: &str, code| golden(folder.path(), &["--with", with]).expect_code(code);
    update("paper");
    let tolerances = folder.path().join("tolerance.json");
    with("paper,spectral.zero_tolerance=1.001e-4", 1);
    let own = r#"{"default": 1e-9, "tolerance": 0.5, "confidence": 0.1}"#;
    std::fs::write(&tolerances, own).expect("a file");
    update("paper");
    assert_eq!(std::fs::read_to_string(&tolerances).expect("there"), own);
    with("paper,spectral.zero_tolerance=1.001e-7", 0);
    std::fs::write(&tolerances, r#"{"eigenvalue": 1}"#).expect("a file");
    let refused = with("paper", 2).stderr;
    assert!(refused.contains("did you mean eigenvalues?"), "{refused}");
}

#[test]
fn a_comparison_begins_with_its_conclusion() {
    let ran = compare(&shipped_flight(), &["default", "paper"], &[]).expect_code(0);
    let first = ran.stdout.lines().next().expect("a line");
    assert!(
        first.starts_with("against default: paper mends 0 and breaks 70 of 141")
            && first.contains("exact McNemar p = "),
        "{first}"
    );
    assert!(
        ran.stdout.contains("default and paper differ in 70 of 141; their confidences follow two rules"),
        "{}",
        ran.stdout
    );
    let json = json(&shipped_flight(), &["default", "paper"]);
    let verdict = &json["verdicts"][0];
    let count = |name: &str| verdict["families"][0][name].as_array().expect("a list").len();
    assert_eq!((count("mended"), count("broken")), (0, 70), "{verdict}");
    assert_eq!(json["comparisons"][0]["surer"]["differ"], 70);
    // Without a truth there is no verdict.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scans: Vec<_> = (0..3).map(tunnel_scan).collect();
    let input = file(folder.path(), "tunnel.mcap", &bytes(&scans, &Writing::default()));
    let ran = compare(&input, &["default", "paper"], &[]).expect_code(0);
    assert!(ran.stdout.starts_with("default and paper differ in "), "{}", ran.stdout);
}
