//! The list of revolutions whose count differs from their neighbours, as Markdown.

use std::fmt::Write;

use crosscut_evaluate::{AROUND, Flip};

use super::Course;

const LIST: &str = "
The two columns of clearance belong to the verdicts closest to the threshold. *Opening clear*: how far the walls at an opening
leave each other's line, the least of all openings. *Gap clear*: how far a wall leaves its own line at a gap that the vehicle
would fit into, the most of all gaps.

| revolution | s | walls | around it | margin | confidence | opening clear, m | gap clear, m | difference |
|---|---|---|---|---|---|---|---|---|
";

/// The share of flips, and a row for each.
pub(super) fn markdown(title: &str, flight: &Course, flips: &[Flip]) -> String {
    let revolutions = flight.moments.len();
    let percent = 100.0 * flips.len() as f64 / revolutions.max(1) as f64;
    let mut page = format!(
        "# {title}\n\nThe count of {} of {revolutions} revolutions ({percent:.1} %) differs from that of most of the {AROUND} before \
         and after them.\n",
        flips.len()
    );
    if !flips.is_empty() {
        page += LIST;
    }
    for flip in flips {
        let moment = &flight.moments[flip.at];
        let number = |value: Option<f64>, decimals: usize| match value {
            Some(value) if value.is_finite() => format!("{value:.decimals$}"),
            _ => "-".to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            page,
            "| {} | {:.1} | {} | {} | {} | {} | {} | {} | {} |",
            moment.seq,
            flight.seconds(moment),
            flip.junctions,
            flip.around,
            number(moment.margin, 1),
            number(moment.confidence, 2),
            number(moment.grounds.map(|of| of.least_at_openings_m), 2),
            number(moment.grounds.map(|of| of.most_within_walls_m), 2),
            flight.reason(flip)
        );
    }
    page
}
