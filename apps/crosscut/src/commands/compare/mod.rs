//! `crosscut compare`: how often configurations are right where the truth is known, and where they differ where it is not.

mod flight;
mod shown;

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};

use anyhow::Context;
use clap::Args;
use crosscut_detector::{Registry, panic_text};
use crosscut_outfile::Keep;
use crosscut_pipeline::StopFlag;
use indicatif::ProgressBar;

use self::flight::Compared;
use self::shown::Shown;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::input::configurations::{self, Configuration, Grid};
use crate::input::live::{Robots, robot_of};
use crate::input::{CONFIGURATION, Coming, Flight, InputArgs, LiveArgs, each_of, files_of};
use crate::interrupt::stop_on_interrupt;
use crate::output::{Document, files, progress, show};

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    live: LiveArgs,
    /// Configuration, in parts that commas separate: a preset, a file of settings over it (FILE.toml, or FLIGHT.rrd made with
    /// `run --save`), single settings over both. `NAME=` before them names it in tables
    /// (`mine=paper,affinity.sigma_per_m2=3`). Repeat it: the others are compared with the first. [default: default]
    #[arg(long, help_heading = CONFIGURATION, value_name = "[NAME=]PRESET|FILE.toml|SETTING[,...]")]
    with: Vec<String>,
    /// Setting with the values to try in every configuration, such as affinity.sigma_per_m2=0.5,1,1.5. Repeat it to try every
    /// combination.
    #[arg(long, help_heading = CONFIGURATION, value_name = "KEY=V1,V2...")]
    grid: Vec<String>,
    /// Single setting that overrides every configuration. May be repeated.
    #[arg(long, help_heading = CONFIGURATION, value_name = "SECTION.KEY=VALUE")]
    set: Vec<String>,
    /// Show all tables: counts, labels, openings and confidence, every stretch where walls differ, and a command for each
    /// revolution that is mended or broken.
    #[arg(long)]
    details: bool,
    /// Write a row for each flight and configuration; `-` is standard output.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write all figures, verdicts and stretches as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Show no progress bar and no tables.
    #[arg(short, long)]
    quiet: bool,
}

/// A flight to be compared: its name and its files.
type Input = (String, Vec<PathBuf>);

/// Answers every flight by every configuration, and compares the answers with the truth and with those of the first.
pub(crate) fn compare(args: &CompareArgs, registry: &Registry, robots: Option<&dyn Robots>) -> anyhow::Result<Outcome> {
    let grid = Grid::parse(&args.grid)?;
    let configurations = configurations::named(&args.with, &grid, &args.set, registry)?;
    let stop = stop_on_interrupt()?; // before any recording is looked through
    let config = flight::reading(&configurations, &configurations[0].config);
    let robot = robot_of(&args.input, &args.live, None, config)?;
    let read = files_of(&args.input, &args.live, robot.as_ref(), configurations::files(&args.with))?;
    let outputs: Vec<_> = args.json.iter().chain(&args.csv).map(PathBuf::as_path).collect();
    files::refuse(&outputs, &read)?;
    let open = |path: &PathBuf| Document::create(path, &read, Keep::ThroughKill);
    let (mut json, mut csv) = (args.json.as_ref().map(open).transpose()?, args.csv.as_ref().map(open).transpose()?);
    let mut diagnostics = Diagnostics::default();
    let all = All { args, configurations: &configurations, registry, stop: &stop };
    let compared = match Coming::open(&args.input, &args.live, robot.as_ref(), config, &stop, robots)? {
        Some(coming) => vec![all.as_it_comes(coming, &mut diagnostics)?],
        None => {
            let (flights, revolutions) = all.inputs(&mut diagnostics)?;
            all.in_parallel(&flights, progress::bar(revolutions, args.quiet), &mut diagnostics)?
        }
    };
    let several = compared.len() > 1;
    for of in &compared {
        of.report(several.then_some(&of.name), &configurations, &mut diagnostics);
    }
    if compared.iter().any(|of| of.has_truth) {
        note_changed_scans(&configurations, &mut diagnostics);
    }
    if stop.is_set() && compared.is_empty() {
        diagnostics.interrupted("before the first flight");
    }
    let shown = Shown::of(&configurations, &grid, &args.input, &compared);
    json.iter_mut().try_for_each(|out| out.write(&shown.json(diagnostics.problems())))?;
    csv.iter_mut().try_for_each(|out| out.write(&shown.csv()))?;
    if !args.quiet && !outputs.contains(&Path::new("-")) {
        show(shown.text(args.details))?;
    }
    Ok(diagnostics.outcome())
}

/// What is compared, and how.
struct All<'a> {
    args: &'a CompareArgs,
    configurations: &'a [Configuration],
    registry: &'a Registry,
    stop: &'a StopFlag,
}

