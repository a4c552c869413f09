//! `crosscut debug`: the dialogue of docs/debugging.md, line by line, and what goes wrong at the prompt.

use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;

use serde_json::{Value, json};

use crate::program::{Ran, crosscut, lines, root, shipped_flight};

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

/// The results of JSON-RPC requests with these words.
fn play_json(more: &[&str], commands: &[Vec<String>]) -> Vec<Value> {
    let request = |(id, words): (usize, &Vec<String>)| {
        json!({"jsonrpc": "2.0", "id": id, "method": words[0], "params": words[1..]}).to_string() + "\n"
    };
    let input: String = commands.iter().enumerate().map(request).collect();
    let answers = lines(&play(&[more, &["--json"]].concat(), &input).expect_code(0).stdout);
    assert_eq!(answers.len(), commands.len(), "an answer for each request");
    for (id, answer) in answers.iter().enumerate() {
        assert_eq!(answer["id"], id);
    }
    answers
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
fn the_dialogue_of_the_page_is_what_json_says() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let in_folder = |text: &str| text.replace("/tmp/", &format!("{}/", folder.path().display()));
    let dialogue = dialogue();
    let commands: Vec<_> = dialogue.iter().map(|(command, _)| words(&in_folder(command))).collect();
    let answers = play_json(&["--preset", "paper"], &commands);
    for ((command, shown), answer) in dialogue.iter().zip(answers) {
        let shown = in_folder(shown.trim_end());
        match shown.strip_prefix("error: ") {
            Some(refusal) => assert_eq!(answer["error"]["message"], refusal, "after {command}"),
            None => {
                let text = answer["result"]["text"].as_str().unwrap_or_else(|| panic!("{command}: {answer}"));
                assert_eq!(without_time(text), without_time(&shown), "after {command}");
            }
        }
    }
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
        let answers = play_json(&[], &[words("seek 50"), words("show"), words(line), words("show")]);
        assert!(answers[2]["error"]["message"].as_str().is_some_and(|text| !text.is_empty()), "{line}: {}", answers[2]);
        assert_eq!(answers[1]["result"], answers[3]["result"], "after {line}");
    }
}

#[test]
fn lines_that_are_no_requests_are_answered_by_their_code_and_the_session_goes_on() {
    let input = "nonsense\n{\"id\":1}\n{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"jump\"}\n\
                 {\"jsonrpc\":\"2.0\",\"id\":3,\"method\":\"seek\",\"params\":[]}\n\
                 {\"jsonrpc\":\"2.0\",\"method\":\"seek\",\"params\":[5]}\n{\"jsonrpc\":\"2.0\",\"id\":4,\"method\":\"show\"}\n";
    let answers = lines(&play(&["--json"], input).expect_code(0).stdout);
    let codes: Vec<_> = answers.iter().map(|answer| answer["error"]["code"].as_i64()).collect();
    assert_eq!(codes, [Some(-32700), Some(-32600), Some(-32601), Some(-32602), None]);
    assert_eq!(answers[4]["result"]["at"], 5, "a notification is done without an answer");
}

#[test]
fn a_stage_that_fails_is_told_and_the_next_setting_mends_it() {
    let commands = ["set pipeline.memory_mb=1", "again", "next fails", "unset all", "again"];
    let answers = play_json(&["--preset", "paper"], &commands.map(words));
    assert!(answers[0]["result"]["failure"].as_str().is_some_and(|text| text.contains("memory_mb")), "{}", answers[0]);
    assert_eq!(answers[1]["result"]["failed"], answers[1]["result"]["revolutions"]);
    assert_eq!(answers[2]["result"]["at"], 1);
    assert_eq!(
        (&answers[3]["result"]["walls"], &answers[4]["result"]["failed"]),
        (&json!(2), &json!(0)),
        "{}",
        answers[3]
    );
}

#[test]
fn what_is_got_and_injected_again_gives_the_same_answer_to_the_bit() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    for preset in ["default", "paper"] {
        let mut commands = vec![words("seek 107"), words("hold")];
        for what in ["W", "U", "labels"] {
            commands.push(vec!["get".into(), what.into(), path(what)]);
            commands.push(vec!["inject".into(), what.into(), path(what)]);
        }
        commands.push(words("diff"));
        let answers = play_json(&["--preset", preset], &commands);
        let last = answers.last().expect("an answer");
        // Only the notes say that something was injected.
        assert_eq!(last["result"]["field"], "notes[0]", "{preset}: {last}");
    }
}

#[test]
fn a_changed_w_changes_the_count_and_leaves_the_recording_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("w.npy").display().to_string();
    let get = vec!["get".to_owned(), "W".to_owned(), path.clone()];
    play_json(&["--preset", "paper"], &[get]);
    // Every return on its own: no edge but the diagonal.
    let mut file = std::fs::read(&path).expect("written");
    let n = ((file.len() - 192) / 8).isqrt();
    for at in (0..n * n).filter(|at| at / n != at % n) {
        file[192 + 8 * at..200 + 8 * at].fill(0);
    }
    std::fs::write(&path, file).expect("a file");
    let inject = vec!["inject".to_owned(), "W".to_owned(), path];
    let answers = play_json(&["--preset", "paper"], &[inject, words("step"), words("step -1"), words("inject off")]);
    assert_eq!(answers[0]["result"]["k"], n, "{}", answers[0]);
    assert_eq!(
        (&answers[2]["result"]["k"], &answers[3]["result"]["k"]),
        (&json!(n), &json!(2)),
        "it stays with its revolution"
    );
}

#[test]
fn outputs_do_not_replace_the_flight_and_settings_can_be_used_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let settings = folder.path().join("settings.toml");
    let flight = shipped_flight().display().to_string();
    let written = settings.display().to_string();
    let commands = [
        vec!["get".to_owned(), "W".to_owned(), flight.clone()],
        vec!["write".to_owned(), flight],
        words("set vehicle.width_m=0.9"),
        vec!["write".to_owned(), written.clone()],
    ];
    let answers = play_json(&[], &commands);
    for refused in &answers[..2] {
        assert!(refused["error"]["message"].as_str().is_some_and(|text| text.contains("overwritten")), "{refused}");
    }
    assert!(Path::new(&written).exists());
    let same = play_json(&["--config", &written, "--set", "vehicle.width_m=0.9"], &[words("settings")]);
    assert_eq!(same[0]["result"]["text"], "as at the start");
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
    run(["run", &flight, "--quiet", "--save", &rrd, "--results", &by_flight]).expect_code(0);
    run(["run", &rrd, "--quiet", "--results", &by_recording]).expect_code(0);
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
