//! `crosscut report`: a flight as one page.

use std::path::Path;

use crate::program::{column, results_of, run, shipped_flight};

#[test]
fn the_page_shows_the_flight_and_refers_to_nothing_outside() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let named = folder.path().join("a<b>&c.mcap");
    std::fs::copy(shipped_flight(), &named).expect("copied");
    let out = folder.path().join("flight.html");
    let said = run([Path::new("report"), &named, Path::new("--out"), &out]).expect_code(0).stderr;
    assert!(said.contains("1 junction: 1 tee; "), "{said}");
    let page = std::fs::read_to_string(&out).expect("written");
    for expected in [
        "<title>a&lt;b&gt;&amp;c.mcap</title>",
        "<h2>Summary</h2>",
        "<h2>Against the truth in the recording</h2>",
        "<h2>Over time</h2>",
        "<h2>Map</h2>",
        "<b>tee</b> · node 0 of the map",
        "[affinity]",
    ] {
        assert!(page.contains(expected), "{expected}");
    }
    assert!(!page.contains("<script") && !page.contains("<img") && !page.contains("@import"));
    let outside =
        page.split(['"', '\'', '(', ')']).filter(|text| text.starts_with("http") && !text.contains("www.w3.org"));
    assert_eq!(outside.count(), 0, "addresses");
    assert_eq!(page.matches("<section ").count(), page.matches("</section>").count());
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
}

#[test]
fn a_page_is_html_and_never_replaces_the_flight() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let other = folder.path().join("flight.pdf");
    let refused = run([Path::new("report"), &shipped_flight(), Path::new("--out"), &other]).expect_code(2).stderr;
    assert!(refused.contains("FILE.html"), "{refused}");
    let flight = folder.path().join("flight.html");
    std::fs::copy(shipped_flight(), &flight).expect("copied");
    let refused = run([Path::new("report"), &flight, Path::new("--out"), &flight]).expect_code(2).stderr;
    assert!(refused.contains("would be overwritten"), "{refused}");
    run([Path::new("report"), Path::new("missing.mcap"), Path::new("--out"), &folder.path().join("m.html")])
        .expect_code(1);
}

#[test]
fn every_count_that_flickers_is_marked_with_its_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("flight.html");
    let flight = shipped_flight();
    run([Path::new("report"), &flight, Path::new("--preset=paper"), Path::new("--out"), &out]).expect_code(0);
    let flips = count_flips(&column(&results_of(&flight, &["--preset", "paper"]).1, "junctions"));
    assert!(flips > 0, "the paper's rule wavers on this flight");
    let page = std::fs::read_to_string(&out).expect("written");
    assert!(page.contains(&format!("Look at the {flips} (")), "{page:.2000}");
    let (_, over_time) = page.split_once("<h2>Over time</h2>").expect("a section");
    let (drawn, _) = over_time.split_once("</svg>").expect("a picture");
    assert_eq!(drawn.matches("<circle").count(), flips);
    assert_eq!(drawn.matches(" around it; ").count(), flips, "reasons");
    assert!(["walls", "margin", "confidence"].iter().all(|lane| drawn.contains(lane)));
}

/// Number of counts that differ from the count of more than half of their neighbours, five on either side.
fn count_flips(counts: &[u64]) -> usize {
    let differs = |at: usize| {
        let around = at.saturating_sub(5)..(at + 6).min(counts.len());
        let neighbours: Vec<u64> = around.filter(|&other| other != at).map(|other| counts[other]).collect();
        let same = |count: u64| neighbours.iter().filter(|&&other| other == count).count();
        neighbours.iter().any(|&count| count != counts[at] && 2 * same(count) > neighbours.len())
    };
    (0..counts.len()).filter(|&at| differs(at)).count()
}
