//! `crosscut debug`: the dialogue of docs/debugging.md, line by line, and what goes wrong at the prompt.

use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;

use crate::program::{Ran, crosscut, root, shipped_flight};

/// Plays lines to `crosscut debug` on the shipped flight.
fn play(more: &[&str], input: &str) -> Ran {
    let flight = shipped_flight();
    let args = ["debug", flight.to_str().expect("a path in UTF-8")].into_iter().chain(more.iter().copied());
    let mut command = crosscut(args);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = command.spawn().expect("the program starts");
    running.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("the program reads");
    running.wait_with_output().expect("it ends").into()
}

/// The answer to each command, or why it was refused.
fn answers(more: &[&str], commands: &[&str]) -> Vec<Result<String, String>> {
    const LIST: &str = "break"; // answered by one line that is known
    let input: String = commands.iter().map(|command| format!("{command}\n{LIST}\n")).collect();
    let Ran { stdout, stderr, .. } = play(more, &input);
    let (_, answered) = stdout.split_once('\n').expect("a greeting");
    let mut refusals = stderr.lines().filter_map(|line| line.strip_prefix("error: "));
    let answers: Vec<&str> = answered.split_terminator("no break\n").collect();
    assert_eq!(answers.len(), commands.len(), "an answer for each command: {stdout}");
    let answer = |text: &str| match text.trim_end() {
        "" => Err(refusals.next().expect("a refusal").to_owned()),
        text => Ok(text.to_owned()),
    };
    answers.into_iter().map(answer).collect()
}

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

/// The dialogue of the page: each command with what is shown after it.
fn dialogue() -> Vec<(String, String)> {
    let page = std::fs::read_to_string(root().join("docs/debugging.md")).expect("the page is there");
    let mut dialogue: Vec<(String, String)> = Vec::new();
    let mut is_dialogue = false;
    for line in page.lines() {
        if line.starts_with("```") {
            is_dialogue = line == "```text";
        } else if let (true, Some(command)) = (is_dialogue, line.strip_prefix("> ")) {
            dialogue.push((command.to_owned(), String::new()));
        } else if let (true, Some((_, shown))) = (is_dialogue, dialogue.last_mut()) {
            shown.push_str(line);
            shown.push('\n');
        }
    }
    dialogue
}

/// The text without the time that it took.
fn without_time(text: &str) -> String {
    let Some((before, after)) = text.split_once(" answered again in ") else { return text.to_owned() };
    let (_, rest) = after.split_once(" s;").expect("a time");
    format!("{before} answered again in T s;{rest}")
}

#[test]
fn the_dialogue_of_the_page_is_what_the_prompt_shows() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let in_folder = |text: &str| text.replace("/tmp/", &format!("{}/", folder.path().display()));
    let dialogue = dialogue();
    assert!(dialogue.len() > 15, "the page has a dialogue");
    let input: String = dialogue.iter().map(|(command, _)| in_folder(command) + "\n").collect();
    let ran = play(&["--preset", "paper"], &input);
    let (mut stdout, mut stderr) = (ran.stdout.as_str(), ran.stderr.as_str());
    stdout = stdout.split_once('\n').expect("a greeting").1;
    for (command, shown) in &dialogue {
        let shown = in_folder(shown);
        let stream = if shown.starts_with("error: ") { &mut stderr } else { &mut stdout };
        let (said, rest) = stream.split_at(length_of_lines(stream, shown.lines().count()));
        assert_eq!(without_time(said), without_time(&shown), "after {command}");
        *stream = rest;
    }
    assert_eq!((stdout, stderr), ("", ""), "the page shows everything");
    assert_eq!(ran.code, Some(i32::from(dialogue.iter().any(|(_, shown)| shown.starts_with("error: ")))));
}

/// Bytes of the first lines.
fn length_of_lines(text: &str, count: usize) -> usize {
    text.split_inclusive('\n').take(count).map(str::len).sum()
}

#[test]
#[cfg(feature = "rerun")]
fn without_a_viewer_the_session_goes_on() {
    let mut command = crosscut(["debug".as_ref(), shipped_flight().as_os_str(), "--view".as_ref()]);
    command.env("PATH", "").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = command.spawn().expect("the program starts");
    running.stdin.take().expect("a pipe").write_all(b"seek 107\n").expect("the program reads");
    let ran: Ran = running.wait_with_output().expect("it ends").into();
    let ran = ran.expect_code(3);
    assert!(ran.stderr.contains("pip install rerun-sdk"), "{}", ran.stderr);
    assert!(ran.stdout.contains("107 at 10.70 s"), "{}", ran.stdout);
}

