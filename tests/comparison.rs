//! `crosscut compare`: where configurations differ, and grids of settings.

use std::collections::BTreeMap;
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
    let shown = compare(&shipped_flight(), &["default", "default"], &["--details"]).expect_code(0).stdout;
    for nothing in ["settings that differ: none", "stretches where the walls of default and default differ: none"] {
        assert!(shown.contains(nothing), "{nothing} in:\n{shown}");
    }
}

#[test]
fn a_flight_that_is_given_twice_counts_once() {
    let flight = shipped_flight().display().to_string();
    let twice = run(["compare", &flight, &flight, "--with", "default", "--json", "-"]).expect_code(0);
    let once = run(["compare", &flight, "--with", "default", "--json", "-"]).expect_code(0);
    assert!(twice.stderr.contains("was given twice and counts once"), "{}", twice.stderr);
    let figures = |ran: &Ran| {
        serde_json::from_str::<Value>(&ran.stdout).expect("JSON")["all"][0]["figures"]["revolutions"].clone()
    };
    assert_eq!(figures(&twice), figures(&once));
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
    let ran = compare(&shipped_flight(), &["paper", "paper,affinity.sigma_per_m2=3,kmeans.seed=7"], &["--details"])
        .expect_code(0);
    let rows: Vec<Vec<_>> = ran.stdout.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(rows.contains(&vec!["affinity.sigma_per_m2", "1.5", "3.0"]), "{}", ran.stdout);
    assert!(rows.contains(&vec!["kmeans.seed", "0", "7"]), "{}", ran.stdout);
    let settings =
        rows.iter().skip_while(|row| row.first() != Some(&"setting")).skip(1).take_while(|row| !row.is_empty());
    let settings = settings.count();
    assert_eq!(settings, 2, "settings that are the same must not be shown: {}", ran.stdout);
}

#[test]
fn a_failing_configuration_is_named_and_the_others_are_compared() {
    // A dense W of 342 returns and its working memory need more than 2 MB.
    let small = ["default", "paper,pipeline.memory_mb=2", "threshold"];
    let ran = compare(&shipped_flight(), &small, &["--json", "-"]).expect_code(1);
    assert!(
        ran.stderr.contains("error: paper,pipeline.memory_mb=2: ") && ran.stderr.contains("failed on revolution 0: "),
        "{}",
        ran.stderr
    );
    let found: Value = serde_json::from_str(&ran.stdout).expect("the output is JSON");
    let compared = |other: usize| found["comparisons"][other]["figures"]["same_count"]["of"].clone();
    assert_eq!([compared(0), compared(1)], [0, 141]);
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
    let again = [flight.to_str().expect("a path in UTF-8"), "--join"];
    let twice = compare(&flight, &["default", "default"], &again).expect_code(0);
    assert!(twice.stderr.contains("note: time goes back at 1 scan;"), "{}", twice.stderr);
    let once = compare(&flight, &["default", "default"], &[]).expect_code(0);
    assert!(!once.stderr.contains("goes back"), "{}", once.stderr);
}

