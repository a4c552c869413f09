//! `compare --golden`: what every stage makes of a flight against what was kept before.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_evaluate::stage_values::{Difference, StageValue, Values, first_difference, stage_values};
use crosscut_outfile::Keep;
use crosscut_stage::{Frame, Step, counted};
use serde::{Deserialize, Serialize};

use crate::cli::CompareArgs;
use crate::configurations;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::fly::{Flight, How, files_read, fly};
use crate::interrupt::stop_on_interrupt;
use crate::outputs::Document;
use crate::say::{say, show};
use crate::{progress, text_file, typeset};

/// The files of a folder: what the stages made, an object a revolution; the settings; tolerances by value.
const VALUES: &str = "stages.jsonl";
const SETTINGS: &str = "settings.toml";
const TOLERANCE: &str = "tolerance.json";

/// The tolerance of values that have none of their own, as a share of the value, or of a thousandth for smaller ones. Machines
/// round otherwise.
const DEFAULT_TOLERANCE: f64 = 1e-9;

/// What the stages made of a revolution, by `stage.value`.
#[derive(Serialize, Deserialize)]
struct Kept {
    seq: u64,
    values: BTreeMap<String, Values>,
}

impl Kept {
    fn of(frame: &Frame) -> Self {
        let values = stage_values(frame, false);
        let named = |value: StageValue| (name(&value), value.value);
        Self { seq: frame.revolution.seq, values: values.into_iter().map(named).collect() }
    }
}

fn name(value: &StageValue) -> String {
    format!("{}.{}", value.step, value.field)
}

/// A revolution that differs from what was kept.
struct Divergent {
    seq: u64,
    /// `None` if only one of the two has the revolution.
    first: Option<Difference>,
    words: String,
}

