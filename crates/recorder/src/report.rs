//! The answer: count, place, walls and openings in words; notes and timings.

use std::fmt::Write as _;

use crosscut_stage::{Frame, Step};
use rerun::{
    RecordingStream, RecordingStreamResult, Scalars, SeriesLines, StateChange, TextDocument, TextLog, TextLogLevel,
};

use crate::colors::{REPORTED, STEPS, color};
use crate::matrices::{LARGEST_PICTURE, is_drawn};

/// Names and colours of the lines over time.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let line = |name: &str, rgba, width: f32| {
        SeriesLines::new().with_names([name]).with_colors([color(rgba)]).with_widths([width])
    };
    rec.log_static("report/junctions", &line("junctions (walls)", REPORTED, 5.0))?; // seen behind k where both agree
    for (step, rgba) in Step::ALL.into_iter().zip(STEPS) {
        rec.log_static(format!("timing/{step}"), &line(step.name(), rgba, 2.0))?;
    }
    Ok(())
}

/// Count, place, summary, notes and timings of one revolution.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    let junction = &frame.junction;
    rec.log("report/junctions", &Scalars::single(junction.junctions as f64))?;
    rec.log("report/confidence", &Scalars::single(junction.confidence))?;
    rec.log("report/place", &StateChange::single(junction.place.to_string()))?;
    rec.log("report/summary", &TextDocument::from_markdown(summary(frame)))?;
    for step in Step::ALL {
        rec.log(format!("timing/{step}"), &Scalars::single(frame.timings.ns(step) as f64 * 1e-6))?;
    }
    log_notes(rec, frame)
}

/// What was noted on the way, and what this recording leaves out.
fn log_notes(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    for note in frame.notes.iter() {
        rec.log("log", &TextLog::new(note).with_level(TextLogLevel::INFO))?;
    }
    let n = frame.affinity.weights.n();
    if n > 0 && !is_drawn(&frame.affinity) {
        let note = format!("no picture of W and L: {n} returns, pictures are made up to {LARGEST_PICTURE}");
        rec.log("log", &TextLog::new(note).with_level(TextLogLevel::INFO))?;
    }
    Ok(())
}

/// The revolution in a few large words, then its walls and openings.
fn summary(frame: &Frame) -> String {
    let (junction, spectrum) = (&frame.junction, &frame.spectrum);
    let place = junction.place.to_string().replace('_', " ");
    let plural = if junction.junctions == 1 { "" } else { "s" };
    let mut text = format!("# {} · {place}\n\n", junction.junctions);
    let mut line = |words: std::fmt::Arguments<'_>| {
        text.write_fmt(words).expect("a string takes any text");
        text.push('\n');
    };
    line(format_args!(
        "**{} junction{plural}** (walls), k = {}, {} returns. Confidence {:.0} %.",
        junction.junctions,
        spectrum.k,
        frame.revolution.len(),
        100.0 * junction.confidence
    ));
    if let Some(margin) = spectrum.margin_decades {
        line(format_args!("τ = {:.0e} may move {margin:.1} decades before k changes.", spectrum.tolerance));
    }
    line(format_args!("\n| opening | width | walls | seen by |\n|---|---|---|---|"));
    for opening in &junction.openings {
        let [right, left] = opening.walls;
        let bearing_deg = opening.bearing_rad.to_degrees();
        let evidence = opening.evidence.to_string().replace('_', " ");
        line(format_args!("| {bearing_deg:+.0}° | {:.1} m | {right}, {left} | {evidence} |", opening.width_m));
    }
    line(format_args!("\n| wall | returns | from | to |\n|---|---|---|---|"));
    for wall in &junction.walls {
        let [from, to] = wall.bearing_rad.map(f64::to_degrees);
        let island = if wall.island { " (island)" } else { "" };
        line(format_args!("| {}{island} | {} | {from:+.0}° | {to:+.0}° |", wall.id, wall.returns));
    }
    text
}