#[test]
fn one_configuration_or_an_unknown_one_is_wrong_usage() {
    let flight = shipped_flight();
    let refused = |with: &[&str], more: &[&str]| compare(&flight, with, more).expect_code(2).stderr;
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
    let shown =
        compare(&flight, &["default", "paper"], &["--from", "5.02", "--every", "4", "--details"]).expect_code(0);
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

#[test]
fn a_comparison_begins_with_its_conclusion() {
    let ran = compare(&shipped_flight(), &["default", "paper"], &[]).expect_code(0);
    let first = ran.stdout.lines().next().expect("a line");
    assert!(
        first.starts_with("against default: paper mends 0 and breaks 70 of 141")
            && first.contains("exact McNemar p = "),
        "{first}"
    );
    let details = compare(&shipped_flight(), &["default", "paper"], &["--details"]).expect_code(0).stdout;
    assert!(details.contains("default and paper differ in 70 of 141; their confidences follow two rules"), "{details}");
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
    let alone = compare(&input, &["default"], &[]).expect_code(2).stderr;
    assert!(alone.contains("there is no truth (/truth) in ") && alone.contains("name two"), "{alone}");
}

/// The cells of a CSV file without quotes, by row and column.
fn cells(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    lines.map(|cells| header.iter().cloned().zip(cells).collect()).collect()
}

#[test]
fn a_grid_is_every_combination_and_its_rows_are_those_of_single_configurations() {
    let grid = ["--grid", "report.min_returns=1,3", "--grid", "vehicle.width_m=0.6,1.2", "--quiet", "--csv", "-"];
    // Names of single settings have no comma, which would be quoted.
    let rows = cells(&compare(&shipped_flight(), &[], &grid[2..]).expect_code(0).stdout);
    let values: Vec<&str> = rows.iter().map(|row| row["vehicle.width_m"].as_str()).collect();
    assert_eq!((values, rows[1]["configuration"].as_str()), (vec!["0.6", "1.2"], "width_m=1.2"));
    let with = ["default", "default,vehicle.width_m=1.2"];
    let alone = json(&shipped_flight(), &with);
    for (row, result) in rows.iter().zip(alone["all"].as_array().expect("configurations")) {
        let share = result["figures"]["right"]["share"].as_f64().expect("a share");
        assert_eq!(row["right"].parse(), Ok(share), "{row:?}");
        assert_eq!((row["revolutions"].as_str(), row["failed"].as_str()), ("141", "0"));
    }
    let by_both = compare(&shipped_flight(), &["a=paper", "b=default"], &grid).expect_code(0).stdout;
    assert_eq!(by_both.lines().count(), 1 + 2 * 4);
    assert!(by_both.contains("tee,\"b,min_returns=3,width_m=1.2\",3,1.2,141,"), "{by_both}");
    let shown = compare(&shipped_flight(), &["paper"], &grid[..2]).expect_code(0).stdout;
    assert!(
        shown.starts_with("against paper,min_returns=1: paper,min_returns=3 mends 32 and breaks 0 of 141"),
        "{shown}"
    );
    let preset = compare(&shipped_flight(), &[], &["--grid", "affinity.sigma=1,2"]).expect_code(2).stderr;
    assert!(preset.contains("--grid at affinity.sigma=1: "), "{preset}");
}

#[test]
fn files_have_the_same_bytes_whenever_flights_end() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flights: Vec<_> = (0..4).map(|number| folder.path().join(format!("flight{number}.mcap"))).collect();
    for (number, flight) in flights.iter().enumerate() {
        std::fs::write(flight, tunnel(3 + 20 * (number as u64 % 2), &Writing::default())).expect("written");
    }
    let made = |number: usize| {
        let at = |name: &str| folder.path().join(format!("{name}{number}")).display().to_string();
        let (json, csv) = (at("json"), at("csv"));
        let more = ["--json", &json, "--csv", &csv, "--quiet", "--details"];
        compare(folder.path(), &["default", "threshold"], &more).expect_code(0);
        [json, csv].map(|path| std::fs::read(path).expect("written"))
    };
    let first = made(0);
    assert_eq!(made(1), first);
    let rows = String::from_utf8(first[1].clone()).expect("text");
    let names: Vec<&str> = rows.lines().skip(1).step_by(2).filter_map(|row| row.split(',').next()).collect();
    assert_eq!(names, ["flight0", "flight1", "flight2", "flight3"]);
}

#[test]
fn what_comes_as_it_comes_is_compared_on_the_same_scans() {
    let compared = |with: &[&str]| {
        let with = with.iter().flat_map(|name| ["--with", name]);
        let mut command = crosscut(["compare", "-", "--json", "-"].into_iter().chain(with));
        command.stdin(std::fs::File::open(shipped_flight()).expect("it ships"));
        Ran::from(command.output().expect("it runs"))
    };
    let with = ["default", "default,affinity.kind=threshold"];
    let found = compared(&with).expect_code(0);
    let found: Value = serde_json::from_str(&found.stdout).expect("JSON");
    let of_file = json(&shipped_flight(), &with)["comparisons"].clone();
    let figures = |of: &Value| ["same_count", "same_walls", "returns_alike"].map(|name| of[0]["figures"][name].clone());
    assert_eq!(figures(&found["comparisons"]), figures(&of_file));
    let once = compared(&["default", "paper"]).expect_code(0).stderr;
    assert!(once.contains("ingest.deskew=false of paper has no effect"), "{once}");
    let followed = compare(&shipped_flight(), &with, &["--follow", "--json", "-"]).expect_code(0);
    let followed: Value = serde_json::from_str(&followed.stdout).expect("JSON");
    assert_eq!(figures(&followed["comparisons"]), figures(&of_file));
}

#[cfg(feature = "rerun")]
#[test]
fn a_recording_is_answered_and_compared_again_with_other_settings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rrd = folder.path().join("tee.rrd");
    let (flight, saved) = (shipped_flight().display().to_string(), rrd.display().to_string());
    run(["run", &flight, "--quiet", "--preset", "paper", "--save", &saved]).expect_code(0);
    let zeros = "spectral.zero_tolerance=1e-8";
    let shown = compare(&rrd, &[&saved, &format!("zeros={saved},{zeros}")], &[]).expect_code(0).stdout;
    assert!(shown.contains("zeros mends 1 and breaks 66 of 141"), "{shown}");
    let labels = |input: &Path| {
        let (ran, lines) = results_of(input, &["--preset", "paper", "--set", zeros]);
        ran.expect_code(0);
        lines.iter().map(|line| line["labels"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(labels(&rrd), labels(&shipped_flight()));
}
