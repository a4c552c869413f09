//! Where settings come from.

use std::path::Path;

use toml::{Table, Value};

use super::error::{ConfigError, nearest};
use super::retired::RETIRED;
use super::schema::MEMORY_MB;

/// Settings that ship with the program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// Algorithm 1 of the paper to the letter.
    Paper,
    /// The best there is.
    #[default]
    Default,
    /// Ways on in three dimensions, of clouds.
    ThreeD,
    /// A baseline: a wall ends where one clear width is that of the vehicle.
    ClearWidth,
    /// A baseline: returns within a radius of each other are of one wall.
    Threshold,
    /// A baseline: adaptive breakpoints.
    Breakpoint,
}

impl Preset {
    /// All presets, in the order in which messages list them.
    pub const ALL: [Self; 6] =
        [Self::Paper, Self::Default, Self::ThreeD, Self::ClearWidth, Self::Threshold, Self::Breakpoint];

    /// The preset of this name.
    ///
    /// # Errors
    /// When there is none.
    pub fn named(name: &str) -> Result<Self, ConfigError> {
        Self::ALL.into_iter().find(|preset| preset.name() == name).ok_or_else(|| ConfigError::UnknownPreset {
            name: name.to_owned(),
            nearest: nearest(name, Self::ALL.into_iter().map(Self::name)),
        })
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Default => "default",
            Self::ThreeD => "3d",
            Self::ClearWidth => "clear_width",
            Self::Threshold => "threshold",
            Self::Breakpoint => "breakpoint",
        }
    }

    fn toml(self) -> &'static str {
        match self {
            Self::Paper => include_str!("presets/paper.toml"),
            Self::Default => include_str!("presets/default.toml"),
            Self::ThreeD => include_str!("presets/3d.toml"),
            Self::ClearWidth => include_str!("presets/clear_width.toml"),
            Self::Threshold => include_str!("presets/threshold.toml"),
            Self::Breakpoint => include_str!("presets/breakpoint.toml"),
        }
    }
}

impl From<Preset> for Layer {
    fn from(preset: Preset) -> Self {
        Self::parse(format!("preset {}", preset.name()), preset.toml()).expect("a preset that ships is TOML")
    }
}

/// Settings from one place.
#[derive(Clone, Debug)]
pub struct Layer {
    pub(super) name: String,
    pub(super) table: Table,
}

impl Layer {
    /// The kind that a section is set to, if it is.
    pub(super) fn kind(&self, section: &str) -> Option<String> {
        self.table.get(section)?.get("kind")?.as_str().map(str::to_owned)
    }

    /// The text of a configuration file; `path` is for messages.
    ///
    /// # Errors
    /// When it is not TOML.
    pub fn file(path: &Path, text: &str) -> Result<Self, ConfigError> {
        Self::parse(path.display().to_string(), text)
    }

    /// The settings of a recording, which an earlier version may have made: those that are none any more are left out.
    ///
    /// # Errors
    /// When it is not TOML.
    pub fn recorded(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let mut layer = Self::file(path, text)?;
        for (section, key) in RETIRED.iter().filter_map(|(setting, _)| setting.split_once('.')) {
            layer.table.get_mut(section).and_then(Value::as_table_mut).map(|section| section.remove(key));
        }
        Ok(layer)
    }

    /// The text of a configuration file that nobody named. It may lower the limit on memory, not raise it.
    ///
    /// # Errors
    /// When it is not TOML, or raises the limit.
    pub fn unasked(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let layer = Self::file(path, text)?;
        let set = layer.table.get("pipeline").and_then(|section| section.get(MEMORY_MB.spec.name));
        let most = MEMORY_MB.spec.default_value();
        match set.and_then(Value::as_integer).zip(most.as_integer()) {
            Some((set, most)) if set > most => Err(ConfigError::LimitRaised { layer: layer.name, most }),
            _ => Ok(layer),
        }
    }

    /// Single settings, each `section.key=value`. The value is TOML; what is not TOML is a word. Messages call the layer by
    /// its `name`.
    ///
    /// # Errors
    /// When a setting is not of this form.
    pub fn settings(name: &str, settings: &[String]) -> Result<Self, ConfigError> {
        let mut layer = Self { name: name.to_owned(), table: Table::new() };
        for setting in settings {
            let malformed = || ConfigError::MalformedSetting { layer: name.to_owned(), setting: setting.clone() };
            let (path, value) = setting.split_once('=').ok_or_else(malformed)?;
            layer.insert(path.trim(), value_or_word(value.trim())).ok_or_else(malformed)?;
        }
        Ok(layer)
    }

    /// Values of settings, each named `section.key`. Messages call the layer by its `name`.
    ///
    /// # Errors
    /// When a name is not of this form.
    pub fn values(name: &str, values: &[(String, Value)]) -> Result<Self, ConfigError> {
        let mut layer = Self { name: name.to_owned(), table: Table::new() };
        for (setting, value) in values {
            let malformed = || ConfigError::MalformedSetting { layer: name.to_owned(), setting: setting.clone() };
            layer.insert(setting, value.clone()).ok_or_else(malformed)?;
        }
        Ok(layer)
    }

    /// Sets `section.key`; `None` if `path` is not of this form.
    fn insert(&mut self, path: &str, value: Value) -> Option<()> {
        let (section, key) = path.split_once('.')?;
        let section = self.table.entry(section).or_insert_with(|| Value::Table(Table::new()));
        section.as_table_mut()?.insert(key.to_owned(), value);
        Some(())
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
