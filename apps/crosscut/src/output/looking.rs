//! The commands that show a revolution in the viewer or at the prompt, for texts that name revolutions.

use std::path::{Path, PathBuf};

use crosscut_evaluate::experiment::{FamilyOutcome, Outcome};
use crosscut_evaluate::tables::Table;
use serde::Serialize;

use crate::input::{ConfigArgs, InputArgs};

/// How a flight is looked at.
pub(crate) struct Look {
    /// The command that records it; `None` where the flight is a recording (.rrd) itself.
    pub(crate) record: Option<String>,
    rrd: String,
    /// The flight and the options, as a shell takes them.
    words: String,
}

impl Look {
    /// Of the flight in `inputs`, with these [`options`] of `run`. `name` is that of a recording to be made.
    pub(crate) fn of(inputs: &[PathBuf], options: &[String], name: &str) -> Self {
        let paths = inputs.iter().map(|input| input.to_string_lossy().into_owned());
        let words = line(paths.chain(options.iter().cloned()));
        if let ([only], []) = (inputs, options)
            && only.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd"))
        {
            return Self { record: None, rrd: words.clone(), words };
        }
        let rrd = quoted(&format!("{name}.rrd"));
        Self { record: Some(format!("crosscut run {words} --save {rrd}")), rrd, words }
    }

    /// Of a flight with the settings of a command.
    pub(crate) fn with(input: &InputArgs, config: &ConfigArgs) -> Self {
        let inputs = &input.recordings.input;
        let settings = options(config.preset.as_deref(), config.config.as_deref(), &config.set);
        Self::of(inputs, &[input.options(), settings].concat(), &input.name())
    }

    /// The command that answers at a revolution.
    pub(crate) fn debug(&self, seq: u64) -> String {
        format!("crosscut debug {} --at {seq}", self.words)
    }

    /// The command that opens the viewer at a revolution.
    pub(crate) fn at(&self, seq: u64) -> String {
        format!("crosscut view {} --at {seq}", self.rrd)
    }

    /// The command that opens the viewer at a revolution of two flights side by side.
    pub(crate) fn beside(&self, other: &Self, seq: u64) -> String {
        format!("crosscut view {} --beside {} --at {seq}", self.rrd, other.rrd)
    }
}

/// Settings as options of `run` and `debug`.
pub(crate) fn options(preset: Option<&str>, file: Option<&Path>, settings: &[String]) -> Vec<String> {
    let preset = preset.map(|preset| ["--preset".to_owned(), preset.to_owned()]);
    let file = file.map(|file| ["--config".to_owned(), file.to_string_lossy().into_owned()]);
    let settings = settings.iter().map(|setting| ["--set".to_owned(), setting.clone()]);
    preset.into_iter().chain(file).chain(settings).flatten().collect()
}

/// What an experiment was made of, to look at each of its wrong answers.
pub(crate) struct Looks<'a> {
    /// The name of each flight and its parts; none of flights that cannot be read again.
    pub(crate) flights: Vec<(&'a str, &'a [PathBuf])>,
    /// The [`options`] of each configuration.
    pub(crate) options: Vec<Vec<String>>,
}

/// A revolution that a configuration mends or breaks, and the command that shows the answer that is wrong there: of a broken one
/// its own, of a mended one that of the first configuration.
#[derive(Serialize)]
pub(crate) struct WrongAnswer<'a> {
    configuration: &'a str,
    family: &'a str,
    revolution: u64,
    #[serde(rename = "is")]
    what: &'static str,
    command: String,
}

impl Looks<'_> {
    /// The commands for all revolutions that are mended or broken, those that are broken first.
    pub(crate) fn wrong_answers<'o>(&self, outcomes: &'o [Outcome]) -> Vec<WrongAnswer<'o>> {
        let mut wrong = Vec::new();
        for (what, of) in [
            ("broken", (|family| &family.broken[..]) as fn(&FamilyOutcome) -> &[u64]),
            ("mended", |family| &family.mended),
        ] {
            for (place, outcome) in outcomes.iter().enumerate() {
                let (configuration, place) =
                    (outcome.configuration.as_str(), if what == "broken" { place + 1 } else { 0 });
                for family in outcome.families.iter().filter(|family| !of(family).is_empty()) {
                    let Some(look) = self.look(&family.family, place, "flight") else { continue };
                    let family_name = family.family.as_str();
                    wrong.extend(of(family).iter().map(|&revolution| WrongAnswer {
                        configuration,
                        family: family_name,
                        revolution,
                        what,
                        command: look.debug(revolution),
                    }));
                }
            }
        }
        wrong
    }

    /// How a flight is looked at with the configuration of this place. `name` is that of a recording to be made.
    pub(crate) fn look(&self, flight: &str, place: usize, name: &str) -> Option<Look> {
        let (_, parts) = self.flights.iter().find(|(known, _)| *known == flight)?;
        Some(Look::of(parts, &self.options[place], name))
    }
}

