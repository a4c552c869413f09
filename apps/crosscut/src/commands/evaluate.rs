//! `crosscut evaluate`: configurations side by side, against the truth in recordings.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::{Evaluation, Scoreboard, tables};
use crosscut_ingest::{ReadOptions, Truths, recordings_in};
use crosscut_pipeline::{End, Registry, StopFlag};
use serde_json::json;

use crate::cli::EvaluateArgs;
use crate::configurations::{self, Configuration};
use crate::exit::{Outcome, UsageError};
use crate::interrupt::stop_on_interrupt;
use crate::say::say;
use crate::scoring::{self, Scored};
use crate::{outputs, progress, typeset};

/// Runs every configuration over every recording, and compares the results with the truth.
pub(crate) fn evaluate(args: &EvaluateArgs) -> anyhow::Result<Outcome> {
    let registry = Registry::standard();
    let default = ["default".to_owned()];
    let with = if args.with.is_empty() { &default[..] } else { &args.with };
    let columns = configurations::named(with, &args.set, &registry)?;
    let input = recordings_in(&args.input)?;
    refuse_equal("families", input.iter().map(|path| family_of(path)))?;
    refuse_equal("configurations", columns.iter().map(|column| column.name.clone()))?;
    let read: Vec<_> = input.iter().cloned().chain(configurations::files(with)).collect();
    say_what_changes_the_scans(&columns);
    let mut problems = Problems::default();
    let (recordings, revolutions) = with_truth(input, args, &columns, &mut problems)?;
    let mut outputs = Outputs::open(args, &read)?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;

    let bar = progress::bar(revolutions, args.quiet);
    let mut scoreboard = Scoreboard::new(columns.iter().map(|column| column.name.clone()).collect());
    let (options, mut wrong) = (read_options(args), 0);
    'all: for path in &recordings {
        let family = family_of(path);
        for (place, column) in columns.iter().enumerate() {
            if stop.is_set() {
                problems.interrupt(path, &column.name);
                break 'all;
            }
            let scored = scoring::score(path, &options, &column.config, &registry, &stop, &bar)?;
            problems.note(path, &column.name, &scored);
            scoreboard.merge(&family, place, &scored.evaluation);
            if let Some(folder) = &args.draw_wrong {
                if let Err(error) = scored.wrong.write(folder, &family, &column.name) {
                    problems.not_written(&error);
                }
                wrong += scored.wrong.count();
            }
        }
    }
    bar.finish_and_clear();

    if let Some(place) = problems.interrupted.clone() {
        problems.say(format!("interrupted {place}: the figures are of what was compared before that"));
    }
    for problem in &problems.sentences {
        say(problem);
    }
    if args.draw_wrong.is_some() && wrong == 0 && !problems.failed && problems.interrupted.is_none() {
        say("nothing is wrong, so nothing is drawn");
    }
    outputs.write(&scoreboard, &columns, &problems.sentences)?;
    Ok(problems.outcome())
}

fn read_options(args: &EvaluateArgs) -> ReadOptions {
    ReadOptions { topic: args.topic.clone(), read_as: args.read_as, ..ReadOptions::default() }
}

/// The family that a recording is.
fn family_of(recording: &Path) -> String {
    recording.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Two of the same name could not be told apart in the tables, and pictures of one would replace those of the other.
fn refuse_equal(what: &str, names: impl Iterator<Item = String>) -> Result<(), UsageError> {
    let mut known = BTreeSet::new();
    for name in names {
        if !known.insert(name.clone()) {
            return Err(UsageError(format!("two {what} are named {name}; rename a file, or leave one out")));
        }
    }
    Ok(())
}

/// The recordings that can be evaluated, and how many revolutions there are to go through, if that is known. Of several
/// one that cannot be read, or has no truth, is left out, and the others count.
fn with_truth(
    recordings: Vec<PathBuf>,
    args: &EvaluateArgs,
    columns: &[Configuration],
    problems: &mut Problems,
) -> anyhow::Result<(Vec<PathBuf>, Option<u64>)> {
    let options = read_options(args);
    let messages_in = |path: &Path| {
        Truths::open(path)?;
        anyhow::Ok(scoring::open(path, &options, &columns[0].config)?.total_messages())
    };
    let (mut kept, mut sum, mut refused) = (Vec::new(), Some(0), None);
    for path in recordings {
        match messages_in(&path) {
            Ok(messages) => {
                sum = sum.zip(messages).map(|(sum, messages)| sum + messages * columns.len() as u64);
                kept.push(path);
            }
            Err(error) => {
                problems.leave_out(&error);
                refused.get_or_insert(error);
            }
        }
    }
    match refused {
        Some(error) if kept.is_empty() => Err(error),
        _ => Ok((kept, sum)),
    }
}

/// A truth is of the scans as they were recorded, in the body frame of the sensor as it is mounted.
fn say_what_changes_the_scans(columns: &[Configuration]) {
    for Configuration { name, config } in columns {
        let changed = config.changed("ingest");
        if !changed.is_empty() {
            let changed = changed.join(", ");
            say(format_args!(
                "note: {name} sets {changed}: where the truth is not of such scans, the figures say nothing"
            ));
        }
    }
}

/// What went wrong, each once, however many configurations met it.
#[derive(Default)]
struct Problems {
    sentences: Vec<String>,
    failed: bool,
    /// Where something was left to do.
    interrupted: Option<String>,
}

impl Problems {
    fn note(&mut self, path: &Path, configuration: &str, scored: &Scored) {
        for loss in &scored.losses {
            self.say(format!("lost: {loss}"));
        }
        let compared = scored.evaluation.revolutions();
        let file = path.display();
        match &scored.end {
            End::Failed(failure) => {
                self.failed = true;
                self.say(format!("error: {configuration}: {failure}; the {compared} before it count, in {file}"));
            }
            End::Complete if compared == 0 => {
                self.failed = true;
                self.say(format!("error: no scan could be compared with its truth, in {file}"));
            }
            // Nothing is written here: it is a defect of the scoring, which must not pass for a shorter flight.
            End::ResultsLost(error) => {
                self.failed = true;
                self.say(format!(
                    "error: {configuration}: a result cannot be scored: {error}; the {compared} before it count, in {file}"
                ));
            }
            End::Interrupted => self.interrupt(path, configuration),
            End::Complete => {}
        }
    }

    /// From here on something was left to do. Configurations side by side are of equally many revolutions before it.
    fn interrupt(&mut self, path: &Path, configuration: &str) {
        self.interrupted.get_or_insert_with(|| format!("at {configuration}, in {}", path.display()));
    }

    /// A recording that cannot be evaluated.
    fn leave_out(&mut self, error: &anyhow::Error) {
        self.failed = true;
        self.say(format!("error: left out: {error:#}"));
    }

    /// A picture that cannot be written; the figures do not depend on it.
    fn not_written(&mut self, error: &anyhow::Error) {
        self.say(format!("lost: {error:#}"));
    }

    fn say(&mut self, sentence: String) {
        if !self.sentences.contains(&sentence) {
            self.sentences.push(sentence);
        }
    }

    fn outcome(&self) -> Outcome {
        if self.failed {
            Outcome::Failed
        } else if self.interrupted.is_some() {
            Outcome::Interrupted
        } else if !self.sentences.is_empty() {
            Outcome::SomethingLost
        } else {
            Outcome::Done
        }
    }
}

/// Where the outcome goes; opened before the work begins.
struct Outputs<'a> {
    args: &'a EvaluateArgs,
    json: Option<Box<dyn Write + Send>>,
    markdown: Option<Box<dyn Write + Send>>,
}