#[test]
fn refusals_leave_the_session_as_it_was() {
    let wrong = [
        "seek 9999",
        "seek soon",
        "step one",
        "next never",
        "jump 3",
        "set affinity.sigma=1",
        "set vehicle.width_m=-1",
        "unset a.b",
        "swap report=x",
        "swap spectral=fear",
        "inject W /nowhere.npy",
        "get V x.npy",
        "get W",
        "show everything",
        "why gap 99",
        "diff",
        "differs",
        "run",
        "next differs",
        "set ingest.frame_id=nobody",
    ];
    for line in wrong {
        let found = answers(&[], &["seek 50", "show", line, "show"]);
        assert!(found[2].as_ref().is_err_and(|text| !text.is_empty()), "{line}: {:?}", found[2]);
        assert_eq!(found[1], found[3], "after {line}");
    }
}

#[test]
fn a_line_that_is_no_text_or_has_no_end_is_refused_alone() {
    let long = vec![b'x'; 1 << 20];
    let lines = [&b"seek 3\n\xff\n"[..], &long, b"\nseek 4\n", &long].concat();
    let mut running = crosscut(["debug".as_ref(), shipped_flight().as_os_str()]);
    let running = running.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = running.spawn().expect("it starts");
    running.stdin.take().expect("a pipe").write_all(&lines).expect("it reads");
    let ran = Ran::from(running.wait_with_output().expect("it ends")).expect_code(1);
    assert!(ran.stdout.contains("3 at 0.30 s") && ran.stdout.contains("4 at 0.40 s"), "{}", ran.stdout);
    assert!(ran.stderr.contains("no UTF-8 text"), "{}", ran.stderr);
    assert_eq!(ran.stderr.matches("a line of more than 65536 bytes").count(), 2, "{}", ran.stderr);
}

#[test]
fn labels_that_name_more_clusters_than_returns_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("labels.npy").display().to_string();
    answers(&[], &[&format!("get labels {path}")]);
    for wrong in [4e9, 1e18, f64::NAN, f64::INFINITY, 0.5] {
        let mut file = std::fs::read(&path).expect("written");
        file[192..200].copy_from_slice(&f64::to_le_bytes(wrong));
        std::fs::write(&path, file).expect("a file");
        let found = answers(&[], &[&format!("inject labels {path}")]);
        let refused = found[0].as_ref().is_err_and(|text| text.contains("is no cluster of"));
        assert!(refused, "{wrong}: {found:?}");
    }
}

#[test]
#[cfg(unix)]
fn an_array_that_cannot_be_written_leaves_the_one_that_was_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("w.npy");
    std::fs::write(&path, b"whole").expect("a file");
    // No file of more than a block may be written.
    let script = format!("printf 'get W {}\\n' | (ulimit -f 1; \"$0\" debug \"$1\")", path.display());
    let mut shell = std::process::Command::new("bash");
    shell.args(["-c", &script]).arg(crosscut([""; 0]).get_program()).arg(shipped_flight());
    let ran = Ran::from(shell.output().expect("it starts"));
    assert_ne!(ran.code, Some(0), "{}", ran.stdout);
    assert_eq!(std::fs::read(&path).expect("the file"), b"whole");
}

#[test]
fn a_stage_that_fails_is_told_and_the_next_setting_mends_it() {
    let commands = ["set pipeline.memory_mb=1", "again", "next fails", "unset all", "again"];
    let found = answers(&["--preset", "paper"], &commands);
    let says = |at: usize, text: &str| found[at].as_ref().is_ok_and(|said| said.contains(text));
    assert!(says(0, "memory_mb") && says(1, "; 141 without an answer"), "{found:?}");
    assert!(says(2, "1 at 0.10 s: ") && says(3, "2 walls") && !says(4, "without an answer"), "{found:?}");
}