/// The command that shows one wrong answer, in a sentence. `is_all`: a table lists the others, if there are any.
pub(crate) fn hint(wrong: &[WrongAnswer<'_>], is_all: bool) -> Option<String> {
    let more = if is_all || wrong.len() < 2 { "" } else { " (--details lists the commands)" };
    Some(format!("to see why: {}, then why{more}", wrong.first()?.command))
}

/// The commands as a table; none without a wrong answer.
pub(crate) fn table(wrong: &[WrongAnswer<'_>]) -> Option<Table> {
    let row = |of: &WrongAnswer<'_>| {
        [of.configuration, of.family, &of.revolution.to_string(), of.what, &of.command].map(str::to_owned).to_vec()
    };
    (!wrong.is_empty()).then(|| Table {
        title: "mended and broken, each with the command that shows the wrong answer".to_owned(),
        header: ["configuration", "family", "revolution", "is", "command"].map(str::to_owned).to_vec(),
        rows: wrong.iter().map(row).collect(),
    })
}

/// Words as a shell takes them.
pub(crate) fn line(words: impl Iterator<Item = String>) -> String {
    words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use crosscut_evaluate::experiment::Experiment;

    use super::*;

    #[test]
    fn a_flight_is_recorded_first_and_a_recording_is_opened() {
        let look = |input: &str, options: &[&str]| {
            let options: Vec<String> = options.iter().map(|&option| option.to_owned()).collect();
            Look::of(&[PathBuf::from(input)], &options, "tee")
        };
        let flight = look("my flights/tee.mcap", &["--set", "affinity.without=[\"odds\"]"]);
        let record = r#"crosscut run 'my flights/tee.mcap' --set 'affinity.without=["odds"]' --save tee.rrd"#;
        assert_eq!(flight.record.as_deref(), Some(record));
        let recording = look("old/tee.rrd", &[]);
        assert_eq!(
            (recording.record.as_deref(), recording.at(81).as_str()),
            (None, "crosscut view old/tee.rrd --at 81")
        );
        assert_eq!(recording.beside(&flight, 7), "crosscut view old/tee.rrd --beside tee.rrd --at 7");
    }

    #[test]
    fn each_wrong_answer_is_named_with_its_configuration_and_file() {
        let mut experiment = Experiment::new(["paper", "mine"].map(str::to_owned).to_vec());
        for (family, seq, right) in [("a", 0, [true, true]), ("a", 3, [false, true]), ("b c", 7, [true, false])] {
            (0..2).for_each(|place| experiment.add(family, place, seq, right[place]));
        }
        let options = [["--preset", "paper"], ["--config", "mine.toml"]].map(|of| of.map(str::to_owned).to_vec());
        let [a, b] = ["x/a.mcap", "x/b c.mcap"].map(|path| [PathBuf::from(path)]);
        let looks = Looks { flights: vec![("a", &a), ("b c", &b)], options: options.to_vec() };
        let broken = "crosscut debug 'x/b c.mcap' --config mine.toml --at 7";
        let mended = "crosscut debug x/a.mcap --preset paper --at 3";
        let outcomes = experiment.outcomes();
        let wrong = looks.wrong_answers(&outcomes);
        let found: Vec<_> = wrong.iter().map(|of| (of.family, of.revolution, of.what, of.command.as_str())).collect();
        assert_eq!(found, [("b c", 7, "broken", broken), ("a", 3, "mended", mended)]);
        assert_eq!(hint(&wrong, false), Some(format!("to see why: {broken}, then why (--details lists the commands)")));
        assert_eq!(hint(&wrong[1..], false), Some(format!("to see why: {mended}, then why")));
        experiment.add("b c", 0, 7, false);
        experiment.add("a", 0, 3, true);
        assert!(looks.wrong_answers(&experiment.outcomes()).is_empty(), "both are right or both are wrong");
    }
}
