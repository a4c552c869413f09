//! `crosscut evaluate`: compares configurations with the truth in recordings.

mod scoring;
mod wrong;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_evaluate::experiment::{self, Experiment};
use crosscut_evaluate::flights::FlightFigures;
use crosscut_evaluate::times::Stopwatch;
use crosscut_evaluate::{Evaluation, Scoreboard, tables};
use crosscut_ingest::Truths;
use crosscut_outfile::Keep;
use serde_json::json;

use crate::cli::EvaluateArgs;
use crate::configurations::{self, Configuration};
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::fly::{Flight, How, each_of, files_read};
use crate::interrupt::stop_on_interrupt;
use crate::looking::{Look, Looks, WrongAnswer};
use crate::outputs::Document;
use crate::run_log::Run;
use crate::say::{say, show};
use crate::{looking, outputs, progress, typeset};

use self::scoring::{Answered, FlightTime};

/// Runs every configuration on every recording and compares the results with the truth.
pub(crate) fn evaluate(args: &EvaluateArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let stop = stop_on_interrupt()?; // before any recording is looked through
    let default = ["default".to_owned()];
    let with = if args.with.is_empty() { &default[..] } else { &args.with };
    let columns = configurations::named(with, &args.set, registry)?;
    let read = files_read(&args.input, configurations::files(with))?;
    let mut diagnostics = Diagnostics::default();
    let input = each_of(&args.input.recordings.input, &mut diagnostics)?;
    refuse_equal("families", input.iter().map(|path| family_of(path)))?;
    refuse_equal("configurations", columns.iter().map(|column| column.name.clone()))?;
    if let Some(folder) = &args.draw_wrong {
        for (family, column) in
            input.iter().flat_map(|path| columns.iter().map(move |column| (family_of(path), column)))
        {
            wrong::paths(folder, &family, &column.name).iter().try_for_each(|path| outputs::refuse(&[path], &read))?;
        }
    }
    note_changed_scans(&columns, &mut diagnostics);
    let (recordings, revolutions) = with_truth(input, args, &columns, &mut diagnostics)?;
    let mut outputs = Outputs::open(args, &read)?;

    let bar = progress::bar(revolutions, args.quiet);
    let how = How { registry, stop: &stop, bar: &bar, rate: None, has_poses: false };
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let (mut scoreboard, mut experiment) = (Scoreboard::new(names.clone()), Experiment::new(names.clone()));
    let mut stopwatch = Stopwatch::new(names);
    let options = configurations::run_options(&args.input, with, &args.set);
    let (mut wrong, mut time) = (0, FlightTime::default());
    let mut to_look: Option<String> = None;
    'all: for (number, path) in recordings.iter().enumerate() {
        let family = family_of(path);
        for (place, column) in columns.iter().enumerate() {
            let whose = format!("{}, in {}", column.name, path.display());
            if stop.is_set() {
                diagnostics.interrupted(format_args!("at {whose}; what is written covers what came before"));
                break 'all;
            }
            let scored = scoring::score(path, &args.input, &column.config, &how)?;
            bar.suspend(|| scored.report(&whose, &mut diagnostics));
            scoreboard.merge(&family, place, &scored.evaluation);
            for Answered { seq, is_right, timings } in &scored.answered {
                experiment.add(&family, place, *seq, *is_right);
                stopwatch.add(place, number, *seq, timings);
            }
            if let Some((figures, taken)) = scored.flight {
                scoreboard.add_flight(&family, place, &figures);
                time.merge(taken);
            }
            if let Some(folder) = &args.draw_wrong {
                let drawn = scored.wrong.write(folder, &family, &column.name);
                diagnostics.lost_all(drawn.err().map(|error| format!("{error:#}")));
                wrong += scored.wrong.count();
                if let (None, Some(seq)) = (&to_look, scored.wrong.first_seq()) {
                    let look = Look::of(std::slice::from_ref(path), &options[place], &family);
                    let record = look.record.as_ref().map(|record| format!("{record}; ")).unwrap_or_default();
                    to_look = Some(format!("{record}{}", look.at(seq)));
                }
            }
        }
    }
    bar.finish_and_clear();

    if let Some(words) = time.words().filter(|_| !args.quiet) {
        say(words);
    }
    if args.draw_wrong.is_some() && wrong == 0 && !diagnostics.ended_early() {
        say("every answer is right, so nothing is drawn");
    }
    if let Some(commands) = to_look.filter(|_| !args.quiet) {
        say(format_args!("to see the first wrong answer stage by stage: {commands}"));
    }
    if let Some(log) = &args.log {
        let kept = keep(log, &scoreboard, &columns, &recordings, registry);
        diagnostics.lost_all(kept.err().map(|error| format!("{error:#}")));
    }
    let outcomes = experiment.outcomes();
    let evaluated =
        Evaluated { scoreboard, outcomes: &outcomes, stopwatch, looks: Looks { flights: &recordings, options } };
    outputs.write(&evaluated, &columns, diagnostics.problems())?;
    Ok(diagnostics.outcome())
}

