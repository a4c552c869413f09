//! `crosscut runs`: the history of runs, listed and compared.

use std::collections::BTreeSet;

use crosscut_evaluate::tables::Table;
use serde_json::Value;

use crate::cli::runs::RunsArgs;
use crate::exit::{Outcome, UsageError};
use crate::run_log::{Entry, read};
use crate::say::show;
use crate::typeset;

/// Lists the runs that are asked for, or compares two. Numbers count all runs of the history, from 1.
pub(crate) fn runs(args: &RunsArgs) -> anyhow::Result<Outcome> {
    let entries = read(&args.log)?;
    let table = match args.diff.as_deref() {
        Some([a, b]) => {
            let entry = |number: usize| {
                number.checked_sub(1).and_then(|at| entries.get(at)).ok_or_else(|| {
                    UsageError(format!("there is no run {number}; {} has {}", args.log.display(), entries.len()))
                })
            };
            difference([*a, *b], [entry(*a)?, entry(*b)?])
        }
        _ => list(&entries, &args.contains)?,
    };
    show(typeset::text(&[table]))?;
    Ok(Outcome::Done)
}

fn list(entries: &[Entry], contains: &[String]) -> anyhow::Result<Table> {
    let mut rows = Vec::new();
    for (number, entry) in (1..).zip(entries) {
        let text = serde_json::to_string(entry)?;
        let settings: Vec<String> = entry.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let is_wanted = |wanted: &String| text.contains(wanted) || settings.iter().any(|one| one.contains(wanted));
        if contains.iter().all(is_wanted) {
            let inputs: Vec<_> = entry
                .inputs
                .iter()
                .filter_map(|input| input.path.file_name())
                .map(|name| name.to_string_lossy())
                .collect();
            let figures = entry.figures.iter().map(|(name, value)| format!("{name} {}", shown(Some(value))));
            rows.push(vec![
                number.to_string(),
                utc(entry.unix_s),
                entry.command.clone(),
                inputs.join(", "),
                entry.configuration.clone(),
                settings.join(", "),
                figures.collect::<Vec<_>>().join(", "),
            ]);
        }
    }
    let header = ["run", "ended (UTC)", "command", "inputs", "configuration", "settings over default", "figures"];
    Ok(Table { title: "runs".to_owned(), header: header.map(str::to_owned).to_vec(), rows })
}

/// Everything that differs between two runs.
fn difference(numbers: [usize; 2], [a, b]: [&Entry; 2]) -> Table {
    let mut rows = Vec::new();
    let mut compare = |what: String, a: String, b: String| {
        if a != b {
            rows.push(vec![what, a, b]);
        }
    };
    compare("command".to_owned(), a.command.clone(), b.command.clone());
    compare("build".to_owned(), a.build.clone(), b.build.clone());
    let hashes = |of: &Entry| of.inputs.iter().map(|input| format!("{:.8}", input.hash)).collect::<Vec<_>>().join(", ");
    compare("inputs, hashes".to_owned(), hashes(a), hashes(b));
    let keys: BTreeSet<&String> = a.settings.keys().chain(b.settings.keys()).collect();
    for key in keys {
        let value = |of: &Entry| of.settings.get(key).map_or_else(|| "as default".to_owned(), String::clone);
        compare(key.clone(), value(a), value(b));
    }
    let figures: BTreeSet<&String> = a.figures.keys().chain(b.figures.keys()).collect();
    for name in figures {
        compare(name.clone(), shown(a.figures.get(name)), shown(b.figures.get(name)));
    }
    let [first, second] = numbers.map(|number| format!("run {number}"));
    Table {
        title: format!("what differs between {first} and {second}"),
        header: vec![String::new(), first, second],
        rows,
    }
}

fn shown(value: Option<&Value>) -> String {
    match value {
        None => "-".to_owned(),
        Some(Value::Number(number)) if number.is_f64() => format!("{:.4}", number.as_f64().unwrap_or(f64::NAN)),
        Some(value) => value.to_string(),
    }
}

/// `2026-11-27 03:21`. The days of the calendar are by Howard Hinnant's `civil_from_days`.
fn utc(unix_s: u64) -> String {
    let (days, minutes) = (unix_s / 86_400 + 719_468, unix_s % 86_400 / 60);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + 400 * era + u64::from(month <= 2);
    format!("{year}-{month:02}-{day:02} {:02}:{:02}", minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn days_are_those_of_the_calendar() {
        // `date -u -d @N`
        for (unix_s, text) in
            [(0, "1970-01-01 00:00"), (951_782_400, "2000-02-29 00:00"), (1_700_000_000, "2023-11-14 22:13")]
        {
            assert_eq!(utc(unix_s), text);
        }
    }
}
