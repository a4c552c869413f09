//! `crosscut simulate`: flights, and suites of scenes, with truth.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{Args, ValueEnum};
use crosscut_pipeline::StopFlag;
use crosscut_simulator::{Flight, SCENES, Scene, Split, Suite, scenarios, suites, write_mcap};
use crosscut_stage::counted;

use crate::exit::{Outcome, UsageError, chosen};
use crate::input::text_file::of_plan;
use crate::interrupt::stop_on_interrupt;
use crate::output::{files, progress, say, show};
use crate::values::{has_extension, number};

#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Scenario of the flight; --list shows them.
    #[arg(conflicts_with = "suite")]
    scenario: Option<String>,
    /// Plan of a mine to fly through, all of it: {"nodes":[{"id","x_m","y_m"}],"edges":[{"from","to","width_m","via_m"}]}.
    /// `"start":{"node","towards"}` is where to start and which node to face, else the first dead end.
    #[arg(long, value_name = "PLAN.json", conflicts_with_all = ["scenario", "suite"])]
    plan: Option<PathBuf>,
    /// Family of scenes for evaluation, instead of a flight; `all` for every family.
    #[arg(long, value_name = "NAME")]
    suite: Option<String>,
    /// Scenes of the suite: parameters are chosen on dev, results are reported on report.
    #[arg(long, value_enum, default_value = "dev", requires = "suite", conflicts_with = "scenario")]
    split: SplitArg,
    /// Output: FLIGHT.mcap for a scenario, a folder for suites.
    #[arg(short, long, value_name = "PATH", value_parser = PathBufValueParser::new().try_map(mcap_path))]
    out: Option<PathBuf>,
    /// Seed of the random numbers; the same seed gives the same bytes.
    #[arg(long, default_value_t = 1, conflicts_with = "suite", value_parser = number::<u64>, allow_negative_numbers = true)]
    seed: u64,
    /// Drift of the odometry of a flight, as a share of its way; its heading drifts by a tenth of it in rad per metre. `none`:
    /// a flight without odometry.
    #[arg(long, value_name = "SHARE|none", value_parser = drift, allow_negative_numbers = true, conflicts_with = "suite")]
    drift: Option<Drift>,
    /// List the scenarios and suites.
    #[arg(long)]
    list: bool,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SplitArg {
    /// To choose parameters on.
    Dev,
    /// To report on.
    Report,
}

/// How odometry drifts.
#[derive(Clone, Copy, Debug)]
enum Drift {
    /// There is none.
    NoOdometry,
    /// By this share of the way.
    Share(f64),
}

fn drift(text: &str) -> Result<Drift, String> {
    if text == "none" {
        return Ok(Drift::NoOdometry);
    }
    let share = text.parse().ok().filter(|share| (0.0..=0.5).contains(share));
    share.map(Drift::Share).ok_or_else(|| "the drift is a share of the way, from 0 to 0.5, or none".to_owned())
}

fn mcap_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if has_extension(&path, "rrd") {
        return Err("the output is an MCAP recording, not one for the Rerun viewer: FLIGHT.mcap");
    }
    Ok(path)
}

/// Writes a flight or suites, or lists what there is.
pub(crate) fn simulate(args: &SimulateArgs) -> anyhow::Result<Outcome> {
    let stop = stop_on_interrupt()?;
    let out = args.out.as_deref();
    if out == Some(Path::new("-")) {
        return Err(UsageError("simulate writes to a file, not to standard output".to_owned()).into());
    }
    if let (Some(plan), false) = (&args.plan, args.list) {
        let out = out.ok_or_else(|| UsageError("--out is missing: a file for the flight".to_owned()))?;
        return planned(plan, args, out, &stop);
    }
    match (&args.scenario, &args.suite, out) {
        _ if args.list => list(),
        (Some(scenario), None, Some(out)) => flight(scenario, args, out, &stop),
        (None, Some(suite), Some(out)) => suite_into(suite, args, out, &stop),
        (Some(_), _, None) | (_, Some(_), None) => {
            Err(UsageError("--out is missing: a file for a scenario, a folder for a suite".to_owned()).into())
        }
        _ => Err(UsageError(
            "name a scenario, --suite NAME or --plan PLAN.json; --list shows scenarios and suites".to_owned(),
        )
        .into()),
    }
}

fn list() -> anyhow::Result<Outcome> {
    let mut text = String::from("scenarios, each one flight:\n");
    for scenario in scenarios() {
        text += &format!("  {:<16}{}\n", scenario.name, scenario.doc);
    }
    text += "\nsuites, each many scenes (--suite NAME, or --suite all):\n";
    for suite in suites() {
        text += &format!("  {:<16}{}\n", suite.name, suite.doc);
    }
    show(text)?;
    Ok(Outcome::Done)
}

fn flight(name: &str, args: &SimulateArgs, out: &Path, stop: &StopFlag) -> anyhow::Result<Outcome> {
    let scenario = chosen("scenario", name, scenarios(), |scenario| scenario.name)?;
    write(out, with_odometry((scenario.fly)(args.seed), args), None, args.quiet, stop)
}

/// The flight with the odometry that was asked for.
fn with_odometry(flight: Flight, args: &SimulateArgs) -> Flight {
    match args.drift {
        Some(Drift::NoOdometry) => flight.without_odometry(),
        Some(Drift::Share(share)) => flight.with_drift(share, args.seed),
        None => flight,
    }
}

/// A flight through all of the mine of a plan.
fn planned(path: &Path, args: &SimulateArgs, out: &Path, stop: &StopFlag) -> anyhow::Result<Outcome> {
    files::refuse(&[out], &[path.to_owned()])?;
    let flight = of_plan(path, |plan| plan.fly(args.seed))?;
    write(out, with_odometry(flight, args), None, args.quiet, stop)
}

fn suite_into(name: &str, args: &SimulateArgs, folder: &Path, stop: &StopFlag) -> anyhow::Result<Outcome> {
    let suites: Vec<&Suite> = match name {
        ALL => suites().iter().collect(),
        name => vec![chosen("suite", name, suites(), |suite| suite.name)?],
    };
    if folder.is_file() {
        return Err(UsageError(format!("{} is a file; --suite writes a folder", folder.display())).into());
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let split = match args.split {
        SplitArg::Dev => Split::Dev,
        SplitArg::Report => Split::Report,
    };
    for suite in suites {
        let path = folder.join(format!("{}.mcap", suite.name));
        let outcome = if stop.is_set() {
            Outcome::Interrupted
        } else {
            write(&path, suite.scenes(split), Some(SCENES as u64), args.quiet, stop)?
        };
        if outcome != Outcome::Done {
            return Ok(outcome);
        }
    }
    Ok(Outcome::Done)
}

/// Selects every suite.
const ALL: &str = "all";

/// Writes a complete file, with fewer scenes if `stop` is set.
fn write(
    path: &Path,
    scenes: impl Iterator<Item = Scene>,
    total: Option<u64>,
    quiet: bool,
    stop: &StopFlag,
) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::Done;
    let scenes = scenes.take_while(|_| {
        if stop.is_set() {
            outcome = Outcome::Interrupted;
        }
        outcome == Outcome::Done
    });
    let bar = progress::bar(total, quiet);
    let written = write_mcap(path, bar.wrap_iter(scenes))?;
    bar.finish_and_clear();
    if !quiet {
        let interrupted = if outcome == Outcome::Done { "" } else { "interrupted: " };
        let written = counted(u64::from(written), "revolution");
        say(format_args!("{interrupted}{written} with truth: {}", path.display()));
    }
    Ok(outcome)
}
