//! The pages that people read: their figures are the published ones, their links lead somewhere.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::root;

/// Before a paragraph or a table, this comment names the published figures that must stand in it.
const MARK: &str = "\n<!-- figures: ";

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn docs() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("docs")).expect("the folder is there");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect()
}

fn pages() -> Vec<PathBuf> {
    let others = ["README", "ARCHITECTURE", "CONTRIBUTING", "CHANGELOG", "BENCHMARKS", "SECURITY", "recordings/README"];
    others.iter().map(|name| root().join(format!("{name}.md"))).chain(docs()).collect()
}

fn results() -> Value {
    serde_json::from_str(&read(&root().join("docs/results.json"))).expect("JSON")
}

/// The lines of a page that are not code.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    page.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// The numbers in a text, thousands with or without a comma.
fn numbers(text: &str) -> Vec<f64> {
    let part_of_number = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let words = text.split(|c| !part_of_number(c)).map(|word| word.trim_matches(['.', ',']).replace(',', ""));
    words.filter_map(|word| word.parse().ok()).collect()
}

/// The figure with a name such as `simulated.right.all.default`.
fn figure(results: &Value, name: &str) -> Option<f64> {
    name.split('.').try_fold(results, |value, key| value.get(key))?.as_f64()
}

/// Marked figures that do not stand in the block below their mark.
fn contradictions(page: &str, results: &Value) -> Vec<String> {
    let mut found = Vec::new();
    for part in page.split(MARK).skip(1) {
        let (names, below) = part.split_once(" -->\n").expect("a mark ends its line");
        let block = numbers(below.split("\n\n").next().unwrap_or_default());
        for name in names.split_whitespace() {
            match figure(results, name) {
                Some(value) if block.contains(&value) => {}
                Some(value) => found.push(format!("{name} is {value}, which does not stand below its mark")),
                None => found.push(format!("{name} is no figure of results.json")),
            }
        }
    }
    found
}

/// All numbers of the published figures.
fn published(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Object(fields) => fields.values().for_each(|value| published(value, into)),
        Value::Array(values) => values.iter().for_each(|value| published(value, into)),
        _ => into.extend(value.as_f64()),
    }
}

/// Percentages with a decimal, and table cells that are a decimal: those that no published figure equals.
fn unpublished(page: &str, published: &[f64]) -> Vec<String> {
    let mut found = Vec::new();
    for line in prose(page) {
        let cells = line.split('|').skip(1).map(|cell| cell.trim().trim_matches('*'));
        let percentages = line.match_indices(" %").filter_map(|(end, _)| line[..end].rsplit([' ', '(', '*']).next());
        for text in cells.chain(percentages).filter(|text| text.contains('.')) {
            if text.parse().is_ok_and(|value: f64| !published.contains(&value)) {
                found.push(format!("{text}: {line}"));
            }
        }
    }
    found
}

/// As a heading is linked to.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|&c| c.is_alphanumeric() || "-_ ".contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Relative links of the page at `path` that lead nowhere.
fn broken_links(path: &Path) -> Vec<String> {
    let page = read(path);
    let targets = prose(&page).flat_map(|line| line.split("](").skip(1)).filter_map(|rest| rest.split(')').next());
    let mut broken = Vec::new();
    for target in targets.filter(|target| !target.contains("://")) {
        let (file, heading) = target.split_once('#').unwrap_or((target, ""));
        let file = if file.is_empty() { path.to_owned() } else { path.parent().expect("a folder").join(file) };
        let leads = file.exists()
            && (heading.is_empty()
                || prose(&read(&file))
                    .any(|line| line.starts_with('#') && anchor(line.trim_start_matches('#')) == heading));
        if !leads {
            broken.push(format!("{}: {target}", path.display()));
        }
    }
    broken
}

#[test]
fn marked_figures_are_the_published_ones() {
    let results = results();
    for path in pages() {
        let found = contradictions(&read(&path), &results);
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
    }
}

#[test]
fn percentages_in_readme_and_docs_are_published_figures() {
    let mut known = Vec::new();
    published(&results(), &mut known);
    for path in docs().into_iter().chain(["README.md", "CHANGELOG.md"].map(|name| root().join(name))) {
        let found = unpublished(&read(&path), &known);
        assert!(found.is_empty(), "{}: {found:#?}", path.display());
    }
}

#[test]
fn relative_links_lead_to_files_and_headings() {
    let broken: Vec<_> = pages().iter().flat_map(|path| broken_links(path)).collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn the_first_command_of_the_readme_builds_no_rerun() {
    let readme = read(&root().join("README.md"));
    let first = readme.lines().find_map(|line| line.strip_prefix("$ cargo run ")).expect("a first command");
    let (options, _) = first.split_once(" -- ").expect("arguments of the program");
    let mut tree = std::process::Command::new(env!("CARGO"));
    tree.args(["tree", "--locked", "--offline", "--prefix=none", "--edges=normal,build"]);
    tree.args(options.split(' ').filter(|option| *option != "--release")).current_dir(root());
    let out = tree.output().expect("cargo starts");
    let packages = String::from_utf8(out.stdout).expect("UTF-8");
    assert!(packages.contains("crosscut-spectral"), "{}", String::from_utf8_lossy(&out.stderr));
    let of_rerun: Vec<_> = packages.lines().filter(|line| line.starts_with("re") && line.contains("_sdk")).collect();
    assert!(of_rerun.is_empty(), "{of_rerun:?}");
}

#[test]
fn rust_of_the_readme_is_of_an_example_that_compiles() {
    let readme = read(&root().join("README.md"));
    let example = read(&root().join("examples/robot/src/main.rs"));
    let lines: Vec<_> = example.lines().map(str::trim).collect();
    let (_, snippet) = readme.split_once("```rust\n").expect("some Rust");
    for line in snippet.lines().take_while(|line| *line != "```").map(str::trim).filter(|line| !line.is_empty()) {
        assert!(lines.contains(&line), "not in examples/robot: {line}");
    }
}

#[test]
fn a_figure_that_differs_is_found() {
    let results = serde_json::json!({"simulated": {"default": 96.3, "revolutions": 8400}});
    let page = |figure: &str| {
        format!("\n<!-- figures: simulated.default simulated.revolutions -->\nOf 8,400, {figure}.\n\n96.3\n")
    };
    assert!(contradictions(&page("96.3 %"), &results).is_empty());
    assert_eq!(contradictions(&page("96.4 %"), &results).len(), 1);
    assert_eq!(contradictions("\n<!-- figures: simulated.other -->\n96.3\n", &results).len(), 1);

    assert_eq!(unpublished("right in (96.4 %)\n| a | **96.2** | 96.3 |\n```\n1.5 %\n```\n", &[96.3]).len(), 2);
}
