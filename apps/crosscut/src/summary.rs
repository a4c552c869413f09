//! The summary at the end of a run.

use std::time::Duration;

use comfy_table::{CellAlignment, Table, presets};
use crosscut_pipeline::Summary;
use crosscut_stage::{Step, counted};

/// The summary shows this many kinds of notes; the results hold all notes.
const NOTES_SHOWN: usize = 5;

/// Tables of counts, notes, and time per stage.
pub(crate) fn table(summary: &Summary, elapsed: Duration) -> String {
    let per_second = summary.revolutions as f64 / elapsed.as_secs_f64().max(1e-9);
    let mut text = format!(
        "{} in {:.2} s ({per_second:.0} a second), {} with notes\n",
        counted(summary.revolutions, "revolution"),
        elapsed.as_secs_f64(),
        summary.noted
    );
    if summary.revolutions > 0 {
        text += &format!("\n{}\n\n{}\n", counts(summary), times(summary));
    }
    if summary.noted > 0 {
        text += &format!("\n{}\n", notes(summary));
    }
    text
}

fn counts(summary: &Summary) -> Table {
    let mut table = plain(&["walls", "revolutions", "share", "of these, sure"]);
    let share = |part: u64, whole: u64| format!("{:.1} %", 100.0 * part as f64 / whole as f64);
    for (junctions, answers) in &summary.junctions {
        table.add_row([
            junctions.to_string(),
            answers.revolutions.to_string(),
            share(answers.revolutions, summary.revolutions),
            share(answers.sure, answers.revolutions),
        ]);
    }
    table
}

/// The most frequent kinds of notes, each with its first instance.
fn notes(summary: &Summary) -> String {
    let kinds = summary.notes.by_frequency();
    let mut table = plain(&["revolutions", "note (first of its kind)"]);
    table.column_mut(1).expect("two columns").set_cell_alignment(CellAlignment::Left);
    for kind in kinds.iter().take(NOTES_SHOWN) {
        table.add_row([kind.revolutions.to_string(), kind.first.clone()]);
    }
    let more = kinds.len().saturating_sub(NOTES_SHOWN) as u64;
    if more > 0 { format!("{table}\n and {} more in the results", counted(more, "kind")) } else { table.trim_fmt() }
}

fn times(summary: &Summary) -> Table {
    let mut table = plain(&["stage", "median ms", "p99 ms"]);
    let steps = Step::ALL.map(|step| (step.name(), summary.times.median_and_p99_ns(step)));
    // From the arrival of the scan until its results are written: longer than the stages where scans wait for each other.
    let latency = ("with waiting", summary.times.latency_median_and_p99_ns());
    let flight = ("flight", summary.times.flight_median_and_p99_ns());
    for (name, times) in steps.into_iter().chain([flight, latency]) {
        if let Some((median_ns, p99_ns)) = times {
            let ms = |ns: u64| format!("{:.3}", ns as f64 / 1e6);
            table.add_row([name.to_owned(), ms(median_ns), ms(p99_ns)]);
        }
    }
    table
}

fn plain(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