impl<'a> Outputs<'a> {
    fn open(args: &'a EvaluateArgs, read: &[PathBuf]) -> anyhow::Result<Self> {
        if args.json.is_some() && args.json == args.markdown {
            return Err(UsageError("--json and --markdown name the same place".to_owned()).into());
        }
        let outputs: Vec<_> = args.json.iter().chain(&args.markdown).map(PathBuf::as_path).collect();
        outputs::refuse(&outputs, read)?;
        if let Some(folder) = &args.draw_wrong {
            std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        let open = |path: &PathBuf| outputs::create(path, read);
        let (json, markdown) = (args.json.as_ref().map(open), args.markdown.as_ref().map(open));
        Ok(Self { args, json: json.transpose()?, markdown: markdown.transpose()? })
    }

    fn write(&mut self, scoreboard: &Scoreboard, columns: &[Configuration], problems: &[String]) -> anyhow::Result<()> {
        let failed = "the outcome cannot be written";
        let mut shown = tables::overview(scoreboard);
        if self.args.details {
            shown.extend(tables::details(scoreboard));
        }
        if let Some(out) = &mut self.json {
            let settings: Vec<_> = columns.iter().map(|column| column.config.to_string()).collect();
            out.write_all(json(scoreboard, &settings, problems).as_bytes()).context(failed)?;
        }
        if let Some(out) = &mut self.markdown {
            let problems: String = problems.iter().map(|problem| format!("{problem}\n\n")).collect();
            out.write_all((typeset::markdown(&shown) + &problems).as_bytes()).context(failed)?;
        }
        let stdout_is_taken = [&self.args.json, &self.args.markdown].into_iter().flatten().any(|p| p == Path::new("-"));
        if !self.args.quiet && !stdout_is_taken {
            std::io::stdout().write_all(typeset::text(&shown).as_bytes()).context(failed)?;
        }
        Ok(())
    }
}

/// Every figure, by family and configuration, with the `settings` of each configuration in full and what went wrong.
fn json(scoreboard: &Scoreboard, settings: &[String], problems: &[String]) -> String {
    let names = scoreboard.configurations();
    let configurations: Vec<_> =
        names.iter().zip(settings).map(|(name, toml)| json!({"name": name, "settings": toml})).collect();
    let results = |evaluations: &[Evaluation]| -> Vec<_> {
        let named = names.iter().zip(evaluations);
        named.map(|(name, of)| json!({"configuration": name, "figures": of.figures()})).collect()
    };
    let families: Vec<_> = scoreboard
        .families()
        .iter()
        .map(|family| json!({"family": family.name, "results": results(&family.evaluations)}))
        .collect();
    let document = json!({
        "configurations": configurations,
        "families": families,
        "all": results(&scoreboard.all()),
        "problems": problems,
    });
    format!("{document:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome_of(end: End) -> (Outcome, Vec<String>) {
        let mut problems = Problems::default();
        let scored = Scored { evaluation: Evaluation::default(), wrong: Default::default(), end, losses: Vec::new() };
        problems.note(Path::new("tee.mcap"), "paper", &scored);
        (problems.outcome(), problems.sentences)
    }

    #[test]
    fn figures_that_a_defect_cut_short_do_not_count_as_complete() {
        let (outcome, sentences) = outcome_of(End::ResultsLost(std::io::Error::other("it panicked: no wall 3")));
        assert_eq!(outcome, Outcome::Failed);
        assert!(sentences[0].contains("paper") && sentences[0].contains("no wall 3"), "{sentences:?}");
    }

    #[test]
    fn an_evaluation_is_interrupted_only_if_something_was_left_to_do() {
        assert_eq!(outcome_of(End::Interrupted), (Outcome::Interrupted, Vec::new()));
    }
}
