//! The configurations that `--with` names.

use std::path::{Path, PathBuf};

use crosscut_detector::{Config, Preset, Registry};

use crate::cli::InputArgs;
use crate::exit::UsageError;
use crate::{config, looking};

/// A configuration with the name it has in tables.
pub(crate) struct Configuration {
    pub(crate) name: String,
    pub(crate) config: Config,
}

/// Resolves each `--with`, with the settings of `set` on top. Files of the same name in different folders are named by their
/// paths.
pub(crate) fn named(with: &[String], set: &[String], registry: &Registry) -> anyhow::Result<Vec<Configuration>> {
    let resolve = |text: &String| {
        let With { name, preset, file, settings } = With::parse(text)?;
        let settings = [("--with", &settings[..]), ("--set", set)];
        let config = config::resolve(preset.unwrap_or("default"), file.map(Path::new), &settings, registry)?;
        anyhow::Ok(Configuration { name, config })
    };
    let mut configurations = with.iter().map(resolve).collect::<anyhow::Result<Vec<_>>>()?;
    let short: Vec<String> = configurations.iter().map(|configuration| configuration.name.clone()).collect();
    for (configuration, text) in configurations.iter_mut().zip(with) {
        if short.iter().zip(with).any(|(name, other)| *name == configuration.name && other != text) {
            configuration.name.clone_from(text);
        }
    }
    Ok(configurations)
}

/// Each `--with` and the settings of `set` as options of `run` and `debug`, with those that select the scans of `input`.
pub(crate) fn run_options(input: &InputArgs, with: &[String], set: &[String]) -> Vec<Vec<String>> {
    let options = |text: &String| {
        let Ok(With { preset, file, settings, .. }) = With::parse(text) else { return input.options() };
        let settings: Vec<String> = settings.iter().chain(set).cloned().collect();
        let preset = preset.filter(|preset| *preset != "default");
        [input.options(), looking::options(preset, file.map(Path::new), &settings)].concat()
    };
    with.iter().map(options).collect()
}

/// The files that `with` names.
pub(crate) fn files(with: &[String]) -> impl Iterator<Item = PathBuf> {
    with.iter().filter_map(|text| With::parse(text).ok()?.file.map(PathBuf::from))
}

/// The parts of one `--with`: `[NAME=]PART[,PART]...`. Each part is what it looks like, whatever files there are: a preset by
/// its name, a file of settings by its ending, a setting by its form `section.key=value`.
#[derive(Debug, PartialEq, Eq)]
struct With<'a> {
    name: String,
    preset: Option<&'a str>,
    file: Option<&'a str>,
    settings: Vec<String>,
}

impl<'a> With<'a> {
    fn parse(text: &'a str) -> Result<Self, UsageError> {
        let refuse = |why: String| Err(UsageError(format!("--with {text}: {why}")));
        let (name, mut rest) = match text.split_once('=') {
            Some((name, rest)) if is_short_name(name) => (Some(name), rest),
            _ => (None, text),
        };
        let mut with = Self { name: String::new(), preset: None, file: None, settings: Vec::new() };
        while !rest.is_empty() {
            let (part, after) = first_part(rest);
            rest = after;
            if is_file(part) {
                if with.file.replace(part).is_some() || !with.settings.is_empty() {
                    return refuse(format!("the one file of settings, {part}, stands before single settings"));
                }
            } else if part.split_once('=').is_some_and(|(key, _)| !key.contains(',')) {
                with.settings.push(part.to_owned());
            } else if !is_preset(part) {
                let presets = Preset::ALL.map(Preset::name).join(", ");
                let part = part.split(',').next().unwrap_or_default();
                return refuse(format!(
                    "{part:?} is neither a preset (there are: {presets}), nor a file FILE.toml or FLIGHT.rrd, nor a setting \
                     of the form section.key=value"
                ));
            } else if with.preset.replace(part).is_some() {
                return refuse("two presets cannot be combined; name a file after the preset".to_owned());
            } else if with.file.is_some() || !with.settings.is_empty() {
                return refuse(format!("the preset {part} stands before all else"));
            }
        }
        with.name = name.map_or_else(|| with.own_name(), str::to_owned);
        Ok(with)
    }

