//! The commands that show a revolution in the viewer or at the prompt, for texts that name revolutions.

use std::path::{Path, PathBuf};

use crosscut_evaluate::experiment::{FamilyOutcome, Outcome};

use crate::cli::ConfigArgs;

/// How a flight is looked at.
pub(crate) struct Look {
    /// The command that records it; `None` where the flight is a recording (.rrd) itself.
    pub(crate) record: Option<String>,
    rrd: String,
}

impl Look {
    /// Of the flight in `inputs`, with these [`options`] of `run`. `name` is that of a recording to be made.
    pub(crate) fn of(inputs: &[PathBuf], options: &[String], name: &str) -> Self {
        if let ([only], []) = (inputs, options)
            && only.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd"))
        {
            return Self { record: None, rrd: quoted(&only.to_string_lossy()) };
        }
        let rrd = quoted(&format!("{name}.rrd"));
        let inputs = inputs.iter().map(|input| input.to_string_lossy().into_owned());
        let words = line(inputs.chain(options.iter().cloned()));
        Self { record: Some(format!("crosscut run {words} --save {rrd}")), rrd }
    }

    /// Of a flight with the settings of a command.
    pub(crate) fn with(inputs: &[PathBuf], config: &ConfigArgs) -> Self {
        let name = inputs.first().and_then(|input| input.file_stem()).unwrap_or_default().to_string_lossy();
        Self::of(inputs, &options(config.preset.as_deref(), config.config.as_deref(), &config.set), &name)
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

/// The commands that show why an answer is wrong: one that a configuration breaks, or else one that it mends, as the first gives
/// it. `options` are the [`options`] of each configuration, `flights` the files of the families.
pub(crate) fn hint(outcomes: &[Outcome], flights: &[PathBuf], options: &[Vec<String>]) -> Option<String> {
    let first = |of: fn(&FamilyOutcome) -> &[u64]| {
        outcomes.iter().enumerate().find_map(|(place, outcome)| {
            outcome.families.iter().find_map(|family| Some((place + 1, &family.family, *of(family).first()?)))
        })
    };
    let broken = first(|family| &family.broken);
    let mended = || first(|family| &family.mended).map(|(_, family, seq)| (0, family, seq));
    let (wrong, family, seq) = broken.or_else(mended)?;
    let is_of_family = |path: &&PathBuf| {
        path.file_stem().is_some_and(|stem| stem.to_string_lossy() == family.as_str())
            || path.display().to_string() == *family
    };
    let flight = match flights {
        [only] => only,
        several => several.iter().find(is_of_family)?,
    };
    let words = std::iter::once(flight.to_string_lossy().into_owned()).chain(options[wrong].iter().cloned());
    Some(format!("to see why: crosscut debug {}, then seek {seq} and why", line(words)))
}

/// Words as a shell takes them.
fn line(words: impl Iterator<Item = String>) -> String {
    words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
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
    fn the_wrong_answer_is_named_with_its_configuration_and_file() {
        let mut experiment = Experiment::new(["paper", "mine"].map(str::to_owned).to_vec());
        for (family, seq, right) in [("a", 0, [true, true]), ("b c", 7, [true, false])] {
            (0..2).for_each(|place| experiment.add(family, place, seq, right[place]));
        }
        let options = [["--preset", "paper"], ["--config", "mine.toml"]].map(|of| of.map(str::to_owned).to_vec());
        let flights = ["x/a.mcap", "x/b c.mcap"].map(PathBuf::from);
        let said = hint(&experiment.outcomes(), &flights, &options).expect("one is broken");
        assert_eq!(said, "to see why: crosscut debug 'x/b c.mcap' --config mine.toml, then seek 7 and why");
        experiment.add("b c", 0, 7, false);
        assert_eq!(hint(&experiment.outcomes(), &flights, &options), None, "both are wrong");
        experiment.add("a", 0, 0, false);
        let said = hint(&experiment.outcomes(), &flights, &options).expect("one is mended");
        assert_eq!(said, "to see why: crosscut debug x/a.mcap --preset paper, then seek 0 and why");
    }
}
