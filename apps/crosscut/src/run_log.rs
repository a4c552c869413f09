//! The history of runs: one JSON object a line, appended to by each command that is told to.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;
use crosscut_detector::{Config, Preset, Registry};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::content::{hash_of_file, program};

/// One run of one configuration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// When it ended, seconds since 1970.
    pub(crate) unix_s: u64,
    pub(crate) command: String,
    /// Each file with a hash of what is in it.
    pub(crate) inputs: Vec<Input>,
    /// Version and build of the program.
    pub(crate) build: String,
    /// The name of the configuration, where there are several.
    pub(crate) configuration: String,
    /// The settings that differ from preset `default`.
    pub(crate) settings: BTreeMap<String, String>,
    pub(crate) figures: BTreeMap<String, Value>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Input {
    pub(crate) path: PathBuf,
    pub(crate) hash: String,
}

/// What was run, for the entries of its configurations.
pub(crate) struct Run {
    command: &'static str,
    inputs: Vec<Input>,
    build: String,
}

impl Run {
    /// Reads each of the files for its hash; what is no file has none.
    pub(crate) fn of(command: &'static str, files: &[PathBuf]) -> Self {
        let input = |path: &PathBuf| Input { path: path.clone(), hash: hash_of_file(path).unwrap_or_default() };
        Self { command, inputs: files.iter().map(input).collect(), build: program(None) }
    }

    /// Appends an entry to the history at `path`.
    pub(crate) fn append(
        &self,
        path: &Path,
        configuration: &str,
        config: &Config,
        registry: &Registry,
        figures: Value,
    ) -> anyhow::Result<()> {
        let entry = Entry {
            unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            command: self.command.to_owned(),
            inputs: self.inputs.clone(),
            build: self.build.clone(),
            configuration: configuration.to_owned(),
            settings: differing(config, registry)?,
            figures: serde_json::from_value(figures)?,
        };
        let line = serde_json::to_string(&entry)? + "\n";
        let cannot = || format!("cannot write {}", path.display());
        let mut out = OpenOptions::new().create(true).append(true).open(path).with_context(cannot)?;
        out.write_all(line.as_bytes()).with_context(cannot) // one write: lines of two runs at once do not mix
    }
}

/// The settings of `config` that are not those of preset `default`.
fn differing(config: &Config, registry: &Registry) -> anyhow::Result<BTreeMap<String, String>> {
    let default: BTreeMap<_, _> = Config::preset(Preset::Default, registry)?.settings().collect();
    Ok(config.settings().filter(|(key, value)| default.get(key) != Some(value)).collect())
}

/// Reads a history.
pub(crate) fn read(path: &Path) -> anyhow::Result<Vec<Entry>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let entry = |(number, line)| {
        serde_json::from_str(line).with_context(|| format!("line {} is no run, in {}", number + 1, path.display()))
    };
    text.lines().enumerate().map(entry).collect()
}
