//! The results of a sweep as files, and as a table on the terminal.

use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::experiment::Outcome;
use crosscut_evaluate::tables::Table;
use crosscut_stage::Step;
use serde_json::{Value, json};

use super::grid::Grid;
use super::{picture, store};
use crate::exit::UsageError;
use crate::{outputs, typeset};

/// The figures, in the order of their columns.
pub(super) const FIGURES: [&str; 13] = [
    "revolutions",
    "failed",
    "mean_junctions",
    "flips",
    "mean_confidence",
    "sure",
    "compared",
    "right",
    "right_count",
    "sure_right",
    "auroc",
    "openings_missed",
    "openings_false",
];

/// One combination on one flight.
pub(super) struct Row<'a> {
    pub(super) flight: &'a str,
    /// Hash of its recording.
    pub(super) input: &'a str,
    /// The value of each key.
    pub(super) point: &'a [String],
    pub(super) result: Value,
}

impl Row<'_> {
    pub(super) fn figure(&self, name: &str) -> Option<f64> {
        self.result["figures"][name].as_f64()
    }

    fn time_ms(&self, step: Step) -> Option<f64> {
        self.result["times_ms"][step.name()].as_f64()
    }
}

/// Writes all files into the folder. What holds of the answers is in `sweep.*`: the same bytes for the same program, settings
/// and recordings. Times are in `times.csv`.
pub(super) fn write(
    folder: &Path,
    program: &str,
    grid: &Grid,
    rows: &[Row<'_>],
    outcomes: &[Outcome],
) -> anyhow::Result<()> {
    let file = |name: &str, text: String| {
        let path = folder.join(name);
        store::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    file("sweep.csv", csv(program, grid, rows))?;
    file("times.csv", times(grid, rows))?;
    file("verdicts.json", format!("{:#}\n", json!(outcomes)))?;
    for place in 0..grid.keys.len() {
        file(&picture_name(grid, place), picture::svg(grid, place, rows))?;
    }
    Ok(())
}

/// Refuses a folder in which the sweep would replace one of the files `read`.
pub(super) fn refuse_overwriting(folder: &Path, grid: &Grid, read: &[PathBuf]) -> Result<(), UsageError> {
    let pictures = (0..grid.keys.len()).map(|place| picture_name(grid, place));
    let names = ["sweep.csv", "times.csv", "verdicts.json"].map(str::to_owned).into_iter().chain(pictures);
    names.map(|name| folder.join(name)).try_for_each(|file| outputs::refuse(&[&file], read))
}

fn picture_name(grid: &Grid, place: usize) -> String {
    format!("{}.svg", grid.keys[place].replace(['/', '\\'], "_"))
}

/// The mean over all flights of each combination, as a table.
pub(super) fn table(grid: &Grid, rows: &[Row<'_>]) -> String {
    let header =
        grid.keys.iter().map(String::as_str).chain(["flights", "right %", "sure %", "right of sure %", "flips", "ms"]);
    let line = |point: &Vec<String>| {
        let of: Vec<&Row<'_>> = rows.iter().filter(|row| row.point == point.as_slice()).collect();
        let percent = |name: &str| mean(of.iter().map(|row| row.figure(name))).map(|value| 100.0 * value);
        let cell =
            |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"));
        // A plain sum of nothing is -0.
        let flips = of.iter().filter_map(|row| row.figure("flips")).fold(0.0, |sum: f64, flips| sum + flips);
        let of_point = [
            of.len().to_string(),
            cell(percent("right"), 1),
            cell(percent("sure"), 1),
            cell(percent("sure_right"), 1),
            format!("{flips}"),
            cell(mean(of.iter().map(|row| total_ms(row))), 3),
        ];
        point.iter().cloned().chain(of_point).collect()
    };
    let rows = grid.points.iter().map(line).collect();
    let table = Table { title: String::new(), header: header.map(str::to_owned).collect(), rows };
    typeset::plain(&table) + "\n"
}

/// Mean of those that are there; `None` if none is.
pub(super) fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let known: Vec<f64> = values.flatten().collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// Of the stages; reading is the same for all combinations.
pub(super) fn total_ms(row: &Row<'_>) -> Option<f64> {
    Step::ALL[1..].iter().map(|step| row.time_ms(*step)).sum()
}

fn csv(program: &str, grid: &Grid, rows: &[Row<'_>]) -> String {
    let names =
        ["flight", "input_hash", "program"].into_iter().chain(grid.keys.iter().map(String::as_str)).chain(FIGURES);
    let mut text = line(names.map(str::to_owned));
    for row in rows {
        let first = [row.flight, row.input, program].map(str::to_owned);
        let figures = FIGURES.iter().map(|name| row.figure(name).map_or_else(String::new, |value| value.to_string()));
        text += &line(first.into_iter().chain(row.point.iter().cloned()).chain(figures));
    }
    text
}

/// Median milliseconds of each stage.
fn times(grid: &Grid, rows: &[Row<'_>]) -> String {
    let names = std::iter::once("flight").chain(grid.keys.iter().map(String::as_str)).chain(Step::ALL.map(Step::name));
    let mut text = line(names.map(str::to_owned));
    for row in rows {
        let times = Step::ALL.map(|step| row.time_ms(step).map_or_else(String::new, |ms| format!("{ms:.6}")));
        text += &line(std::iter::once(row.flight.to_owned()).chain(row.point.iter().cloned()).chain(times));
    }
    text
}

/// A line of CSV.
fn line(cells: impl Iterator<Item = String>) -> String {
    cells.map(|cell| typeset::csv_field(&cell).into_owned()).collect::<Vec<_>>().join(",") + "\n"
}
