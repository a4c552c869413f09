//! What each combination mends and breaks against the first.

use std::path::{Path, PathBuf};

use crosscut_detector::{Config, Registry};
use crosscut_evaluate::experiment::{self, Experiment, Outcome};
use serde_json::{Value, json};

use super::Input;
use super::grid::Grid;
use super::output::{Row, mean};
use crate::run_log::Run;

/// Of more combinations, those that mend the most beyond what they break are shown.
const SHOWN: usize = 8;

/// What each combination but the first mends and breaks, flight by flight.
pub(super) fn outcomes(grid: &Grid, rows: &[Row<'_>]) -> Vec<Outcome> {
    let mut experiment = Experiment::new(grid.names());
    for row in rows {
        let Some(place) = grid.points.iter().position(|point| point == row.point) else { continue };
        for (field, is_right) in [("right_at", true), ("wrong_at", false)] {
            let seqs = row.result[field].as_array().into_iter().flatten().filter_map(Value::as_u64);
            seqs.for_each(|seq| experiment.add(row.flight, place, seq, is_right));
        }
    }
    experiment.outcomes()
}

/// The sentences on them, the conclusion first; empty without truth.
pub(super) fn sentences(outcomes: &[Outcome], hint: Option<String>) -> String {
    let outcomes: Vec<Outcome> = outcomes.iter().filter(|outcome| outcome.verdict.of > 0).cloned().collect();
    let mut best: Vec<&Outcome> = outcomes.iter().collect();
    best.sort_by_key(|outcome| outcome.verdict.breaks.cast_signed() - outcome.verdict.mends.cast_signed());
    let shown: Vec<Outcome> = match best.len() {
        ..=SHOWN => outcomes.clone(),
        _ => best[..SHOWN].iter().map(|&outcome| outcome.clone()).collect(),
    };
    let more = outcomes.len() - shown.len();
    let more = (more > 0).then(|| format!("{more} more combinations are in verdicts.json; these mend the most"));
    let lines: Vec<String> = experiment::sentences(&shown).into_iter().chain(more).chain(hint).collect();
    if lines.is_empty() { String::new() } else { lines.join("\n") + "\n\n" }
}

/// Appends the figures of each combination to a history of runs.
pub(super) fn keep(
    log: &Path,
    grid: &Grid,
    rows: &[Row<'_>],
    configs: &[Config],
    flights: &[Input],
    registry: &Registry,
) -> anyhow::Result<()> {
    let paths: Vec<PathBuf> = flights.iter().map(|flight| flight.path.clone()).collect();
    let run = Run::of("sweep", &paths);
    for ((point, name), config) in grid.points.iter().zip(grid.names()).zip(configs) {
        let of: Vec<&Row<'_>> = rows.iter().filter(|row| row.point == point.as_slice()).collect();
        let revolutions: f64 = of.iter().filter_map(|row| row.figure("revolutions")).sum();
        let share = |figure: &str| mean(of.iter().map(|row| row.figure(figure)));
        let figures = json!({
            "revolutions": revolutions as u64, "right": share("right"), "right_count": share("right_count"),
        });
        run.append(log, &name, config, registry, figures)?;
    }
    Ok(())
}
