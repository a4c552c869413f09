//! Notes explained by their codes.

use crate::program::crosscut;

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
