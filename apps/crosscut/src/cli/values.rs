//! The values of options, and why one is refused.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::maps::FORMATS;

/// The number of a revolution, a seed, and the like.
pub(super) fn number<N: FromStr>(text: &str) -> Result<N, String> {
    text.parse().map_err(|_| "a whole number from 0 on".to_owned())
}

/// A count of what there is at least one of.
pub(super) fn count<N: FromStr>(text: &str) -> Result<N, String> {
    text.parse().map_err(|_| "a whole number from 1 on".to_owned())
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|s: &f64| s.is_finite() && *s >= 0.0).ok_or_else(|| "seconds, 0 or more".to_owned())
}

pub(super) fn html_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_html = has_extension(&path, "html") || has_extension(&path, "htm");
    if is_html { Ok(path) } else { Err("the page is an HTML file: FILE.html") }
}

pub(super) fn map_path(path: PathBuf) -> Result<PathBuf, String> {
    if FORMATS.iter().any(|format| has_extension(&path, format)) {
        Ok(path)
    } else {
        Err(format!("the name of a map ends in one of .{}", FORMATS.join(", .")))
    }
}

pub(super) fn mcap_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if has_extension(&path, "rrd") {
        return Err("the output is an MCAP recording, not one for the Rerun viewer: FLIGHT.mcap");
    }
    Ok(path)
}

/// Endings of other files, each with what makes one.
const NO_RESULTS: [(&[&str], &str); 4] = [
    (&["rrd"], "results are JSON lines or an MCAP; a recording for the viewer is --save FLIGHT.rrd"),
    (&["svg", "geojson", "g2o"], "results are JSON lines or an MCAP; a map is --map FLIGHT.svg"),
    (&["html"], "results are JSON lines or an MCAP; a page is made by `crosscut report`"),
    (&["csv", "npy", "bag", "db3"], "results are JSON lines, an object a scan, or an MCAP: FILE.jsonl, FILE.mcap"),
];

/// Refuses the endings of other files, which would say something else than what is in the file.
pub(super) fn results_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    let refusal = NO_RESULTS.iter().find(|(endings, _)| endings.iter().any(|ending| has_extension(&path, ending)));
    refusal.map_or(Ok(path), |(_, why)| Err(why))
}

pub(super) fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "a number, 0 or more".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "a number above 0".to_owned())
}

/// How odometry drifts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drift {
    /// There is none.
    NoOdometry,
    /// By this share of the way.
    Share(f64),
}

pub(super) fn drift(text: &str) -> Result<Drift, String> {
    if text == "none" {
        return Ok(Drift::NoOdometry);
    }
    let share = text.parse().ok().filter(|share| (0.0..=0.5).contains(share));
    share.map(Drift::Share).ok_or_else(|| "the drift is a share of the way, from 0 to 0.5, or none".to_owned())
}

/// A seed, or all from one to another: `7`, `201..210`.
pub(super) fn seeds(text: &str) -> Result<RangeInclusive<u64>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    match (first.parse(), last.parse()) {
        (Ok(first), Ok(last)) if first <= last => Ok(first..=last),
        _ => Err("a whole number from 0 on, or FIRST..LAST".to_owned()),
    }
}
