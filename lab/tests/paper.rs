//! The program `paper`.

use std::path::Path;
use std::process::Command;

/// The files that the program writes, by name.
fn written(folder: &Path) -> Vec<(String, String)> {
    let ran = Command::new(env!("CARGO_BIN_EXE_paper")).arg(folder).arg("2").status();
    assert!(ran.expect("the program starts").success());
    let entries = std::fs::read_dir(folder).expect("it was made").map(|entry| entry.expect("an entry"));
    let text = |path: &Path| std::fs::read_to_string(path).expect("text");
    let mut files: Vec<_> =
        entries.map(|entry| (entry.file_name().into_string().expect("UTF-8"), text(&entry.path()))).collect();
    files.sort();
    files
}

#[test]
fn the_page_shows_figures_and_tolerances_and_is_reproducible() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = written(&folder.path().join("deep/er"));
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["families.svg", "mine.svg", "paper.md", "random.svg", "tunnel.svg"]);

    let page = &files[2].1;
    for name in names.iter().filter(|name| name.ends_with(".svg")) {
        assert!(page.contains(&format!("]({name})")), "the page does not show {name}");
    }
    assert!(page.contains("not public"), "whose data it is");
    // Two clean scenes 6 m wide are right over many decades, and wrong at 1e-1.
    let row = page.lines().rfind(|line| line.starts_with("| clean6 ")).expect("a row of the last table");
    let cells: Vec<_> = row.split('|').map(str::trim).collect();
    assert_eq!((cells[10], cells[17], cells.len()), ("**100**", "0", 19), "at 1e-8 and 1e-1: {row}");

    assert!(files == written(&folder.path().join("again")), "the same bytes");
}

#[test]
fn a_figure_has_a_coloured_dot_for_every_return() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let random = &written(folder.path())[3].1;
    // The first panel is a dead end of 360 beams with one wall: one path, with a dot for nearly every beam.
    let first = random.lines().find(|line| line.contains("<path")).expect("a wall");
    let dots = first.matches("h0").count();
    assert!((300..=360).contains(&dots) && first.contains("stroke=\"#56b4e9\""), "{dots} dots: {first}");
    let [texts, scales] = ["<text", " m\n</text>"].map(|of| random.matches(of).count());
    assert_eq!((texts - scales, scales), (15, 15), "the count above every panel, and its scale");
}
