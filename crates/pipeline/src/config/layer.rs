//! Where settings come from.

use std::path::Path;

use toml::{Table, Value};

use super::error::{ConfigError, nearest};

/// The presets: name, and the settings as TOML.
pub const PRESETS: &[(&str, &str)] = &[
    ("paper", include_str!("presets/paper.toml")),
    ("default", include_str!("presets/default.toml")),
    ("threshold", include_str!("presets/threshold.toml")),
    ("breakpoint", include_str!("presets/breakpoint.toml")),
    ("dbscan", include_str!("presets/dbscan.toml")),
];

/// Settings from one place.
#[derive(Clone, Debug)]
pub struct Layer {
    pub(super) name: String,
    pub(super) table: Table,
}

impl Layer {
    /// A preset by name.
    ///
    /// # Errors
    /// When there is no such preset.
    pub fn preset(name: &str) -> Result<Self, ConfigError> {
        let known = PRESETS.iter().find(|(known, _)| *known == name);
        let (_, text) = known.ok_or_else(|| {
            let names = PRESETS.iter().map(|(known, _)| *known);
            ConfigError::UnknownPreset { name: name.to_owned(), nearest: nearest(name, names) }
        })?;
        Self::parse(format!("preset {name}"), text)
    }

    /// The text of a configuration file; `path` is for messages.
    ///
    /// # Errors
    /// When it is not TOML.
    pub fn file(path: &Path, text: &str) -> Result<Self, ConfigError> {
        Self::parse(path.display().to_string(), text)
    }

    /// Single settings, each `section.key=value`. The value is TOML; what is not TOML is taken as a word. Messages call
    /// the layer by its `name`.
    ///
    /// # Errors
    /// When a setting is not of this form.
    pub fn settings(name: &str, settings: &[String]) -> Result<Self, ConfigError> {
        let mut table = Table::new();
        for setting in settings {
            let malformed = || ConfigError::MalformedSetting { layer: name.to_owned(), setting: setting.clone() };
            let (path, value) = setting.split_once('=').ok_or_else(malformed)?;
            let (section, key) = path.trim().split_once('.').ok_or_else(malformed)?;
            let section = table.entry(section).or_insert_with(|| Value::Table(Table::new()));
            let section = section.as_table_mut().ok_or_else(malformed)?;
            section.insert(key.to_owned(), value_or_word(value.trim()));
        }
        Ok(Self { name: name.to_owned(), table })
    }

    fn parse(name: String, text: &str) -> Result<Self, ConfigError> {
        match text.parse::<Table>() {
            Ok(table) => Ok(Self { name, table }),
            Err(error) => Err(ConfigError::Syntax { layer: name, message: error.to_string() }),
        }
    }
}

fn value_or_word(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>().ok().and_then(|mut table| table.remove("value"));
    parsed.unwrap_or_else(|| Value::String(text.to_owned()))
}
