//! The revolutions that differ from those around them, as Markdown.

use std::fmt::Write;

use crosscut_evaluate::{AROUND, Flip};

use super::OverTime;

const LIST: &str = "
Clear is how far the walls at a way on leave each other's line, the least of all ways on, and how far a wall leaves its own at
a gap that the vehicle would fit into, the most of all gaps: the verdicts that could most easily be the other.

| revolution | s | walls | around it | margin | confidence | way on clear, m | gap clear, m | what is different |
|---|---|---|---|---|---|---|---|---|
";

/// How many flips there are, and a line for each.
pub(super) fn markdown(title: &str, flight: &OverTime, flips: &[Flip]) -> String {
    let revolutions = flight.moments.len();
    let percent = 100.0 * flips.len() as f64 / revolutions.max(1) as f64;
    let mut page = format!(
        "# {title}\n\n{} of {revolutions} revolutions ({percent:.1} %) have another count than most of the {AROUND} before and \
         after them.\n",
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
        // Writing to a string does not fail.
        let _ = writeln!(
            page,
            "| {} | {:.1} | {} | {} | {} | {:.2} | {} | {} | {} |",
            moment.seq,
            flight.seconds(moment),
            flip.junctions,
            flip.around,
            number(moment.margin, 1),
            moment.confidence,
            number(moment.grounds.map(|of| of.least_at_openings_m), 2),
            number(moment.grounds.map(|of| of.most_within_walls_m), 2),
            flight.reason(flip)
        );
    }
    page
}
