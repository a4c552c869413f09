//! Wrong usage and configuration are refused before anything runs (exit code 2).

use crate::program::{Ran, crosscut, run, shipped_flight};

#[test]
fn the_printed_configuration_is_a_configuration_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Characters that TOML escapes differently from Rust, and some that it does not escape.
    let frame_id = "ingest.frame_id=a \"b\" \\ \u{7}\u{200d}\u{e9}";
    let set = ["--set", "affinity.sigma_per_m2=2.5", "--set", frame_id];
    let printed = run([&["config", "--preset", "paper"][..], &set].concat()).expect_code(0).stdout;
    let path = crate::flight::file(folder.path(), "mine.toml", printed.as_bytes());
    let again = run(["config".as_ref(), "--config".as_ref(), path.as_os_str()]).expect_code(0).stdout;
    assert!(again.contains("sigma_per_m2 = 2.5"), "{again}");
    let values = |text: &str| text.lines().filter(|l| !l.starts_with('#')).map(value).collect::<Vec<_>>().join("\n");
    assert_eq!(values(&again), values(&printed));
}

/// A line of configuration without its comment, which names the layer.
fn value(line: &str) -> String {
    line.split("  #").next().unwrap_or_default().to_owned()
}

#[test]
fn unknown_names_and_bad_values_are_refused_with_suggestions() {
    let input = shipped_flight();
    let refused = |more: &[&str]| {
        let args = [&["run", input.to_str().expect("a path in UTF-8")], more].concat();
        run(args).expect_code(2).stderr
    };
    assert!(refused(&["--preset", "paper", "--set", "affinity.sigma=1"]).contains("did you mean sigma_per_m2?"));
    assert!(refused(&["--set", "affinity.kind=rfb"]).contains("did you mean rbf? there are: "));
    let kinds = refused(&["--set", "spectral.kind=bogus"]);
    assert!(["faer", "blocks", "slicing"].iter().all(|kind| kinds.contains(kind)), "{kinds}");
    assert!(refused(&["--set", "ingest.yaw_rad=up"]).contains("a number in"));
    assert!(refused(&["--preset", "papper"]).contains("did you mean paper?"));
    assert!(refused(&["--config", "/nowhere/mine.toml"]).contains("/nowhere/mine.toml"));
    let blind = refused(&["--set", "ingest.min_range_m=10", "--set", "ingest.max_range_m=5"]);
    assert!(blind.contains("no return would be left"), "{blind}");
    assert!(refused(&["--rate", "0"]).contains("above 0"));
    assert!(refused(&["--from", "3", "--to", "2"]).contains("--from 3"));
}

#[test]
fn an_option_that_would_change_nothing_is_refused() {
    let ran = run(["simulate", "tee", "--split", "dev", "--out", "nowhere"]).expect_code(2);
    assert!(ran.stderr.contains("--split"), "{}", ran.stderr);
}

#[test]
fn what_was_typed_before_is_answered_with_what_to_type_now() {
    for (command, instead) in [
        ("evaluate scenes/ --with paper", "`evaluate` is no longer a command; type: crosscut compare FILES..."),
        ("map x -o x.svg", "`map` is no longer a command; type: crosscut run FLIGHT --map FILE.svg"),
        ("run x --results=x.jsonl", "`--results` is no longer an option; type: -o FILE.jsonl"),
        ("run x --save x.rrd --detail light", "type: --set recording.detail=light"),
        ("compare zenoh://robot/scan --domain 3", "type: 'zenoh://HOST/TOPIC?domain=N'"),
        ("run x --layout speed", "type: crosscut view FLIGHT.rrd --layout PAGE"),
        ("view x.rrd --with x.mcap", "type: --beside FLIGHT.mcap"),
        ("debug x --json", "type: lines of commands to standard input"),
        ("simulate tee --no-odometry -o x.mcap", "type: --drift none"),
        ("explore loops --count 3", "type: --seed FIRST..LAST"),
        ("rrd get x.rrd /log --revolution 3 -o -", "type: --at REVOLUTION"),
    ] {
        let said = run(command.split(' ')).expect_code(2).stderr;
        assert!(said.contains(instead), "{command}: {said}");
    }
    let flight = shipped_flight().display().to_string();
    let said = run([&flight]).expect_code(2).stderr;
    assert!(said.contains(&format!("is a file; type: crosscut run {flight}")), "{said}");
    let said = run(["view", "x.rrd", "--layout", "sped"]).expect_code(2).stderr;
    assert!(!said.contains("no longer"), "an option that there is: {said}");
}