    /// The preset, the file without folder and ending, and the settings.
    fn own_name(&self) -> String {
        let file = self.file.map(|file| {
            let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
            if is_preset(&stem) { file.to_owned() } else { stem.into_owned() }
        });
        let parts = self.preset.map(str::to_owned).into_iter().chain(file).chain(self.settings.iter().cloned());
        parts.collect::<Vec<_>>().join(",")
    }
}

/// Splits off the first part. A comma belongs to the part before it if neither a preset, nor a setting, nor the end of the
/// name of a file stands before it, or if what follows it is none: `my, own.toml`, `a.b=[[0,1],[2,3]]`.
fn first_part(text: &str) -> (&str, &str) {
    for (at, _) in text.match_indices(',') {
        let (part, rest) = (&text[..at], &text[at + 1..]);
        let next = rest.split(',').next().unwrap_or_default();
        let is_whole = is_preset(part) || is_file(part) || (part.contains('=') && next.contains('='));
        if is_whole {
            return (part, rest);
        }
    }
    (text, "")
}

fn is_preset(part: &str) -> bool {
    Preset::ALL.into_iter().any(|preset| preset.name() == part)
}

fn is_file(part: &str) -> bool {
    let ending = Path::new(part).extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("toml") || ending.eq_ignore_ascii_case("rrd"))
}

/// Whether this is a name for a configuration, and neither a setting nor a path.
fn is_short_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
}

#[cfg(test)]
mod tests {
    use super::With;

    #[test]
    fn each_part_is_what_it_looks_like() {
        let with = |name: &str, preset, file, settings: &[&str]| With {
            name: name.to_owned(),
            preset,
            file,
            settings: settings.iter().map(|&setting| setting.to_owned()).collect(),
        };
        for (text, expected) in [
            ("paper", with("paper", Some("paper"), None, &[])),
            (
                "paper,a.b=1,c.d=[[2,3],[4,5]],e.f=6",
                with(
                    "paper,a.b=1,c.d=[[2,3],[4,5]],e.f=6",
                    Some("paper"),
                    None,
                    &["a.b=1", "c.d=[[2,3],[4,5]]", "e.f=6"],
                ),
            ),
            ("dir/my.toml,a.b=1", with("my,a.b=1", None, Some("dir/my.toml"), &["a.b=1"])),
            ("paper,my.toml,a.b=1", with("paper,my,a.b=1", Some("paper"), Some("my.toml"), &["a.b=1"])),
            ("paper.toml", with("paper.toml", None, Some("paper.toml"), &[])),
            ("my, own.toml", with("my, own", None, Some("my, own.toml"), &[])),
            ("a.b=1", with("a.b=1", None, None, &["a.b=1"])),
            ("mine=paper,a.b=1", with("mine", Some("paper"), None, &["a.b=1"])),
            ("mine=a.b=1", with("mine", None, None, &["a.b=1"])),
            ("mine=FLIGHT.RRD", with("mine", None, Some("FLIGHT.RRD"), &[])),
        ] {
            assert_eq!(With::parse(text).map_err(|error| error.0), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_none_of_these_is_refused() {
        for (text, word) in [
            ("papr,a.b=1", "\"papr\" is neither a preset (there are: paper, default"),
            ("settings", "FILE.toml"),
            ("paper,default", "two presets"),
            ("a.toml,b.toml", "one file"),
            ("my.toml,paper", "before all else"),
            ("mine=nothing", "neither"),
        ] {
            let refused = With::parse(text).expect_err(text).0;
            assert!(refused.contains(word), "{text}: {refused}");
        }
    }
}