/// Appends the figures of each configuration to a history of runs.
fn keep(
    log: &Path,
    scoreboard: &Scoreboard,
    columns: &[Configuration],
    recordings: &[PathBuf],
    registry: &Registry,
) -> anyhow::Result<()> {
    let run = Run::of("evaluate", recordings);
    columns.iter().zip(scoreboard.all()).try_for_each(|(Configuration { name, config }, evaluation)| {
        let figures = evaluation.figures();
        let figures = json!({
            "revolutions": figures.revolutions,
            "right": figures.right.value(),
            "right_count": figures.right_count.value(),
        });
        run.append(log, name, config, registry, figures)
    })
}

/// The name of a recording's family.
fn family_of(recording: &Path) -> String {
    recording.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Refuses two equal names: tables could not distinguish them, and pictures of one would replace those of the other.
fn refuse_equal(what: &str, names: impl Iterator<Item = String>) -> Result<(), UsageError> {
    let mut known = BTreeSet::new();
    for name in names {
        if !known.insert(name.clone()) {
            return Err(UsageError(format!("two {what} are named {name}; rename a file, or leave one out")));
        }
    }
    Ok(())
}

/// Returns the recordings that can be evaluated, and the number of revolutions to process if it is known. A recording
/// that cannot be read or has no truth is left out, unless no other is left.
fn with_truth(
    recordings: Vec<PathBuf>,
    args: &EvaluateArgs,
    columns: &[Configuration],
    diagnostics: &mut Diagnostics,
) -> anyhow::Result<(Vec<PathBuf>, Option<u64>)> {
    let messages_in = |path: &PathBuf| {
        let flight = Flight::open(std::slice::from_ref(path), &args.input, &columns[0].config);
        if !flight.as_ref().is_ok_and(Flight::has_truths) {
            Truths::open(path)?;
        }
        anyhow::Ok(flight?.total_revolutions())
    };
    let (mut kept, mut sum, mut refused) = (Vec::new(), Some(0), Vec::new());
    for path in recordings {
        match messages_in(&path) {
            Ok(messages) => {
                sum = sum.zip(messages).map(|(sum, messages)| sum + messages * columns.len() as u64);
                kept.push(path);
            }
            Err(error) => refused.push(error),
        }
    }
    if kept.is_empty() {
        // The last error ends the command, which prints it.
        let last = refused.pop();
        refused.iter().for_each(|error| diagnostics.error(format_args!("{error:#}")));
        return last.map_or(Ok((kept, sum)), Err);
    }
    refused.iter().for_each(|error| diagnostics.error(format_args!("left out: {error:#}")));
    Ok((kept, sum))
}

/// Notes settings of ingest: the truth belongs to the scans as they were recorded, in the body frame of the sensor.
/// Deskewing leaves each beam the wall that it hit.
fn note_changed_scans(columns: &[Configuration], diagnostics: &mut Diagnostics) {
    for Configuration { name, config } in columns {
        let mut changed = config.changed("ingest");
        changed.retain(|setting| !setting.starts_with("ingest.deskew="));
        if !changed.is_empty() {
            let changed = changed.join(", ");
            diagnostics.note(format_args!("{name} sets {changed}; the truth may not hold for scans read that way"));
        }
    }
}

/// What is known of all configurations.
struct Evaluated<'a> {
    scoreboard: Scoreboard,
    outcomes: &'a [experiment::Outcome],
    stopwatch: Stopwatch,
    looks: Looks<'a>,
}