#[test]
fn output_names_of_another_format_are_refused() {
    let input = shipped_flight();
    let refused =
        |more: [&str; 2]| run([&["run", input.to_str().expect("UTF-8")][..], &more].concat()).expect_code(2).stderr;
    assert!(refused(["--save", "-"]).contains("not standard output"));
    assert!(refused(["--save", "flight.mcap"]).contains("FLIGHT.rrd"));
    let said = run(["simulate", "tee", "--out", "flight.rrd"]).expect_code(2).stderr;
    assert!(said.contains("FLIGHT.mcap"), "{said}");
}

#[cfg(not(feature = "rerun"))]
#[test]
fn a_build_without_recordings_names_the_line_that_brings_them() {
    let flight = shipped_flight().display().to_string();
    for asked in [&["run", &flight, "--save", "tee.rrd"][..], &["run", &flight, "--view"], &["view", "tee.rrd"]] {
        let refused = run(asked).expect_code(2).stderr;
        assert!(refused.contains("`cargo install --locked --path apps/crosscut`"), "{refused}");
    }
}

#[test]
fn numbers_that_are_refused_say_what_they_must_be() {
    for (command, says) in [
        ("run x --every 0", "a whole number from 1 on"),
        ("run x --every -1", "a whole number from 1 on"),
        ("explore loops --seed 3..1", "FIRST..LAST"),
        ("simulate tee --drift -1", "from 0 to 0.5"),
        ("simulate tee --seed -1", "a whole number from 0 on"),
        ("debug x --at -3", "a whole number from 0 on"),
        ("view x --at -3", "a whole number from 0 on"),
        ("compare x --grid vehicle.width_m=0.6,0.60", "vehicle.width_m has the value 0.60 twice"),
        ("config --set affinity.kind=python:bad", "python:MODULE.FUNCTION"),
    ] {
        let said = run(command.split(' ')).expect_code(2).stderr;
        assert!(said.contains(says), "{command}: {said}");
    }
}

#[test]
fn help_explains_itself() {
    for command in ["help", "help --help", "help -h"] {
        assert!(run(command.split(' ')).expect_code(0).stdout.contains("Usage: crosscut"), "{command}");
    }
}

#[test]
fn crosscut_toml_applies_below_its_folder_and_above_the_preset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let below = folder.path().join("a/b");
    std::fs::create_dir_all(&below).expect("created");
    let found = crate::flight::file(folder.path(), "crosscut.toml", b"[vehicle]\nwidth_m = 1.1\n");
    let width = |more: &[&str], variable: Option<&str>| {
        let mut command = crosscut([&["config"][..], more].concat());
        command.current_dir(&below).env_remove("CROSSCUT_CONFIG");
        variable.map(|file| command.env("CROSSCUT_CONFIG", file));
        let ran = Ran::from(command.output().expect("the program starts")).expect_code(0);
        ran.stdout.lines().find(|line| line.starts_with("width_m")).map(str::to_owned).expect("a line")
    };
    assert_eq!(width(&[], None), format!("width_m = 1.1  # {}", found.display()));
    assert!(width(&["--set", "vehicle.width_m=0.9"], None).starts_with("width_m = 0.9"));
    assert!(width(&[], Some("")).starts_with("width_m = 0.6"), "an empty variable looks for no file");
    let named = crate::flight::file(folder.path(), "other.toml", b"[vehicle]\nwidth_m = 2.0\n");
    assert!(width(&[], named.to_str()).starts_with("width_m = 2.0"));
    let mut command = crosscut(["info", shipped_flight().to_str().expect("UTF-8")]);
    let ran = Ran::from(command.current_dir(&below).output().expect("the program starts")).expect_code(0);
    assert!(ran.stderr.contains(&format!("settings of {}", found.display())), "{}", ran.stderr);
}

