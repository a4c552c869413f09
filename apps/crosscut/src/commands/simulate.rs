//! `crosscut simulate`: flights, and suites of scenes, with truth.

use std::path::Path;

use anyhow::Context;
use crosscut_pipeline::StopFlag;
use crosscut_simulator::{Flight, Plan, SCENES, Scene, Split, Suite, scenarios, suites, write_mcap};
use crosscut_stage::counted;

use crate::cli::{Drift, SimulateArgs, SplitArg};
use crate::exit::{Outcome, UsageError};
use crate::interrupt::stop_on_interrupt;
use crate::say::{say, show};
use crate::text_file;
use crate::{outputs, progress};

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
    let scenario = scenarios().iter().find(|scenario| scenario.name == name);
    let scenario = scenario.ok_or_else(|| unknown("scenario", name, scenarios().iter().map(|s| s.name)))?;
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
    outputs::refuse(&[out], &[path.to_owned()])?;
    let in_plan = |error: &dyn std::fmt::Display| UsageError(format!("{}: {error}", path.display()));
    let text = text_file::read(path).map_err(|error| in_plan(&error))?;
    let flight = Plan::from_json(&text).and_then(|plan| plan.fly(args.seed)).map_err(|error| in_plan(&error))?;
    write(out, with_odometry(flight, args), None, args.quiet, stop)
}

fn suite_into(name: &str, args: &SimulateArgs, folder: &Path, stop: &StopFlag) -> anyhow::Result<Outcome> {
    let chosen: Vec<&Suite> = suites().iter().filter(|suite| name == ALL || suite.name == name).collect();
    if chosen.is_empty() {
        return Err(unknown("suite", name, suites().iter().map(|s| s.name)).into());
    }
    if folder.is_file() {
        return Err(UsageError(format!("{} is a file; --suite writes a folder", folder.display())).into());
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let split = match args.split {
        SplitArg::Dev => Split::Dev,
        SplitArg::Report => Split::Report,
    };
    for suite in chosen {
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

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> UsageError {
    UsageError(format!("there is no {what} {name:?}; there are: {}", known.collect::<Vec<_>>().join(", ")))
}
