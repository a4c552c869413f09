//! Changing settings, and what stages made.

use std::fs::File;

use crosscut_detector::Config;
use crosscut_stage::counted;
use faer::Mat;

use crate::command::takes;
use crate::npy::NpyArray;
use crate::session::answer_in_words;
use crate::{Refused, Session};

/// What a stage makes of a revolution, out of a file.
enum Array {
    W(Mat<f64>),
    U(Mat<f64>),
    Labels(Vec<i64>),
}

/// Reads `what`, W, U or labels, of a revolution with n returns.
fn array_in(what: &str, path: &str, n: usize) -> Result<Array, Refused> {
    let cannot = |error: String| Refused::Failed(format!("{error}, in {path}"));
    let array = File::open(path).map_err(|error| error.to_string());
    let array = array.and_then(|mut file| NpyArray::read(&mut file, n * n)).map_err(cannot)?;
    match (what, &array.shape[..]) {
        ("W", &[rows, columns]) if rows == n && columns == n => affinity(&array).map(Array::W).map_err(cannot),
        ("U", &[rows, columns]) if rows == n => Ok(Array::U(matrix(&array, rows, columns))),
        ("labels", &[rows]) if rows == n => labels(&array).map(Array::Labels).map_err(cannot),
        ("W" | "U" | "labels", shape) => {
            let fits = if what == "W" { format!("{n}x{n}") } else { counted(n as u64, "row") };
            Err(cannot(format!("the shape {shape:?} does not fit: {what} of this revolution has {fits}")))
        }
        _ => Err(takes("inject")),
    }
}

impl Session {
    pub(crate) fn set(&mut self, words: &[String]) -> Result<String, Refused> {
        // A value may have blanks in it, as a list has.
        let is_setting = |word: &str| word.split_once('=').is_some_and(|(key, _)| key.contains('.'));
        let mut settings: Vec<String> = Vec::new();
        for word in words {
            match settings.last_mut().filter(|_| !is_setting(word)) {
                Some(setting) => *setting += word,
                None => settings.push(word.clone()),
            }
        }
        let mut changes = self.changes.clone();
        for setting in &settings {
            let (key, value) = setting.split_once('=').ok_or_else(|| takes("set"))?;
            changes.retain(|[known, _]| known != key);
            // Another kind begins with its own defaults: what was set of the kind before would be refused.
            if let Some(section) = key.strip_suffix(".kind") {
                changes.retain(|[known, _]| !known.starts_with(&format!("{section}.")));
            }
            changes.push([key.to_owned(), value.to_owned()]);
        }
        let before = answer_in_words(self.frame());
        self.configure(changes)?;
        Ok(self.changed_from(&before))
    }

    pub(crate) fn swap(&mut self, word: &str) -> Result<String, Refused> {
        let (stage, kind) = word.split_once('=').ok_or_else(|| takes("swap"))?;
        if !["affinity", "spectral", "kmeans"].contains(&stage) {
            return Err(takes("swap"));
        }
        self.set(&[format!("{stage}.kind={kind}")])
    }

    pub(crate) fn unset(&mut self, key: &str) -> Result<String, Refused> {
        let mut changes = self.changes.clone();
        changes.retain(|[known, _]| key != "all" && known != key);
        if changes.len() == self.changes.len() {
            let set: Vec<&str> = self.changes.iter().map(|[key, _]| key.as_str()).collect();
            let set = if set.is_empty() { "nothing".to_owned() } else { set.join(", ") };
            return Err(Refused::Usage(format!("{key} was not set here; what was: {set}")));
        }
        let before = answer_in_words(self.frame());
        self.configure(changes)?;
        Ok(self.changed_from(&before))
    }

    pub(crate) fn inject(&mut self, words: &[String]) -> Result<String, Refused> {
        let mut given = self.now.given.clone();
        let seq = self.frame().revolution.seq;
        match words {
            [off] if off == "off" => {
                if given.injected.remove(&seq).is_none() {
                    return Err(Refused::Usage("nothing is injected into this revolution".to_owned()));
                }
            }
            [what, path] => {
                let array = array_in(what, path, self.frame().revolution.len())?;
                let injected = given.injected.entry(seq).or_default();
                match array {
                    Array::W(w) => injected.w = Some(w),
                    Array::U(u) => injected.u = Some(u),
                    Array::Labels(labels) => injected.labels = Some(labels),
                }
            }
            _ => return Err(takes("inject")),
        }
        let before = answer_in_words(self.frame());
        self.give(given);
        Ok(self.changed_from(&before))
    }

    /// The present answer, and the one before if it was another.
    fn changed_from(&self, before: &str) -> String {
        let here = self.here();
        let is_changed = before != answer_in_words(self.frame());
        if is_changed { format!("{here} (before: {before})") } else { format!("{here} (as before)") }
    }

    /// The settings of `config` that differ from those at the start: key, value at the start, value; `-` where there is none.
    pub fn differing(&self, config: &Config) -> Vec<[String; 3]> {
        let start: Vec<(String, String)> = self.start.settings().collect();
        let now: Vec<(String, String)> = config.settings().collect();
        let value_in = |list: &[(String, String)], key: &str| {
            list.iter().find(|(known, _)| known == key).map_or_else(|| "-".to_owned(), |(_, value)| value.clone())
        };
        let gone = start.iter().filter(|(key, _)| !now.iter().any(|(known, _)| known == key));
        let keys = now.iter().chain(gone).map(|(key, _)| key);
        let values = keys.map(|key| [key.clone(), value_in(&start, key), value_in(&now, key)]);
        values.filter(|[_, before, after]| before != after).collect()
    }

    pub(crate) fn settings(&self) -> String {
        let differ = self.differing(self.config());
        let mut lines: Vec<String> =
            differ.iter().map(|[key, before, after]| format!("{key} = {after} (at the start {before})")).collect();
        for (seq, injected) in &self.now.given.injected {
            lines.push(format!("{} of revolution {seq} injected", injected.names().join(" and ")));
        }
        if lines.is_empty() {
            lines.push("as at the start".to_owned());
        }
        lines.join("\n")
    }
}

fn matrix(array: &NpyArray, rows: usize, columns: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |i, j| array.values[i * columns + j])
}

/// The cluster of each return, below their number; negative: none.
fn labels(array: &NpyArray) -> Result<Vec<i64>, String> {
    let n = array.values.len();
    let wrong = array.values.iter().position(|&label| label.fract() != 0.0 || label >= n as f64);
    wrong.map_or(Ok(()), |at| {
        let label = array.values[at];
        Err(format!("labels[{at}] = {label} is no cluster of {n} returns: 0 to {}, or -1 for none", n - 1))
    })?;
    Ok(array.values.iter().map(|&label| label as i64).collect())
}

/// W, unless it is none: stages rely on its symmetry and signs.
fn affinity(array: &NpyArray) -> Result<Mat<f64>, String> {
    let n = array.shape[0];
    let w = matrix(array, n, n);
    for i in 0..n {
        for j in 0..=i {
            let (a, b) = (w[(i, j)], w[(j, i)]);
            if !(a.is_finite() && a >= 0.0) {
                return Err(format!("W[{i}, {j}] = {a} is not a weight of 0 or more"));
            }
            if a != b {
                return Err(format!("W is not symmetric: W[{i}, {j}] = {a}, W[{j}, {i}] = {b}"));
            }
        }
        if w[(i, i)] <= 0.0 {
            return Err(format!("W[{i}, {i}] is 0; the diagonal of W is 1"));
        }
    }
    Ok(w)
}
