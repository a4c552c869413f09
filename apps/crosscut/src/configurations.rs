//! The configurations that `--with` names.

use std::path::{Path, PathBuf};

use crosscut_detector::{Config, Preset, Registry};

use crate::cli::ConfigArgs;
use crate::config;
use crate::exit::UsageError;

/// A configuration with the name it has in tables.
pub(crate) struct Configuration {
    pub(crate) name: String,
    pub(crate) config: Config,
}

/// Resolves each `PRESET|FILE.toml|PRESET,FILE.toml[,SECTION.KEY=VALUE]...` of `with`, with the settings of `set` on top.
/// Files of the same name in different folders are named by their paths.
pub(crate) fn named(with: &[String], set: &[String], registry: &Registry) -> anyhow::Result<Vec<Configuration>> {
    let resolved = with.iter().map(|text| resolve(text, set, registry));
    let mut configurations = resolved.collect::<anyhow::Result<Vec<_>>>()?;
    let short: Vec<String> = configurations.iter().map(|configuration| configuration.name.clone()).collect();
    for (configuration, text) in configurations.iter_mut().zip(with) {
        if short.iter().zip(with).any(|(name, other)| *name == configuration.name && other != text) {
            configuration.name.clone_from(text);
        }
    }
    Ok(configurations)
}

/// The files that `with` names.
pub(crate) fn files(with: &[String]) -> impl Iterator<Item = PathBuf> {
    with.iter().filter_map(|text| With::of(text).file).map(PathBuf::from)
}

fn is_preset(base: &str) -> bool {
    Preset::ALL.into_iter().any(|preset| preset.name() == base)
}

fn resolve(text: &str, set: &[String], registry: &Registry) -> anyhow::Result<Configuration> {
    let With { preset, file, settings } = With::of(text);
    if let Some(file) = file.filter(|file| !Path::new(file).exists()) {
        if is_preset(file) {
            return Err(UsageError(format!(
                "--with {text}: two presets cannot be combined; name a file after the preset"
            ))
            .into());
        }
        if preset.is_some() {
            let usage =
                format!("--with {text}: {file:?} is neither a file nor a setting of the form section.key=value");
            return Err(UsageError(usage).into());
        }
        let presets = Preset::ALL.map(Preset::name).join(", ");
        return Err(UsageError(format!("--with {file}: neither a preset (there are: {presets}) nor a file")).into());
    }
    let own = settings.map(single_settings).unwrap_or_default();
    let layers = ConfigArgs {
        preset: preset.unwrap_or("default").to_owned(),
        config: file.map(PathBuf::from),
        set: set.to_vec(),
    };
    let stem = file.map(|file| {
        let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
        if is_preset(&stem) { file.into() } else { stem }
    });
    let parts = [preset, stem.as_deref(), settings].into_iter().flatten();
    let name = parts.collect::<Vec<_>>().join(",");
    Ok(Configuration { name, config: config::resolve_with(&layers, "--with", &own, registry)? })
}

/// The parts of one `--with`, as typed.
#[derive(Debug, PartialEq, Eq)]
struct With<'a> {
    preset: Option<&'a str>,
    file: Option<&'a str>,
    settings: Option<&'a str>,
}

impl<'a> With<'a> {
    /// Splits the text at commas, except those in the name of an existing file.
    fn of(text: &'a str) -> Self {
        let split = |text: &'a str| match text.split_once(',') {
            Some((base, rest)) if !Path::new(text).exists() => (base, Some(rest)),
            _ => (text, None),
        };
        match split(text) {
            (preset, None) if is_preset(preset) => Self { preset: Some(preset), file: None, settings: None },
            (preset, Some(rest)) if is_preset(preset) => match split(rest) {
                (file, settings) if Path::new(file).exists() || !file.contains('=') => {
                    Self { preset: Some(preset), file: Some(file), settings }
                }
                _ => Self { preset: Some(preset), file: None, settings: Some(rest) },
            },
            (file, settings) => Self { preset: None, file: Some(file), settings },
        }
    }
}

/// Splits settings at commas. A comma that no `KEY=` follows belongs to the value: `a.b=[[0,1],[2,3]],c.d=4`.
fn single_settings(text: &str) -> Vec<String> {
    let mut settings: Vec<String> = Vec::new();
    for piece in text.split(',') {
        match settings.last_mut() {
            Some(last) if !piece.contains('=') => *last += &format!(",{piece}"),
            _ => settings.push(piece.to_owned()),
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::With;

    #[test]
    fn a_file_may_stand_alone_or_after_a_preset() {
        let with = |preset, file, settings| With { preset, file, settings };
        assert_eq!(With::of("paper"), with(Some("paper"), None, None));
        assert_eq!(With::of("paper,a.b=1,c.d=[[2,3]]"), with(Some("paper"), None, Some("a.b=1,c.d=[[2,3]]")));
        assert_eq!(With::of("my.toml,a.b=1"), with(None, Some("my.toml"), Some("a.b=1")));
        assert_eq!(With::of("paper,my.toml"), with(Some("paper"), Some("my.toml"), None));
        assert_eq!(With::of("paper,my.toml,a.b=1"), with(Some("paper"), Some("my.toml"), Some("a.b=1")));
    }

    #[test]
    fn a_comma_inside_a_value_does_not_end_the_setting() {
        let split = super::single_settings("ingest.mask=[[0,1],[2,3]],affinity.kind=rbf");
        assert_eq!(split, ["ingest.mask=[[0,1],[2,3]]", "affinity.kind=rbf"]);
    }
}
