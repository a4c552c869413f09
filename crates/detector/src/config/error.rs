//! Why a configuration is refused, and the nearest right name.

use std::path::PathBuf;

use crosscut_stage::ParamError;

/// Why a configuration is refused: what is wrong, in which layer, and the nearest right name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the messages explain the fields
pub enum ConfigError {
    #[error("the registry has no kind of {section}: append one")]
    NoKinds { section: &'static str },
    #[error("the registry has two {section} kinds of the name {kind:?}: rename yours")]
    KindTwice { section: &'static str, kind: &'static str },
    #[error("there is no preset {name:?}; {nearest}")]
    UnknownPreset { name: String, nearest: String },
    #[error("cannot read {}: {why}", path.display())]
    Unreadable { path: PathBuf, why: String },
    #[error("{layer}: this is not TOML: {message}")]
    Syntax { layer: String, message: String },
    #[error("{layer}: {setting:?} is not of the form section.key=value")]
    MalformedSetting { layer: String, setting: String },
    #[error("{layer}: there is no section [{name}]; {nearest}")]
    UnknownSection { layer: String, name: String, nearest: String },
    #[error("{layer}: {section} must be a section: [{section}]")]
    NotASection { layer: String, section: &'static str },
    #[error("{layer}: there is no {section}.kind = {kind}; {nearest}")]
    UnknownKind { layer: String, section: &'static str, kind: String, nearest: String },
    #[error("{layer}: {section} has no {key}; {nearest}")]
    UnknownKey { layer: String, section: String, key: String, nearest: String },
    #[error("{layer}: {setting} is no setting any more: {now}")]
    Retired { layer: String, setting: String, now: &'static str },
    #[error("{layer}: {section}.{error}")]
    BadValue { layer: String, section: &'static str, error: ParamError },
    #[error(
        "{layer}: pipeline.memory_mb is at most {most} in a file that is found; name the file (--config, or \
         $CROSSCUT_CONFIG), or set it with --set"
    )]
    LimitRaised { layer: String, most: i64 },
    #[error(
        "ingest.min_range_m ({nearest_m}) is not below ingest.max_range_m ({farthest_m}), so no return would be left"
    )]
    NoReturnLeft { nearest_m: f64, farthest_m: f64 },
}

/// Asks "did you mean ...?" if one of the known names is near, else lists all of them.
pub(super) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<_> = known.collect();
    match best(name, &known) {
        Some(best) => format!("did you mean {best}?"),
        None => format!("there are: {}", known.join(", ")),
    }
}

/// Lists all of the known names, after the nearest; for short lists.
pub fn nearest_and_all(name: &str, known: &[&str]) -> String {
    let guess = best(name, known).map_or_else(String::new, |best| format!("did you mean {best}? "));
    format!("{guess}there are: {}", known.join(", "))
}

fn best<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let best = known.iter().map(|k| (likeness(name, k), *k)).max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(likeness, _)| *likeness > 0.66).map(|(_, best)| best)
}

/// High for a name begun rightly as well as for one with letters swapped.
fn likeness(a: &str, b: &str) -> f64 {
    strsim::jaro_winkler(a, b).max(strsim::normalized_damerau_levenshtein(a, b))
}