/// The output files, opened before the work begins.
struct Outputs<'a> {
    args: &'a EvaluateArgs,
    json: Option<Document>,
    markdown: Option<Document>,
}

impl<'a> Outputs<'a> {
    fn open(args: &'a EvaluateArgs, read: &[PathBuf]) -> anyhow::Result<Self> {
        if args.json.is_some() && args.json == args.markdown {
            return Err(UsageError("--json and --markdown name the same file".to_owned()).into());
        }
        let outputs: Vec<_> = args.json.iter().chain(&args.markdown).map(PathBuf::as_path).collect();
        outputs::refuse(&outputs, read)?;
        if let Some(folder) = &args.draw_wrong {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let open = |path: &PathBuf| Document::create(path, read, Keep::ThroughKill);
        let (json, markdown) = (args.json.as_ref().map(open), args.markdown.as_ref().map(open));
        Ok(Self { args, json: json.transpose()?, markdown: markdown.transpose()? })
    }

    fn write(&mut self, of: &Evaluated<'_>, columns: &[Configuration], problems: &[String]) -> anyhow::Result<()> {
        let Evaluated { scoreboard, outcomes, stopwatch, looks } = of;
        let details = self.args.details;
        let hint = looks.hint(outcomes, (!details).then_some("--details"));
        let wrong = looks.wrong_answers(outcomes);
        let sentences: Vec<String> = experiment::sentences(outcomes).into_iter().chain(hint).collect();
        let mut shown = tables::overview(scoreboard);
        shown.extend(experiment::tables(outcomes));
        if details {
            shown.extend(tables::details(scoreboard));
        }
        if let Some(out) = &mut self.json {
            let settings: Vec<_> = columns.iter().map(|column| column.config.to_string()).collect();
            out.write(&json(scoreboard, outcomes, &wrong, &settings, problems))?;
        }
        if let Some(out) = &mut self.markdown {
            let problems: String = problems.iter().map(|problem| format!("{problem}\n\n")).collect();
            let sentences: String = sentences.iter().map(|sentence| format!("{}\n\n", sentence.trim())).collect();
            out.write(&(sentences + &typeset::markdown(&shown) + &problems))?;
        }
        let stdout_is_taken = [&self.args.json, &self.args.markdown].into_iter().flatten().any(|p| p == Path::new("-"));
        if !self.args.quiet && !stdout_is_taken {
            // Files hold no times, so that they are the same whenever they are made.
            shown.extend(stopwatch.table("one after the other"));
            shown.extend(looking::table(&wrong).filter(|_| details));
            let sentences: String = sentences.iter().map(|sentence| format!("{sentence}\n")).collect();
            let space = if sentences.is_empty() { "" } else { "\n" };
            show(format_args!("{sentences}{space}{}", typeset::text(&shown)))?;
        }
        Ok(())
    }
}

/// All figures by family and configuration, the complete `settings` of each configuration, and the problems.
fn json(
    scoreboard: &Scoreboard,
    outcomes: &[experiment::Outcome],
    wrong: &[WrongAnswer<'_>],
    settings: &[String],
    problems: &[String],
) -> String {
    let names = scoreboard.configurations();
    let configurations: Vec<_> =
        names.iter().zip(settings).map(|(name, toml)| json!({"name": name, "settings": toml})).collect();
    let results = |evaluations: &[Evaluation], flights: &[Option<FlightFigures>]| -> Vec<_> {
        let named = names.iter().zip(evaluations).zip(flights);
        let result = |((name, of), flight): ((&String, &Evaluation), &Option<FlightFigures>)| {
            let mut result = json!({"configuration": name, "figures": of.figures()});
            if let Some(flight) = flight {
                result["flight"] = json!(flight);
            }
            result
        };
        named.map(result).collect()
    };
    let families: Vec<_> = scoreboard
        .families()
        .iter()
        .map(|family| json!({"family": family.name, "results": results(&family.evaluations, &family.flights)}))
        .collect();
    let document = json!({
        "configurations": configurations,
        "verdicts": outcomes,
        "wrong_answers": wrong,
        "families": families,
        "all": results(&scoreboard.all(), &scoreboard.all_flights()),
        "problems": problems,
    });
    format!("{document:#}\n")
}
