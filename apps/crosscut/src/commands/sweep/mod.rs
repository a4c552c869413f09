//! `crosscut sweep`: every combination of some settings over a set of flights.

mod grid;
mod output;
mod picture;
mod store;
mod tally;
mod verdict;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};

use anyhow::Context;
use crosscut_detector::{Config, Frame, Registry};
use crosscut_evaluate::{Score, Variants, settings_of_step};
use crosscut_ingest::Truths;
use crosscut_pipeline::StopFlag;
use crosscut_report::ResultsLine;
use crosscut_stage::Step;
use indicatif::ProgressBar;
use serde_json::{Value, json};

use self::grid::Grid;
use self::store::Store;
use self::tally::Tally;
use crate::cli::InputArgs;
use crate::cli::sweep::SweepArgs;
use crate::content::{hash, hash_of_file, program};
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::fly::{self, Judge, each_of, files_read};
use crate::interrupt::stop_on_interrupt;
use crate::looking::Looks;
use crate::progress;
use crate::say::{say, show};

/// A recording, and what is known of it.
struct Input {
    path: PathBuf,
    name: String,
    hash: String,
}

/// A flight with combinations that read its scans in one way, and the names under which their results are kept.
struct Task<'a> {
    flight: &'a Input,
    points: Vec<(usize, String)>,
}

/// Runs every combination on every flight, except where this build has done that before.
pub(crate) fn sweep(args: &SweepArgs, registry: &Registry, build: Option<&str>) -> anyhow::Result<Outcome> {
    let grid = Grid::parse(&args.grid)?;
    let configs = grid.configs(&args.config, registry)?;
    output::refuse_overwriting(&args.out, &grid, &files_read(&args.input, args.config.config.clone())?)?;
    let store = Store::open(args.out.join("rows"))?;
    let mut diagnostics = Diagnostics::default();
    let flights = flights(each_of(&args.input.recordings.input, &mut diagnostics)?, &mut diagnostics);
    let program = program(build);
    let InputArgs { recordings, topic, from, to, join: _, every } = &args.input;
    let read = format!("{topic:?} {:?} {from:?} {to:?} {every}", recordings.read_as);
    let name_of = |flight: &Input, config: &Config| {
        let settings: String = config.settings().map(|(key, value)| format!("{key}={value}\n")).collect();
        hash(&[&program, &flight.hash, &read, &settings])
    };
    let names: Vec<Vec<String>> =
        flights.iter().map(|flight| configs.iter().map(|config| name_of(flight, config)).collect()).collect();
    let tasks = tasks(&flights, &configs, &names, &store);
    let (missing, all) = (tasks.iter().map(|task| task.points.len()).sum::<usize>(), flights.len() * configs.len());
    if !args.quiet && missing < all {
        say(format_args!("{} of {all} are there from an earlier sweep", all - missing));
    }
    let stop = stop_on_interrupt()?;
    let sweep = Sweep { args, configs: &configs, registry, store: &store, stop: &stop };
    sweep.run(&tasks, &mut diagnostics)?;

    let mut rows = Vec::new();
    for (flight, names) in flights.iter().zip(&names) {
        for (point, name) in grid.points.iter().zip(names) {
            if let Some(result) = store.get(name) {
                // Also for a row that is there from an earlier sweep: its figures lack the scans that were lost.
                let texts = |field: &str| result[field].as_array().into_iter().flatten().filter_map(Value::as_str);
                diagnostics.lost_all(texts("lost"));
                texts("left_out").for_each(|note| diagnostics.note(note));
                rows.push(output::Row { flight: &flight.name, input: &flight.hash, point, result });
            }
        }
    }
    let outcomes = verdict::outcomes(&grid, &rows);
    output::write(&args.out, &program, &grid, &rows, &outcomes)?;
    if !args.quiet {
        let paths: Vec<PathBuf> = flights.iter().map(|flight| flight.path.clone()).collect();
        let looks = Looks { flights: &paths, options: grid.options(&args.input, &args.config) };
        let hint = looks.hint(&outcomes, None);
        show(format_args!("{}{}", verdict::sentences(&outcomes, hint), output::table(&grid, &rows)))?;
    }
    if let Some(log) = &args.log {
        let kept = verdict::keep(log, &grid, &rows, &configs, &flights, registry);
        diagnostics.lost_all(kept.err().map(|error| format!("{error:#}")));
    }
    if stop.is_set() {
        let left = all - rows.len();
        diagnostics.interrupted(format_args!("{left} of {all} are left; run the same command again to continue"));
    }
    Ok(diagnostics.outcome())
}

/// The flights that can be read, each with a name of its own.
fn flights(paths: Vec<PathBuf>, diagnostics: &mut Diagnostics) -> Vec<Input> {
    let stem = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stems: Vec<String> = paths.iter().map(stem).collect();
    let is_single = |name: &String| stems.iter().filter(|other| *other == name).count() == 1;
    let mut flights = Vec::new();
    for (path, stem) in paths.into_iter().zip(&stems) {
        let name = if is_single(stem) { stem.clone() } else { path.display().to_string() };
        match hash_of_file(&path) {
            Ok(hash) => flights.push(Input { path, name, hash }),
            Err(error) => diagnostics.error(format_args!("left out: {error}: {}", path.display())),
        }
    }
    flights
}

