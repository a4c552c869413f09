//! Configurations side by side: what `--with` names.

use std::path::{Path, PathBuf};

use crosscut_pipeline::{Config, PRESETS, Registry};

use crate::cli::ConfigArgs;
use crate::config;
use crate::exit::UsageError;

/// One of the configurations that are compared.
pub(crate) struct Configuration {
    pub(crate) name: String,
    pub(crate) config: Config,
}

/// What each of `with` names: `PRESET|FILE.toml[,SECTION.KEY=VALUE]...`, with the settings of `set` on top. Files of the
/// same name in different folders are called by their paths.
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

/// The files among what `with` names.
pub(crate) fn files(with: &[String]) -> impl Iterator<Item = PathBuf> {
    with.iter().map(|text| split(text).0).filter(|base| !is_preset(base)).map(PathBuf::from)
}

fn is_preset(base: &str) -> bool {
    PRESETS.iter().any(|(preset, _)| *preset == base)
}

fn resolve(text: &str, set: &[String], registry: &Registry) -> anyhow::Result<Configuration> {
    let (base, settings) = split(text);
    let path = Path::new(base);
    let is_preset = is_preset(base);
    if !is_preset && !path.exists() {
        let presets: Vec<_> = PRESETS.iter().map(|(preset, _)| *preset).collect();
        let presets = presets.join(", ");
        return Err(UsageError(format!("--with {base}: no preset (there are: {presets}) and no such file")).into());
    }
    let own = settings.map(single_settings).unwrap_or_default();
    let layers = ConfigArgs {
        preset: if is_preset { base.to_owned() } else { "default".to_owned() },
        config: (!is_preset).then(|| path.to_owned()),
        set: set.to_vec(),
    };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let stem = if !is_preset && self::is_preset(&stem) { base.into() } else { stem };
    let name = settings.map_or_else(|| stem.clone().into_owned(), |settings| format!("{stem},{settings}"));
    Ok(Configuration { name, config: config::resolve_with(&layers, &own, registry)? })
}

/// A preset or file, and the settings after it. A file may have a comma in its name.
fn split(text: &str) -> (&str, Option<&str>) {
    match text.split_once(',') {
        Some((base, settings)) if !Path::new(text).exists() => (base, Some(settings)),
        _ => (text, None),
    }
}

/// Settings with commas between them. A comma that no `KEY=` follows belongs to the value: `a.b=[[0,1],[2,3]],c.d=4`.
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
    #[test]
    fn a_comma_inside_a_value_does_not_end_the_setting() {
        let split = super::single_settings("ingest.mask=[[0,1],[2,3]],affinity.kind=rbf");
        assert_eq!(split, ["ingest.mask=[[0,1],[2,3]]", "affinity.kind=rbf"]);
    }
}
