//! The settings that are tried, and their combinations.

use crosscut_detector::{Config, Registry};

use crate::cli::{ConfigArgs, InputArgs};
use crate::config;
use crate::exit::UsageError;
use crate::looking;

/// The key that chooses a preset.
const PRESET: &str = "preset";

/// All combinations of the values of some settings.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) keys: Vec<String>,
    /// The value of each key, for each combination; the last key changes fastest.
    pub(super) points: Vec<Vec<String>>,
}

impl Grid {
    /// From texts of the form `KEY=V1,V2...`.
    ///
    /// # Errors
    /// When a text has another form, or a key or one of its values stands twice.
    pub(super) fn parse(texts: &[String]) -> Result<Self, UsageError> {
        let mut grid = Self { keys: Vec::new(), points: vec![Vec::new()] };
        for text in texts {
            let (key, values) = text
                .split_once('=')
                .filter(|(key, values)| !key.is_empty() && !values.is_empty())
                .ok_or_else(|| UsageError(format!("--grid {text}: the form is KEY=V1,V2...")))?;
            if grid.keys.iter().any(|known| known == key) {
                return Err(UsageError(format!("--grid names {key} twice")));
            }
            grid.keys.push(key.to_owned());
            let values = values_of(values);
            let is_twice = |(at, value): &(usize, &String)| values[..*at].iter().any(|before| are_same(before, value));
            if let Some((_, value)) = values.iter().enumerate().find(is_twice) {
                return Err(UsageError(format!("--grid {text}: {key} has the value {value} twice")));
            }
            let with = |point: &Vec<String>| {
                let point = point.clone();
                values.iter().map(move |value| [point.as_slice(), std::slice::from_ref(value)].concat())
            };
            grid.points = grid.points.iter().flat_map(with).collect();
        }
        Ok(grid)
    }

    /// A short name of each combination: what differs, without the section where that is clear.
    pub(super) fn names(&self) -> Vec<String> {
        let short = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
        let is_alone = |key: &String| self.keys.iter().filter(|other| short(other) == short(key)).count() == 1;
        let name = |key: &String| if is_alone(key) { short(key) } else { key.clone() };
        let pair = |(key, value): (&String, &String)| match key.as_str() {
            PRESET => value.clone(),
            _ => format!("{}={value}", name(key)),
        };
        self.points.iter().map(|point| self.keys.iter().zip(point).map(pair).collect::<Vec<_>>().join(",")).collect()
    }

    /// The preset and the settings of a combination, over those of the command line.
    fn chosen<'a>(&'a self, point: &'a [String], args: &'a ConfigArgs) -> (&'a str, Vec<String>) {
        let of_point = self.keys.iter().zip(point);
        let preset = of_point.clone().find(|(key, _)| *key == PRESET).map_or(args.preset(), |(_, value)| value);
        let of_point = of_point.filter(|(key, _)| *key != PRESET).map(named);
        (preset, args.set.iter().cloned().chain(of_point).collect())
    }

    /// The options of `debug` that choose each combination.
    pub(super) fn options(&self, input: &InputArgs, args: &ConfigArgs) -> Vec<Vec<String>> {
        let of = |point: &Vec<String>| {
            let (preset, settings) = self.chosen(point, args);
            [input.options(), looking::options(Some(preset), args.config.as_deref(), &settings)].concat()
        };
        self.points.iter().map(of).collect()
    }

    /// The configuration of each combination, over that of the command line.
    pub(super) fn configs(&self, args: &ConfigArgs, registry: &Registry) -> anyhow::Result<Vec<Config>> {
        let config = |point: &Vec<String>| {
            // One layer: a kind of the grid may have parameters that --set gives.
            let (preset, settings) = self.chosen(point, args);
            config::resolve(preset, args.config.as_deref(), &[("--set", &settings)], registry).map_err(|error| {
                let of_point: Vec<String> = self.keys.iter().zip(point).map(named).collect();
                UsageError(format!("--grid at {}: {error}", of_point.join(", "))).into()
            })
        };
        self.points.iter().map(config).collect()
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

/// A setting as the command line has it.
fn named((key, value): (&String, &String)) -> String {
    format!("{key}={value}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(texts: &[&str]) -> Result<Grid, String> {
        let texts: Vec<String> = texts.iter().map(|&text| text.to_owned()).collect();
        Grid::parse(&texts).map_err(|error| error.0)
    }

    #[test]
    fn every_combination_is_tried_and_lists_are_one_value() {
        let grid = parse(&["preset=paper,default", "ingest.rings=[[0,1],[3,4]],[]"]).expect("a grid");
        assert_eq!(grid.keys, ["preset", "ingest.rings"]);
        let rings = ["[[0,1],[3,4]]", "[]"];
        let expected: Vec<_> =
            ["paper", "default"].iter().flat_map(|preset| rings.map(|rings| vec![*preset, rings])).collect();
        assert_eq!(grid.points, expected);
    }

    #[test]
    fn names_are_as_short_as_they_are_clear() {
        let grid = parse(&["preset=paper", "affinity.sigma_per_m2=1,2", "spectral.kind=lapack", "kmeans.kind=lloyd"]);
        let names = grid.expect("a grid").names();
        assert_eq!(names[1], "paper,sigma_per_m2=2,spectral.kind=lapack,kmeans.kind=lloyd");
    }

    #[test]
    fn a_grid_without_values_or_with_one_twice_is_refused() {
        assert!(parse(&["affinity.kind"]).is_err_and(|error| error.contains("KEY=V1,V2")));
        assert!(parse(&["affinity.kind="]).is_err());
        assert!(parse(&["a.b=1", "a.b=2"]).is_err_and(|error| error.contains("a.b twice")));
        assert!(parse(&["a.b=0.6,1,0.60"]).is_err_and(|error| error.contains("a.b has the value 0.60 twice")));
    }
}