/// What is not there yet, by flight and by how its scans are read.
fn tasks<'a>(flights: &'a [Input], configs: &[Config], names: &[Vec<String>], store: &Store) -> Vec<Task<'a>> {
    let mut tasks = Vec::new();
    for (flight, names) in flights.iter().zip(names) {
        let mut by_reading: BTreeMap<String, Vec<(usize, String)>> = BTreeMap::new();
        // Two combinations may resolve to the same settings.
        let mut known = BTreeSet::new();
        for (place, (config, name)) in configs.iter().zip(names).enumerate() {
            if known.insert(name) && store.get(name).is_none() {
                let reading = settings_of_step(config, Step::Ingest);
                by_reading.entry(reading).or_default().push((place, name.clone()));
            }
        }
        tasks.extend(by_reading.into_values().map(|points| Task { flight, points }));
    }
    tasks
}

struct Sweep<'a> {
    args: &'a SweepArgs,
    configs: &'a [Config],
    registry: &'a Registry,
    store: &'a Store,
    stop: &'a StopFlag,
}

impl Sweep<'_> {
    /// Works on the tasks, several at a time.
    fn run(&self, tasks: &[Task<'_>], diagnostics: &mut Diagnostics) -> anyhow::Result<()> {
        let jobs = self.args.jobs.or_else(|| thread::available_parallelism().ok()).map_or(1, usize::from);
        let totals =
            tasks.iter().map(|task| self.open(task).ok().and_then(|mut recording| recording.total_revolutions()));
        let bar = progress::bar(totals.sum(), self.args.quiet);
        let next = Mutex::new(tasks.iter());
        let reports = Mutex::new(Vec::new());
        thread::scope(|scope| -> anyhow::Result<()> {
            for job in 0..jobs.min(tasks.len()) {
                let work = || {
                    while !self.stop.is_set() {
                        let Some(task) = next.lock().unwrap_or_else(PoisonError::into_inner).next() else { return };
                        let done = self.work(task, &bar).map_err(|error| (task.flight.path.clone(), error));
                        reports.lock().unwrap_or_else(PoisonError::into_inner).extend(done.err());
                    }
                };
                Builder::new().name(format!("sweep-{job}")).spawn_scoped(scope, work).context("a thread")?;
            }
            Ok(())
        })?;
        bar.finish_and_clear();
        let mut reports = reports.into_inner().unwrap_or_else(PoisonError::into_inner);
        reports.sort_by(|(a, _), (b, _)| a.cmp(b));
        for (path, error) in reports {
            diagnostics.error(format_args!("left out: {error:#}: {}", path.display()));
        }
        Ok(())
    }

    fn open(&self, task: &Task<'_>) -> anyhow::Result<fly::Flight> {
        let config = &self.configs[task.points[0].0];
        fly::Flight::open(std::slice::from_ref(&task.flight.path), &self.args.input, config)
    }

    /// Runs the combinations of a task together, and keeps their results; none of them if it is interrupted or the flight
    /// cannot be read to its end.
    fn work(&self, task: &Task<'_>, bar: &ProgressBar) -> anyhow::Result<()> {
        let mut flight = self.open(task)?.with_truths(Truths::open(&task.flight.path).ok());
        let configs: Vec<&Config> = task.points.iter().map(|(place, _)| &self.configs[*place]).collect();
        let mut variants = Variants::new(&configs, self.registry);
        let mut tallies: Vec<Tally> = configs.iter().map(|_| Tally::default()).collect();
        let (mut frame, mut judge, mut revolutions) = (Frame::default(), Judge::default(), 0);
        while let Some(truth) = flight.next(&mut frame.revolution, &mut frame.notes)? {
            if self.stop.is_set() {
                return Ok(());
            }
            let truth = judge.truth(truth, frame.revolution.seq);
            let mut refused = None;
            variants.process(&mut frame, &mut |place, frame| {
                let truth = truth.as_ref().filter(|_| frame.failure.is_none());
                let score = truth.map(|truth| Score::of(truth, &ResultsLine::of(frame)));
                tallies[place].add(frame, score.as_ref().and_then(|score| score.as_ref().ok()));
                refused = refused.take().or(score.and_then(Result::err));
            });
            refused.into_iter().for_each(|error| judge.cannot(error.to_string()));
            frame.notes.clear();
            revolutions += 1;
            bar.inc(1);
        }
        if revolutions == 0 {
            anyhow::bail!("no scan could be read");
        }
        let (left_out, losses) = (flight.left_out(), flight.losses(judge));
        for ((_, name), tally) in task.points.iter().zip(tallies) {
            let [right, wrong] = tally.judged();
            let row: Value = json!({
                "figures": tally.figures(), "right_at": right, "wrong_at": wrong, "times_ms": tally.times_ms(), "lost": losses,
                "left_out": left_out,
            });
            self.store.put(name, &row)?;
        }
        Ok(())
    }
}