#[test]
fn an_angle_in_degrees_is_refused_with_its_radians() {
    let ran = run(["config", "--set", "csv.first_rad=-135"]).expect_code(2);
    assert!(ran.stderr.contains("; -135 degrees are -2.3562"), "{}", ran.stderr);
}

#[test]
#[cfg(unix)]
fn a_first_thread_with_a_small_stack_is_enough() {
    let mut shell = std::process::Command::new("bash");
    shell.args(["-c", "ulimit -s 64 && \"$0\" run \"$1\" --preset paper --quiet"]);
    let ran = shell.arg(crosscut([""; 0]).get_program()).arg(shipped_flight()).output().expect("it starts");
    Ran::from(ran).expect_code(0);
}

#[test]
#[cfg(unix)]
fn settings_that_anybody_may_write_are_not_taken_and_limits_are_not_raised_unasked() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = shipped_flight();
    let info = |more: &[&str]| {
        let mut command = crosscut([&["info", flight.to_str().expect("UTF-8")][..], more].concat());
        Ran::from(command.current_dir(folder.path()).env_remove("CROSSCUT_CONFIG").output().expect("it starts"))
    };
    let found = crate::flight::file(folder.path(), "crosscut.toml", b"[vehicle]\nwidth_m = -1\n");
    std::fs::set_permissions(&found, std::fs::Permissions::from_mode(0o666)).expect("ours");
    let said = info(&[]).expect_code(0).stderr;
    assert!(said.contains("not taken; --config"), "{said}");
    assert!(info(&["--config", "crosscut.toml"]).expect_code(2).stderr.contains("width_m"));
    std::fs::set_permissions(&found, std::fs::Permissions::from_mode(0o644)).expect("ours");
    assert!(info(&[]).expect_code(2).stderr.contains("width_m"));
    std::fs::write(&found, "[pipeline]\nmemory_mb = 8192\n").expect("ours");
    assert!(info(&[]).expect_code(2).stderr.contains("at most 4096 in a file that is found"));
    std::fs::write(&found, "a = 1\n".repeat(200_000)).expect("ours");
    assert!(info(&[]).expect_code(0).stderr.contains("larger than the 1 MiB"));
    std::fs::write(&found, "[pipeline]\nmemory_mb = 1024\n").expect("ours");
    info(&[]).expect_code(0);
}

#[test]
#[cfg(unix)]
fn a_tilde_that_the_shell_left_is_the_home_folder() {
    let home = tempfile::tempdir().expect("a temporary folder");
    let mut command = crosscut(["run", shipped_flight().to_str().expect("UTF-8"), "--out=~/lines.jsonl"]);
    Ran::from(command.env("HOME", home.path()).output().expect("the program starts")).expect_code(0);
    assert!(home.path().join("lines.jsonl").is_file());
}

#[test]
fn info_as_json_says_what_the_text_says() {
    let input = shipped_flight();
    let ran = run(["info", input.to_str().expect("UTF-8"), "--json", "-"]).expect_code(0);
    let info: serde_json::Value = serde_json::from_str(&ran.stdout).expect("JSON alone");
    let topics = info["recordings"][0]["topics"].as_array().expect("topics");
    let scans = topics.iter().find(|topic| topic["name"] == "/scan").expect("the scans");
    assert_eq!((&scans["messages"], &scans["first_scan"]["beams"]), (&141.into(), &360.into()));
    assert!(info["next"].as_str().is_some_and(|line| line.starts_with("crosscut run ")), "{info}");
}

#[test]
fn completions_and_pages_for_man_name_every_option_of_run() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = run(["completions", "bash"]).expect_code(0).stdout;
    run(["man".as_ref(), folder.path().as_os_str()]).expect_code(0);
    let page = std::fs::read_to_string(folder.path().join("crosscut-run.1")).expect("a page");
    for option in ["out", "preset", "save", "follow"] {
        assert!(script.contains(&format!("--{option}")), "no --{option} in the completions");
        assert!(page.contains(option), "no {option} on the page");
    }
}