impl All<'_> {
    /// The flights that can be compared, and how many revolutions they have, if that is known: each file is a flight, or with
    /// --join all together. One that cannot be read, or without truth for one configuration alone, is left out, unless no other is
    /// left.
    fn inputs(&self, diagnostics: &mut Diagnostics) -> anyhow::Result<(Vec<Input>, Option<u64>)> {
        let given = &self.args.input.recordings.input;
        let mut flights = Vec::new();
        for input in given.chunks(if self.args.input.join { given.len() } else { 1 }) {
            let files = each_of(input, diagnostics)?;
            let is_one = self.args.input.join || input[0].join("metadata.yaml").is_file();
            flights.extend(if is_one { vec![files] } else { files.into_iter().map(|file| vec![file]).collect() });
        }
        let mut seen = BTreeSet::new();
        flights.retain(|parts| {
            let is_new = seen.insert(parts.iter().map(|file| file.canonicalize().ok()).collect::<Vec<_>>());
            if !is_new {
                diagnostics.note(format_args!("{} was given twice and counts once", parts[0].display()));
            }
            is_new
        });
        let stem = |parts: &Vec<PathBuf>| parts[0].file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let stems: Vec<String> = flights.iter().map(stem).collect();
        let (mut kept, mut revolutions, mut refused) = (Vec::new(), Some(0), Vec::new());
        for (parts, stem) in flights.into_iter().zip(&stems) {
            let is_alone = stems.iter().filter(|other| *other == stem).count() == 1;
            let name = if is_alone { stem.clone() } else { parts[0].display().to_string() };
            match self.open(&parts) {
                Ok(flight) if self.configurations.len() == 1 && !flight.has_truths() => {
                    let why = format!(
                        "there is no truth (/truth) in {}, so one configuration has nothing to be compared with; name two: \
                         --with default --with paper",
                        parts[0].display()
                    );
                    refused.push(UsageError(why).into());
                }
                Ok(mut flight) => {
                    revolutions = revolutions.zip(flight.total_revolutions()).map(|(sum, more)| sum + more);
                    kept.push((name, parts));
                }
                Err(error) => refused.push(error),
            }
        }
        if kept.is_empty()
            && let Some(last) = refused.pop()
        {
            refused.iter().for_each(|error| diagnostics.error(format_args!("{error:#}")));
            return Err(last); // which is printed at the end of the command
        }
        refused.iter().for_each(|error| diagnostics.error(format_args!("left out: {error:#}")));
        Ok((kept, revolutions))
    }

    fn open(&self, parts: &[PathBuf]) -> anyhow::Result<Flight> {
        Flight::open_with_truths(parts, &self.args.input, &self.configurations[0].config)
    }

    /// Compares the flights, as many at a time as there are processors. One that fails is left out.
    fn in_parallel(
        &self,
        flights: &[Input],
        bar: ProgressBar,
        diagnostics: &mut Diagnostics,
    ) -> anyhow::Result<Vec<Compared>> {
        let next = AtomicUsize::new(0);
        let done = Mutex::new(Vec::new());
        thread::scope(|scope| {
            for job in 0..thread::available_parallelism().map_or(1, NonZeroUsize::get).min(flights.len()) {
                let work = || {
                    while let (false, Some(flight)) =
                        (self.stop.is_set(), flights.get(next.fetch_add(1, Ordering::Relaxed)))
                    {
                        let compared = catch_unwind(AssertUnwindSafe(|| self.compare(flight, &bar)));
                        let compared =
                            compared.unwrap_or_else(|panic| Err(anyhow::anyhow!(panic_text(panic.as_ref()))));
                        done.lock().unwrap_or_else(PoisonError::into_inner).push((flight, compared));
                    }
                };
                Builder::new().name(format!("compare-{job}")).spawn_scoped(scope, work).context("a thread")?;
            }
            anyhow::Ok(())
        })?;
        bar.finish_and_clear();
        let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
        done.sort_by_key(|(flight, _)| flights.iter().position(|of| of == *flight));
        let mut all = Vec::new();
        for ((_, parts), compared) in done {
            match compared {
                Ok(compared) => all.push(compared),
                Err(error) => diagnostics.error(format_args!("left out: {error:#}: {}", parts[0].display())),
            }
        }
        Ok(all)
    }

    fn compare(&self, (name, parts): &Input, bar: &ProgressBar) -> anyhow::Result<Compared> {
        let open = |config: &_| Flight::open_with_truths(parts, &self.args.input, config);
        let readers = flight::readers(self.configurations, self.registry, open)?;
        flight::compare((name, parts), readers, self.configurations, self.stop, &|| bar.inc(1))
    }

    /// Compares what is read once, as it comes: as the first configuration reads it.
    fn as_it_comes(&self, coming: Coming, diagnostics: &mut Diagnostics) -> anyhow::Result<Compared> {
        if self.configurations.len() == 1 {
            let usage = "compare needs at least two configurations: --with default --with paper";
            return Err(UsageError(usage.to_owned()).into());
        }
        let Coming { mut flight, robot, silence } = coming;
        let total = if flight.is_stream() { None } else { flight.total_revolutions() };
        let bar = progress::bar(total, self.args.quiet);
        // What comes as it comes is not cut short: it ends once what was read is answered.
        let stop = if flight.is_stream() { &StopFlag::default() } else { self.stop };
        let name = self.args.input.recordings.input[0].display().to_string();
        let readers = vec![flight::only_reader(self.configurations, self.registry, flight, diagnostics)];
        let each = || {
            silence.end();
            bar.inc(1);
        };
        let compared = flight::compare((&name, &[]), readers, self.configurations, stop, &each)?;
        drop(robot);
        bar.finish_and_clear();
        Ok(compared)
    }
}

/// Notes settings of ingest: the truth belongs to the scans as they were recorded, in the body frame of the sensor.
/// Deskewing leaves each beam the wall that it hit.
fn note_changed_scans(configurations: &[Configuration], diagnostics: &mut Diagnostics) {
    for Configuration { name, config, .. } in configurations {
        let mut changed = config.changed("ingest");
        changed.retain(|setting| !setting.starts_with("ingest.deskew="));
        if !changed.is_empty() {
            let changed = changed.join(", ");
            diagnostics.note(format_args!("{name} sets {changed}; the truth may not hold for scans read that way"));
        }
    }
}
