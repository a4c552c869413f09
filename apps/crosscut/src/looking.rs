//! The commands that show a revolution in the viewer, for texts that name revolutions.

use std::path::{Path, PathBuf};

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
        let words: Vec<String> = inputs.chain(options.iter().cloned()).map(|word| quoted(&word)).collect();
        Self { record: Some(format!("crosscut run {} --save {rrd}", words.join(" "))), rrd }
    }

    /// Of a flight with the settings of a command.
    pub(crate) fn with(inputs: &[PathBuf], config: &ConfigArgs) -> Self {
        let name = inputs.first().and_then(|input| input.file_stem()).unwrap_or_default().to_string_lossy();
        let preset = (config.preset != "default").then_some(config.preset.as_str());
        Self::of(inputs, &options(preset, config.config.as_deref(), &config.set), &name)
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

/// Settings as options of `run`.
pub(crate) fn options(preset: Option<&str>, file: Option<&Path>, settings: &[String]) -> Vec<String> {
    let preset = preset.map(|preset| ["--preset".to_owned(), preset.to_owned()]);
    let file = file.map(|file| ["--config".to_owned(), file.to_string_lossy().into_owned()]);
    let settings = settings.iter().map(|setting| ["--set".to_owned(), setting.clone()]);
    preset.into_iter().chain(file).chain(settings).flatten().collect()
}

/// A word for a shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./=:,".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
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
}