/// Flies one configuration and compares it with the folder, or keeps it there.
pub(super) fn compare(args: &CompareArgs, folder: &Path, registry: &Registry) -> anyhow::Result<Outcome> {
    let default = ["default".to_owned()];
    let with = if args.with.is_empty() { &default[..] } else { &args.with };
    let [of] = &configurations::named(with, &args.set, registry)?[..] else {
        return Err(UsageError("--golden keeps one configuration: one --with".to_owned()).into());
    };
    let mut read = files_read(&args.input, configurations::files(with))?;
    let file = |name: &str| folder.join(name);
    let golden = if args.update { None } else { Some(Golden::read(folder)?) };
    if !args.update {
        read.extend([VALUES, SETTINGS, TOLERANCE].map(file));
    }
    let stop = stop_on_interrupt()?;
    let mut junit = args.junit.as_ref().map(|path| Document::create(path, &read, Keep::ThroughKill)).transpose()?;
    let mut flight = Flight::open(&args.input.recordings.input, &args.input, &of.config)?;
    let bar = progress::bar(flight.total_revolutions(), args.quiet);
    let how = How { registry, stop: &stop, bar: &bar, rate: None, has_poses: false };
    let (mut kept, mut seen, mut divergent) = (String::new(), Vec::new(), Vec::new());
    let flown = fly(flight, &of.config, &how, &mut [], &mut |frame, _| {
        match &golden {
            None => kept += &(serde_json::to_string(&Kept::of(frame))? + "\n"),
            Some(golden) => {
                seen.push(frame.revolution.seq);
                divergent.extend(golden.divergent(frame));
            }
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    let mut diagnostics = Diagnostics::default();
    flown.report(None, &mut diagnostics);
    if diagnostics.ended_early() {
        return Ok(diagnostics.outcome());
    }
    let Some(golden) = golden else {
        let revolutions = counted(flown.summary.revolutions, "revolution");
        keep(folder, &read, &kept, &of.config.to_string())?;
        say(format_args!("kept {revolutions} in {}", folder.display()));
        return Ok(diagnostics.outcome());
    };
    divergent.extend(golden.missing(&seen));
    divergent.sort_by_key(|of| of.seq);
    if let Some(out) = &mut junit {
        out.write(&junit_xml(&golden, &seen, &divergent))?;
    }
    golden.note_settings(&of.config.to_string(), &mut diagnostics);
    if !args.quiet {
        show(golden.conclusion(&divergent))?;
    }
    Ok(if divergent.is_empty() { diagnostics.outcome() } else { Outcome::Different })
}

/// Writes a folder. Tolerances that are there stay.
fn keep(folder: &Path, read: &[PathBuf], kept: &str, settings: &str) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let write = |name: &str, text: &str| Document::create(&folder.join(name), read, Keep::ThroughKill)?.write(text);
    if !folder.join(TOLERANCE).exists() {
        write(TOLERANCE, &format!("{{\"default\": {DEFAULT_TOLERANCE:e}}}\n"))?;
    }
    write(SETTINGS, settings)?;
    write(VALUES, kept)
}

/// A folder that was read.
struct Golden {
    folder: PathBuf,
    revolutions: BTreeMap<u64, BTreeMap<String, Values>>,
    settings: String,
    tolerances: BTreeMap<String, f64>,
}

impl Golden {
    fn read(folder: &Path) -> anyhow::Result<Self> {
        let unread = |name: &str, error: io::Error| {
            UsageError(format!("{error}: {}; --update keeps what the stages make now", folder.join(name).display()))
        };
        let text = |name: &str| text_file::read(&folder.join(name)).map_err(|error| unread(name, error));
        let wrong = |number: usize, error: &dyn std::fmt::Display| {
            UsageError(format!("line {}: {error}: {}", number + 1, folder.join(VALUES).display()))
        };
        let line = |(number, line): (usize, io::Result<String>)| {
            let line = line.map_err(|error| wrong(number, &error))?;
            let kept: Kept = serde_json::from_str(&line).map_err(|error| wrong(number, &error))?;
            anyhow::Ok((kept.seq, kept.values))
        };
        let tolerances = if folder.join(TOLERANCE).exists() { text(TOLERANCE)? } else { "{}".to_owned() };
        let tolerances: BTreeMap<String, f64> = serde_json::from_str(&tolerances)
            .map_err(|error| UsageError(format!("{error}: {}", folder.join(TOLERANCE).display())))?;
        let lines = text_file::lines(&folder.join(VALUES)).map_err(|error| unread(VALUES, error))?;
        let revolutions = lines.enumerate().map(line).collect::<anyhow::Result<_>>()?;
        let golden = Self { folder: folder.to_owned(), revolutions, settings: text(SETTINGS)?, tolerances };
        golden.refuse_unknown_tolerances()?;
        Ok(golden)
    }

    fn refuse_unknown_tolerances(&self) -> Result<(), UsageError> {
        let known: Vec<&str> = stage_values(&Frame::default(), false).iter().map(|value| value.field).collect();
        match self.tolerances.keys().find(|name| *name != "default" && !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) => Err(UsageError(format!(
                "{name}: {}; {}",
                self.folder.join(TOLERANCE).display(),
                crosscut_detector::nearest_and_all(name, &known)
            ))),
        }
    }

    fn tolerance(&self, field: &str) -> f64 {
        let of = |name: &str| self.tolerances.get(name).copied();
        of(field).or_else(|| of("default")).unwrap_or(DEFAULT_TOLERANCE)
    }

    /// How a revolution differs from what was kept, if it does.
    fn divergent(&self, frame: &Frame) -> Option<Divergent> {
        let seq = frame.revolution.seq;
        let Some(kept) = self.revolutions.get(&seq) else {
            return Some(Divergent { seq, first: None, words: "it was not kept".to_owned() });
        };
        let now = stage_values(frame, false);
        let of_kept = |value: &StageValue| {
            let kept = kept.get(&name(value)).cloned().unwrap_or_else(|| Values::Words(vec!["not kept".to_owned()]));
            StageValue { value: kept, ..value.clone() }
        };
        let kept: Vec<StageValue> = now.iter().map(of_kept).collect();
        let first = first_difference(&kept, &now, |field| self.tolerance(field))?;
        let [was, is] = &first.values;
        let words = format!("{}: {} was {was}, now {is}", first.step, first.field);
        Some(Divergent { seq, first: Some(first), words })
    }

    /// The revolutions that were kept and are not among those `seen`.
    fn missing(&self, seen: &[u64]) -> Vec<Divergent> {
        let missing = self.revolutions.keys().filter(|seq| !seen.contains(seq));
        missing.map(|&seq| Divergent { seq, first: None, words: "it is missing now".to_owned() }).collect()
    }

    /// Notes settings other than those that were kept: they explain differences.
    fn note_settings(&self, now: &str, diagnostics: &mut Diagnostics) {
        let values = |text: &str| -> Vec<String> {
            text.lines().map(|line| line.split('#').next().unwrap_or_default().trim().to_owned()).collect()
        };
        let (was, now) = (values(&self.settings), values(now));
        let changed: Vec<&str> =
            now.iter().filter(|line| line.contains('=') && !was.contains(line)).map(String::as_str).collect();
        if !changed.is_empty() {
            let folder = self.folder.display();
            diagnostics.note(format_args!("settings other than in {folder}/{SETTINGS}: {}", changed.join(", ")));
        }
    }

    /// The first divergent revolution, and how many there are, by the stage at which they begin to differ.
    fn conclusion(&self, divergent: &[Divergent]) -> String {
        let Some(first) = divergent.first() else {
            return format!("all {} as kept in {}\n", self.revolutions.len(), self.folder.display());
        };
        let mut text = format!("revolution {} differs: {}\n", first.seq, first.words);
        let by_stage = |step: Step| {
            let count = divergent.iter().filter_map(|of| of.first.as_ref()).filter(|of| of.step == step.name()).count();
            (count > 0).then(|| format!("{count} from {step} on"))
        };
        let stages: Vec<String> = Step::ALL.into_iter().filter_map(by_stage).collect();
        let alone = divergent.iter().filter(|of| of.first.is_none()).count();
        let alone = (alone > 0).then(|| format!("{alone} only in one of the two"));
        let stages: Vec<String> = stages.into_iter().chain(alone).collect();
        text += &format!("{} of {} differ: {}\n", divergent.len(), self.revolutions.len(), stages.join(", "));
        text
    }
}

/// A test for each revolution of either.
fn junit_xml(golden: &Golden, seen: &[u64], divergent: &[Divergent]) -> String {
    let mut all: Vec<u64> = seen.iter().copied().chain(golden.revolutions.keys().copied()).collect();
    all.sort_unstable();
    all.dedup();
    let case = |seq: &u64| {
        let name = format!("    <testcase classname=\"golden\" name=\"revolution {seq}\"");
        match divergent.iter().find(|of| of.seq == *seq) {
            None => format!("{name}/>\n"),
            Some(of) => {
                format!("{name}><failure message=\"{}\"/></testcase>\n", typeset::escaped(&of.words))
            }
        }
    };
    let cases: String = all.iter().map(case).collect();
    let counts = format!("tests=\"{}\" failures=\"{}\"", all.len(), divergent.len());
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"crosscut\" {counts}>\n{cases}  \
         </testsuite>\n</testsuites>\n"
    )
}
