//! The page: its sections in order.

use crosscut_detector::Config;
use crosscut_evaluate::tables::Table;
use crosscut_evaluate::{AROUND, Evaluation};
use crosscut_pipeline::End;
use crosscut_stage::{SURE, counted};

use super::Shown;
use crate::fly::Flown;
use crate::maps;
use crate::summary::{counts, notes, times};
use crate::typeset::{escaped, html as table};

const STYLE: &str = include_str!("style.css");

/// At most this many kinds of notes are listed.
const MOST_NOTES: usize = 30;

pub(super) fn html(title: &str, config: &Config, flown: &Flown, shown: &Shown, has_truth: bool) -> String {
    let Shown { course, mapper, places, evaluation } = shown;
    let summary = &flown.summary;
    let failure = match &summary.end {
        End::Failed(failure) => Some(failure.to_string()),
        _ => None,
    };
    let lost: Vec<String> = failure.into_iter().chain(flown.losses.iter().cloned()).collect();
    let map = mapper.map();
    let title = escaped(title);
    let revolutions = counted(summary.revolutions, "revolution");
    let (over_time, flips) = course.picture();
    let sure: u64 = summary.junctions.values().map(|answers| answers.sure).sum();
    let percent = |part: f64| format!("{:.1} %", 100.0 * part / summary.revolutions.max(1) as f64);
    let sections = [
        Some((
            "Summary",
            format!(
                "<p>{revolutions} in {:.1} s of the recording. {}. Sure answers (confidence {SURE} or more): {}. Count \
                 differs from most of the {AROUND} revolutions before and after: {flips} ({}).</p>\n{}",
                course.duration_s(),
                escaped(&map.summary()),
                percent(sure as f64),
                percent(flips as f64),
                table(&counts(summary))
            ),
        )),
        has_truth.then(|| ("Against the truth in the recording", accuracy(evaluation))),
        Some((
            "Over time",
            format!("<div class=\"wide\">{over_time}</div>\n<p>Dots: revolutions whose count differs.</p>\n"),
        )),
        (!map.nodes.is_empty()).then(|| ("Map", format!("<div class=\"map\">{}</div>\n", maps::picture(&map)))),
        Some(("Places", places.html(&map))),
        (!lost.is_empty()).then(|| ("Lost", list(&lost))),
        (summary.noted > 0).then(|| ("Notes", table(&notes(summary, MOST_NOTES)))),
        Some(("Time", table(&times(summary)))),
        Some((
            "Settings",
            format!("<details><summary>all of them</summary><pre>{}</pre></details>\n", escaped(&config.to_string())),
        )),
    ];
    let sections = sections.into_iter().flatten();
    let sections: String =
        sections.map(|(name, body)| format!("<section>\n<h2>{name}</h2>\n{body}</section>\n")).collect();
    let version = env!("CARGO_PKG_VERSION");
    // The empty icon keeps a browser from asking for one.
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{sections}\
         <p>Made by crosscut {version}.</p>\n</body>\n</html>\n"
    )
}

fn list(lines: &[String]) -> String {
    let items = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line)));
    format!("<ul>\n{}</ul>\n", items.collect::<String>())
}

fn accuracy(evaluation: &Evaluation) -> String {
    let figures = evaluation.figures();
    let share = |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let confidence = &figures.confidence;
    let rows = [
        ("revolutions compared", figures.revolutions.to_string()),
        ("right: count equal and every wall matched", share(figures.right.value())),
        ("right counts", share(figures.right_count.value())),
        ("sure answers that are right", share(confidence.sure_right.value())),
        ("openings missed", share(figures.openings.missed.value())),
        ("openings that are not there", share(figures.openings.false_alarms.value())),
    ];
    let rows = rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect();
    table(&Table { title: String::new(), header: vec!["figure".to_owned(), "share".to_owned()], rows })
}
