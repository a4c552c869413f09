//! Notes explained by their codes.

use std::path::Path;

use crosscut_stage::NoteCode;

use crate::program::{crosscut, root};

#[test]
fn the_page_of_notes_is_what_the_program_prints() {
    let printed = crosscut(["info", "--note", "all"]).output().expect("the program runs");
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/notes.md")).expect("the page");
    let printed = String::from_utf8(printed.stdout).expect("text");
    assert!(printed == page, "docs/notes.md is not the output of `crosscut info --note all`");
}

#[test]
fn a_code_is_explained_and_an_unknown_one_is_a_usage_error() {
    let output = |code| crosscut(["info", "--note", code]).output().expect("the program runs");
    let known = output("n082");
    assert!(known.status.success() && String::from_utf8_lossy(&known.stdout).contains("## N082"), "{known:?}");
    let unknown = output("N000");
    assert_eq!(unknown.status.code(), Some(2), "{unknown:?}");
}

/// Where notes begin in the sources of the crates that make them.
const MAKES_NOTE: [&str; 5] = ["notes.add(", "notes.push(", "notes.extend(", "note(", "Some("];
/// The files whose notes are what a function returns.
const RETURN_NOTES: [&str; 2] = ["ingest/src/clock.rs", "flight/src/pose.rs"];
const MAKE_NOTES: [&str; 9] =
    ["affinity", "debugger", "flight", "ingest", "kmeans", "recorder", "report", "sensor", "spectral"];

#[test]
fn every_note_in_the_sources_has_a_code() {
    let crates = root().join("crates");
    let mut notes = Vec::new();
    for name in MAKE_NOTES {
        add_notes(&crates.join(name).join("src"), &mut notes);
    }
    let without: Vec<&String> = notes.iter().filter(|note| NoteCode::of_note(note).is_none()).collect();
    assert!(without.is_empty(), "without a code: {without:#?}");
    let codes: std::collections::BTreeSet<&str> =
        notes.iter().filter_map(|note| NoteCode::of_note(note)).map(|entry| entry.code).collect();
    assert!(codes.len() > 60, "only {} kinds of notes were found", codes.len());
}

/// Adds the notes of all sources in `folder`, with a 3 in place of what is filled in.
fn add_notes(folder: &Path, notes: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("sources").flatten() {
        let path = entry.path();
        if path.is_dir() {
            add_notes(&path, notes);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = std::fs::read_to_string(&path).expect("a source");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let returns = RETURN_NOTES.iter().any(|file| path.ends_with(file));
            for start in MAKES_NOTE.iter().filter(|start| returns || **start != "Some(") {
                notes.extend(code.split(start).skip(1).filter_map(note_in));
            }
        }
    }
}

/// The sentence in the brackets that were just opened, if one is written there.
fn note_in(text: &str) -> Option<String> {
    let mut depth = 1;
    let end = text.find(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth == 0
    })?;
    let quoted = text[..end].split('"').skip(1).step_by(2);
    let sentence = |text: &str| {
        let pieces = text.split(['{', '}']).enumerate();
        let filled: String = pieces.map(|(at, piece)| if at % 2 == 0 { piece } else { "3" }).collect();
        filled.replace('\\', " ").split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let is_sentence = |text: &String| text.split(' ').filter(|word| word.starts_with(char::is_alphabetic)).count() > 2;
    quoted.map(sentence).find(is_sentence)
}