#[test]
fn what_is_got_and_injected_again_gives_the_same_answer_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    for preset in ["default", "paper"] {
        let mut commands = vec!["seek 107".to_owned(), "hold".to_owned()];
        for what in ["W", "U", "labels"] {
            commands.extend(["get", "inject"].map(|command| format!("{command} {what} {}", path(what))));
        }
        commands.push("diff".to_owned());
        let found = answers(&["--preset", preset], &commands.iter().map(String::as_str).collect::<Vec<_>>());
        let last = found.last().and_then(|last| last.as_ref().ok()).expect("an answer");
        assert!(last.starts_with("report: notes"), "only the notes say that something was injected: {preset}: {last}");
    }
}

#[test]
fn a_changed_w_changes_the_count_and_leaves_the_recording_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("w.npy").display().to_string();
    answers(&["--preset", "paper"], &[&format!("get W {path}")]);
    // Every return on its own: no edge but the diagonal.
    let mut file = std::fs::read(&path).expect("written");
    let n = ((file.len() - 192) / 8).isqrt();
    for at in (0..n * n).filter(|at| at / n != at % n) {
        file[192 + 8 * at..200 + 8 * at].fill(0);
    }
    std::fs::write(&path, file).expect("a file");
    let inject = format!("inject W {path}");
    let found = answers(&["--preset", "paper"], &[&inject, "step", "step -1", "inject off"]);
    let has_k = |at: usize, k: usize| found[at].as_ref().is_ok_and(|said| said.contains(&format!(", k = {k}, ")));
    assert!(has_k(0, n), "{found:?}");
    assert!(has_k(2, n) && has_k(3, 2), "it stays with its revolution: {found:?}");
}

#[test]
fn outputs_do_not_replace_the_flight_and_settings_can_be_used_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = folder.path().join("settings.toml");
    let flight = shipped_flight().display().to_string();
    let written = settings.display().to_string();
    let [get, write_over, write] = [format!("get W {flight}"), format!("write {flight}"), format!("write {written}")];
    let found = answers(&[], &[&get, &write_over, "set vehicle.width_m=0.9", &write]);
    for refused in &found[..2] {
        assert!(refused.as_ref().is_err_and(|text| text.contains("overwritten")), "{refused:?}");
    }
    assert!(Path::new(&written).exists());
    let same = answers(&["--config", &written, "--set", "vehicle.width_m=0.9"], &["settings"]);
    assert_eq!(same, [Ok("as at the start".to_owned())]);
}

#[test]
fn several_settings_in_a_line_are_set_each() {
    let commands = "set report.min_returns=5 affinity.without=[\"slit\",\"doors\"] vehicle.width_m=0.9\nsettings\n";
    let ran = play(&["--preset", "default"], commands).expect_code(0);
    for part in ["report.min_returns = 5", "affinity.without = [\"slit\", \"doors\"]", "vehicle.width_m = 0.9"] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
}

#[test]
fn a_flight_that_cannot_be_read_and_wrong_settings_end_with_their_codes() {
    let run = |args: &[&str]| Ran::from(crosscut(args).stdin(Stdio::null()).output().expect("the program starts"));
    run(&["debug", "nowhere.mcap"]).expect_code(1);
    let flight = shipped_flight().display().to_string();
    run(&["debug", &flight, "--set", "vehicle.width=1"]).expect_code(2);
    run(&["debug", "-"]).expect_code(2);
    run(&["debug", &flight]).expect_code(0);
}

