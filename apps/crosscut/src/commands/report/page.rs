//! The page: its sections in order.

use crosscut_detector::Config;
use crosscut_evaluate::tables::Table;
use crosscut_evaluate::{AROUND, Evaluation};
use crosscut_pipeline::{Answers, RunEnd};
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_stage::{SURE, counted};

use super::Shown;
use crate::fly::Flown;
use crate::output::Look;
use crate::output::map_picture::{Drawing, NARROW_PX};
use crate::output::summary::{counts, notes, times};
use crate::output::typeset::{escaped, html as table};

const STYLE: &str = include_str!("style.css");

/// At most this many kinds of notes are listed.
const MOST_NOTES: usize = 30;

pub(super) fn html(
    title: &str,
    (preset, config): (&str, &Config),
    flown: &Flown,
    shown: &Shown,
    has_truth: bool,
    look: &Look,
) -> String {
    let Shown { course, mapper, no_place, seen, places, evaluation } = shown;
    let summary = &flown.summary;
    let failure = match &summary.end {
        RunEnd::Failed(failure) => Some(failure.to_string()),
        _ => None,
    };
    let lost: Vec<String> = failure.into_iter().chain(flown.losses.iter().cloned()).collect();
    let map = mapper.map();
    let title = escaped(title);
    let revolutions = counted(summary.revolutions, "revolution");
    let (over_time, flips) = course.picture();
    let Answers { sure, rated, .. } = summary.answers();
    let percent = |part: f64| format!("{:.1} %", 100.0 * part / summary.revolutions.max(1) as f64);
    let found = no_place.reason(&map).unwrap_or_else(|| format!("The map has {}.", map.summary()));
    let sure = match rated {
        0 => "how sure the answers are is not known, as nothing was calibrated for them".to_owned(),
        _ => format!("{} of the answers are sure (confidence {SURE} or more)", percent(sure as f64)),
    };
    let opening = format!(
        "<p>{revolutions} (turns of the lidar) in {:.1} s of the recording; {sure}.</p>\n<p>{}</p>\n<p>{}</p>\n",
        course.duration_s(),
        escaped(&found),
        match flips {
            0 =>
                "No count differs from most of those around it: look at the <a href=\"#places\">places</a>.".to_owned(),
            _ => format!(
                "Look at the {flips} ({}) whose count differs from most of the {AROUND} before and after: the dots \
                 <a href=\"#over-time\">over time</a>.",
                percent(flips as f64)
            ),
        }
    );
    let sections = [
        Some(("Summary", format!("{opening}{}", table(&counts(summary))))),
        has_truth.then(|| ("Against the truth in the recording", accuracy(evaluation))),
        Some((
            "Over time",
            format!(
                "<p class=\"narrow\">Scroll sideways for all of it.</p>\n<div class=\"wide\">{over_time}</div>\n<p>Dots: revolutions \
                 whose count differs from most of those around; point at one for the reason.</p>\n"
            ),
        )),
        (!seen.path().is_empty()).then(|| {
            let drawn = Drawing::of(map.clone(), seen, mapper).svg("", NARROW_PX);
            ("Map", format!("<div class=\"map\">{drawn}</div>\n"))
        }),
        Some(("Places", places.html(&map, look))),
        (!lost.is_empty()).then(|| ("Lost", list(&lost))),
        (summary.noted > 0).then(|| ("Notes", table(&notes(summary, MOST_NOTES)))),
        Some(("Time", table(&times(summary, false)))),
        Some((
            "Settings",
            format!(
                "{}<details><summary>all settings</summary><pre>{}</pre></details>\n",
                changed(config),
                escaped(&config.to_string())
            ),
        )),
    ];
    let sections = sections.into_iter().flatten();
    let sections: String = sections
        .map(|(name, body)| format!("<section id=\"{}\">\n<h2>{name}</h2>\n{body}</section>\n", id_of(name)))
        .collect();
    let version = env!("CARGO_PKG_VERSION");
    let vehicle_m = config.params("vehicle").get(VEHICLE_WIDTH_M);
    let about = format!("{}Vehicle {vehicle_m} m wide, preset {}.", course.began(), escaped(preset));
    // The empty icon keeps a browser from asking for one.
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p class=\"legend\">{about}</p>\n{sections}\
         <p>Made by crosscut {version}.</p>\n</body>\n</html>\n"
    )
}

/// Where links to a section lead.
fn id_of(name: &str) -> String {
    name.to_lowercase().replace(' ', "-")
}

fn list(lines: &[String]) -> String {
    let items = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line)));
    format!("<ul>\n{}</ul>\n", items.collect::<String>())
}

/// The settings that the preset, a file or an option set, folded.
fn changed(config: &Config) -> String {
    let rows = config.set_by_layers().into_iter().map(Vec::from).collect::<Vec<_>>();
    if rows.is_empty() {
        return "<p>All settings have their defaults.</p>\n".to_owned();
    }
    let header = ["setting", "value", "set by"].map(str::to_owned).to_vec();
    let changed = table(&Table { title: String::new(), header, rows });
    format!("<details><summary>settings that are not the defaults</summary>{changed}</details>\n")
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
