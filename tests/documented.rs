//! What the pages show is what the program prints: blocks marked `console` are run, line by line, as a reader would.

use std::path::Path;
use std::process::Command;

use crate::program::root;

/// A line that stands for any lines.
const ANYTHING: &str = "…";

/// A command of a page with the output that the page shows.
#[derive(Debug, Default)]
struct Step {
    command: String,
    shown: Vec<String>,
}

/// The commands of all `console` blocks of a page, in their order.
fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let (mut in_block, mut continues) = (false, false);
    for line in page.lines() {
        match (line, steps.last_mut()) {
            ("```console", _) => in_block = true,
            ("```", _) => in_block = false,
            _ if !in_block => {}
            (rest, Some(step)) if continues => {
                step.command = format!("{} {}", step.command.trim_end_matches('\\'), rest.trim());
                continues = rest.ends_with('\\');
            }
            (line, last) => match (line.strip_prefix("$ "), last) {
                (Some(command), _) => {
                    steps.push(Step { command: command.to_owned(), shown: Vec::new() });
                    continues = command.ends_with('\\');
                }
                (None, Some(step)) => step.shown.push(line.to_owned()),
                (None, None) => {}
            },
        }
    }
    steps
}

/// The lines of output without what differs from run to run and from machine to machine: times and rates. Blank lines and
/// blanks at the ends of lines do not count.
fn lasting(text: &str) -> Vec<String> {
    let units = ["s", "ms", "s)", "a", "s,", "ms,", "ms;", "min"];
    let mut lines = Vec::new();
    for line in text.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let is_time = |at: usize| {
            let number = words[at].trim_start_matches('(').parse::<f64>().is_ok();
            number && words.get(at + 1).is_some_and(|unit| units.contains(unit))
        };
        let kept: Vec<_> = (0..words.len()).map(|at| if is_time(at) { "TIME" } else { words[at] }).collect();
        if !kept.is_empty() {
            lines.push(kept.join(" "));
        }
    }
    lines
}

/// Whether the lines are the shown ones, of which some may stand for any.
fn agrees(shown: &[String], printed: &[String]) -> bool {
    match shown.split_first() {
        None => printed.is_empty(),
        Some((first, rest)) if first == ANYTHING => (0..=printed.len()).any(|from| agrees(rest, &printed[from..])),
        Some((first, rest)) => printed.first() == Some(first) && agrees(rest, &printed[1..]),
    }
}

/// Runs a line of a shell in `folder`, where `crosscut` is the program under test, and returns all that it prints.
fn printed(line: &str, folder: &Path) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_crosscut")).parent().expect("a folder");
    let path = std::env::var("PATH").expect("a path");
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("({line}) 2>&1")]).current_dir(folder);
    shell.env("PATH", format!("{}:{path}", program.display())).env("HOME", folder).env_remove("CROSSCUT_CONFIG");
    let out = shell.output().expect("a shell");
    assert!(out.status.success(), "{line}: {}\n{}", out.status, String::from_utf8_lossy(&out.stdout));
    String::from_utf8(out.stdout).expect("UTF-8")
}

/// The line with the program under test in place of one that a reader would build first.
fn without_cargo(command: &str) -> String {
    match command.split_once(" -- ") {
        Some((build, arguments)) if build.starts_with("cargo run") => format!("crosscut {arguments}"),
        _ => command.to_owned(),
    }
}

fn follow(page: &str) {
    let text = std::fs::read_to_string(root().join(page)).expect("the page");
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::create_dir(folder.path().join("recordings")).expect("created");
    let flight = "recordings/tee.mcap";
    std::fs::copy(root().join(flight), folder.path().join(flight)).expect("copied");
    let steps = steps(&text);
    assert!(!steps.is_empty(), "{page} has no block to run");
    for step in steps {
        if !cfg!(feature = "rerun") && step.command.contains(".rrd") {
            println!("skipped, as this build makes no recordings: {}", step.command);
            continue;
        }
        let printed = printed(&without_cargo(&step.command), folder.path());
        let shown = lasting(&step.shown.join("\n"));
        let lines = lasting(&printed);
        assert!(
            agrees(&shown, &lines),
            "{page}: $ {}\n{printed}\nis not what the page shows:\n{shown:#?}",
            step.command
        );
    }
}

#[test]
fn the_readme_shows_what_the_program_prints() {
    follow("README.md");
}

#[test]
fn the_tutorial_shows_what_the_program_prints() {
    follow("docs/tutorial.md");
}

#[test]
fn the_reference_is_that_of_this_program() {
    let mut script = Command::new(root().join("lab/reference"));
    let made = script.arg(env!("CARGO_BIN_EXE_crosscut")).output().expect("the script starts");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let page = std::fs::read_to_string(root().join("docs/reference.md")).expect("the page");
    let made = String::from_utf8(made.stdout).expect("UTF-8");
    let differs = page.lines().zip(made.lines()).find(|(page, made)| page != made);
    assert!(page == made, "`lab/make reference` makes docs/reference.md; first difference: {differs:?}");
}

#[test]
fn a_page_that_shows_something_else_is_found() {
    let lines = |text: &str| lasting(text);
    assert!(agrees(&lines("a 0.3 s\n…\nz"), &lines("a 12 s\nb\nc\nz")));
    assert!(!agrees(&lines("a\n…\nz"), &lines("a\nb")));
    assert!(!agrees(&lines("3 walls"), &lines("4 walls")));
    let steps = steps("```console\n$ one \\\n  two\nout\n```\n$ three\n");
    assert_eq!((steps.len(), &*steps[0].command, &*steps[0].shown), (1, "one  two", &["out".to_owned()][..]));
}