#[cfg(feature = "rerun")]
#[test]
fn a_recording_answers_otherwise_than_the_flight_it_was_made_of() {
    use crate::program::run;

    let folder = tempfile::tempdir().expect("a folder");
    let [rrd, by_flight, by_recording] =
        ["tee.rrd", "a.jsonl", "b.jsonl"].map(|name| folder.path().join(name).display().to_string());
    let flight = shipped_flight().display().to_string();
    run(["run", &flight, "--quiet", "--save", &rrd, "--out", &by_flight]).expect_code(0);
    run(["run", &rrd, "--quiet", "--out", &by_recording]).expect_code(0);
    let read = |path: &str| std::fs::read_to_string(path).expect("results");
    assert!(read(&by_flight) == read(&by_recording), "the lines of results differ");

    let commands = "seek 107\nshow\nhold\nset report.min_returns=5\ndiffers\nset ingest.yaw_rad=0.2\n";
    let debug = |flight: &str| {
        let mut command = crosscut(["debug", flight]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = command.spawn().expect("the program starts");
        running.stdin.take().expect("a pipe").write_all(commands.as_bytes()).expect("the program reads");
        Ran::from(running.wait_with_output().expect("it ends"))
    };
    let recorded = debug(&rrd).expect_code(1);
    assert!(recorded.stderr.contains("needs the file that was flown"), "{}", recorded.stderr);
    let flown = debug(&flight).expect_code(0);
    let of_recording: Vec<&str> = recorded.stdout.lines().collect();
    assert_eq!(flown.stdout.lines().take(of_recording.len()).collect::<Vec<_>>(), of_recording);
}

#[test]
#[cfg(feature = "rerun")]
fn recordings_that_are_cut_off_or_put_together_say_so() {
    use crate::program::run;

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let flight = shipped_flight().display().to_string();
    for (name, to) in [("a.rrd", "5"), ("b.rrd", "6")] {
        run(["run", &flight, "--quiet", "--to", to, "--save", &path(name)]).expect_code(0);
    }
    let bytes = |name: &str| std::fs::read(path(name)).expect("written");
    std::fs::write(path("both.rrd"), [bytes("a.rrd"), bytes("b.rrd")].concat()).expect("written");
    for command in ["debug", "run"] {
        let said = run([command, &path("both.rrd")]).expect_code(2).stderr;
        assert!(said.contains("several recordings: ") && said.contains("one at a time"), "{command}: {said}");
    }
    let whole = bytes("a.rrd");
    for (share, says) in [(0.02, "no revolution is whole"), (0.8, "all is whole up to revolution ")] {
        std::fs::write(path("cut.rrd"), &whole[..(whole.len() as f64 * share) as usize]).expect("written");
        let said = run(["debug", &path("cut.rrd")]).stderr;
        assert!(said.contains("cut off") && said.contains(says), "{share}: {said}");
        let listed = run(["rrd", "ls", &path("cut.rrd")]).expect_code(3).stderr;
        assert!(listed.contains(says) && listed.contains("rerun rrd optimize"), "{share}: {listed}");
    }
}

#[test]
#[cfg(feature = "rerun")]
fn a_recording_is_debugged_with_its_own_settings_unless_a_preset_is_named() {
    use crate::program::run;

    let folder = tempfile::tempdir().expect("a temporary folder");
    let rrd = folder.path().join("paper.rrd").display().to_string();
    let flight = shipped_flight().display().to_string();
    run(["run", &flight, "--quiet", "--preset", "paper", "--save", &rrd]).expect_code(0);
    let shown = |options: &[&str]| {
        let mut command = crosscut([&["debug", &rrd], options].concat());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = command.spawn().expect("the program starts");
        running.stdin.take().expect("a pipe").write_all(b"seek 107\n").expect("the program reads");
        Ran::from(running.wait_with_output().expect("it ends")).expect_code(0).stdout
    };
    assert!(shown(&[]).contains("4 walls"), "paper counts one too many");
    assert!(shown(&["--preset", "default"]).contains("3 walls"), "default is right");
}

#[test]
fn the_command_for_a_wrong_answer_begins_at_it() {
    let flight = shipped_flight();
    let compared =
        crosscut(["compare", flight.to_str().expect("UTF-8"), "--json", "-", "--with", "paper", "--with", "default"]);
    let compared: Ran = { compared }.output().expect("it runs").into();
    let found: Value = serde_json::from_str(&compared.expect_code(0).stdout).expect("JSON");
    let wrong = found["wrong_answers"].as_array().expect("a list");
    let verdict = &found["verdicts"][0];
    let count = verdict["mends"].as_u64().expect("a number") + verdict["breaks"].as_u64().expect("a number");
    assert!(count > 9 && wrong.len() as u64 == count, "{count} commands");
    for of in [&wrong[0], &wrong[wrong.len() - 1]] {
        let command = words(of["command"].as_str().expect("a command"));
        assert_eq!(command[..2], ["crosscut", "debug"]);
        let options: Vec<&str> = command[3..].iter().map(String::as_str).collect();
        let shown = play(&options, "show\n").expect_code(0).stdout;
        assert!(shown.contains(&format!("\n{} at ", of["revolution"])), "{of}: {shown}");
        assert!(shown.contains("truth: "), "{shown}");
    }
}
