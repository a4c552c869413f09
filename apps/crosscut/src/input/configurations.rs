//! The configurations that `--with` and `--grid` name.

use std::path::{Path, PathBuf};

use crosscut_detector::{Config, Preset, Registry};

use crate::exit::UsageError;
use crate::input::config;
use crate::output::looking;

/// A configuration with the name it has in tables.
pub(crate) struct Configuration {
    pub(crate) name: String,
    pub(crate) config: Config,
    /// The options of `run` and `debug` that choose it.
    pub(crate) options: Vec<String>,
    /// Its value of each key of the grid.
    pub(crate) point: Vec<String>,
}

/// Each `--with` at each point of the grid, with the settings of `set` on top of `--with`. Without `--with`, the grid is one over
/// preset `default`. Files of the same name in different folders are named by their paths.
pub(crate) fn named(
    with: &[String],
    grid: &Grid,
    set: &[String],
    registry: &Registry,
) -> anyhow::Result<Vec<Configuration>> {
    let default = ["default".to_owned()];
    let texts = if with.is_empty() { &default[..] } else { with };
    let parts = texts.iter().map(|text| With::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let mut configurations = Vec::new();
    for (of, text) in parts.iter().zip(texts) {
        let is_other = |(other, of_other): (&With<'_>, &String)| other.name == of.name && of_other != text;
        let name = if parts.iter().zip(texts).any(is_other) { text } else { &of.name };
        for (point, settings) in grid.points.iter().zip(grid.settings()) {
            // One layer: a kind of the grid may have parameters that --set gives.
            let on_top = [set, &settings].concat();
            let layers = [("--with", &of.settings[..]), ("--set", &on_top)];
            let config = config::resolve(of.preset.unwrap_or("default"), of.file.map(Path::new), &layers, registry);
            let config = config.map_err(|error| match settings.join(", ") {
                none if none.is_empty() => error,
                at => UsageError(format!("--grid at {at}: {error}")),
            })?;
            let of_with = Some(name.as_str()).filter(|_| point.is_empty() || !with.is_empty());
            let name = of_with.map(str::to_owned).into_iter().chain(grid.named(point)).collect::<Vec<_>>().join(",");
            let preset = of.preset.filter(|preset| *preset != "default");
            let options = looking::options(preset, of.file.map(Path::new), &[&of.settings[..], &on_top].concat());
            configurations.push(Configuration { name, config, options, point: point.clone() });
        }
    }
    Ok(configurations)
}

/// All combinations of the values of some settings.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) keys: Vec<String>,
    /// The value of each key, for each combination; the last key changes fastest.
    points: Vec<Vec<String>>,
}

impl Grid {
    /// From texts of the form `KEY=V1,V2...`. Without any, its one point has no value.
    ///
    /// # Errors
    /// When a text has another form, or a key or one of its values stands twice.
    pub(crate) fn parse(texts: &[String]) -> Result<Self, UsageError> {
        let mut grid = Self { keys: Vec::new(), points: vec![Vec::new()] };
        for text in texts {
            let refuse = |why: &str| UsageError(format!("--grid {text}: {why}"));
            let (key, values) = text
                .split_once('=')
                .filter(|(key, values)| !key.is_empty() && !values.is_empty())
                .ok_or_else(|| refuse("the form is KEY=V1,V2..."))?;
            if key == "preset" {
                return Err(refuse("presets are configurations of their own: --with paper --with default"));
            }
            if grid.keys.iter().any(|known| known == key) {
                return Err(refuse(&format!("{key} stands twice")));
            }
            grid.keys.push(key.to_owned());
            let values = values_of(values);
            let is_twice = |(at, value): &(usize, &String)| values[..*at].iter().any(|before| are_same(before, value));
            if let Some((_, value)) = values.iter().enumerate().find(is_twice) {
                return Err(refuse(&format!("{key} has the value {value} twice")));
            }
            let with = |point: &Vec<String>| {
                let point = point.clone();
                values.iter().map(move |value| [point.as_slice(), std::slice::from_ref(value)].concat())
            };
            grid.points = grid.points.iter().flat_map(with).collect();
        }
        Ok(grid)
    }

    /// The settings of each point.
    fn settings(&self) -> impl Iterator<Item = Vec<String>> {
        let setting = |(key, value): (&String, &String)| format!("{key}={value}");
        self.points.iter().map(move |point| self.keys.iter().zip(point).map(setting).collect())
    }

    /// The settings of a point as a name: without their sections where that is clear.
    fn named(&self, point: &[String]) -> Vec<String> {
        let short = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
        let is_alone = |key: &String| self.keys.iter().filter(|other| short(other) == short(key)).count() == 1;
        let name = |key: &String| if is_alone(key) { short(key) } else { key.clone() };
        self.keys.iter().zip(point).map(|(key, value)| format!("{}={value}", name(key))).collect()
    }
}

/// Splits at commas that are not within brackets.
fn values_of(text: &str) -> Vec<String> {
    let mut depth = 0;
    let values = text.split(|c| {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0
    });
    values.map(str::to_owned).collect()
}

/// Whether two values are the same, as 0.6 and 0.60 are.
fn are_same(a: &str, b: &str) -> bool {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    a.trim() == b.trim() || number(a).is_some_and(|a| number(b) == Some(a))
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
    use super::*;

    fn grid(texts: &[&str]) -> Result<Grid, String> {
        let texts: Vec<String> = texts.iter().map(|&text| text.to_owned()).collect();
        Grid::parse(&texts).map_err(|error| error.0)
    }

    #[test]
    fn every_combination_is_tried_and_lists_are_one_value() {
        let grid = grid(&["report.min_returns=1,3", "ingest.rings=[[0,1],[3,4]],[]"]).expect("a grid");
        assert_eq!(grid.keys, ["report.min_returns", "ingest.rings"]);
        let rings = ["[[0,1],[3,4]]", "[]"];
        let expected: Vec<_> = ["1", "3"].iter().flat_map(|least| rings.map(|rings| vec![*least, rings])).collect();
        assert_eq!(grid.points, expected);
    }

    #[test]
    fn names_are_as_short_as_they_are_clear() {
        let grid = grid(&["affinity.sigma_per_m2=1,2", "spectral.kind=faer", "kmeans.kind=lloyd"]).expect("a grid");
        assert_eq!(grid.named(&grid.points[1]), ["sigma_per_m2=2", "spectral.kind=faer", "kmeans.kind=lloyd"]);
    }

    #[test]
    fn a_grid_without_values_or_with_one_twice_is_refused() {
        assert!(grid(&["affinity.kind"]).is_err_and(|error| error.contains("KEY=V1,V2")));
        assert!(grid(&["affinity.kind="]).is_err());
        assert!(grid(&["a.b=1", "a.b=2"]).is_err_and(|error| error.contains("a.b stands twice")));
        assert!(grid(&["a.b=0.6,1,0.60"]).is_err_and(|error| error.contains("a.b has the value 0.60 twice")));
        assert!(grid(&["preset=paper,default"]).is_err_and(|error| error.contains("--with paper")));
    }

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
