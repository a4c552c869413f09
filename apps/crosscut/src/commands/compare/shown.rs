//! A comparison as tables and as JSON.

use std::collections::BTreeMap;

use crosscut_evaluate::experiment;
use crosscut_evaluate::tables::Table;
use crosscut_evaluate::verdict::Surer;
use crosscut_evaluate::{Differences, Proportion, Stretch};
use serde_json::json;

use super::Compared;
use crate::configurations::Configuration;
use crate::looking::WrongAnswer;

/// This many of the longest stretches are shown by default.
const STRETCHES: usize = 15;

/// The conclusion: what each configuration mends and breaks, where there is a truth, and which is surer where they differ.
pub(super) fn sentences(configurations: &[Configuration], compared: &Compared, hint: Option<String>) -> String {
    let first = &configurations[0].name;
    let others = configurations[1..].iter().zip(&compared.surer);
    let surer = others.map(|(other, surer)| surer.sentence(first, &other.name));
    experiment::sentences(&compared.outcomes)
        .into_iter()
        .chain(surer)
        .chain(hint)
        .map(|sentence| sentence + "\n")
        .collect()
}

/// Tables of settings, agreement, counts, times, and stretches where the walls differ. Times in the flight are seconds
/// after its first scan.
pub(super) fn tables(configurations: &[Configuration], compared: &Compared, all: bool) -> Vec<Table> {
    // Configurations may begin with different scans (`ingest.frame_id`).
    let starts_at_s = compared.flown.iter().map(|flown| flown.starts_at_s).reduce(f64::min).unwrap_or(0.0);
    let first = &configurations[0].name;
    let others = || configurations[1..].iter().map(|other| other.name.as_str()).zip(&compared.differences);
    let mut tables = vec![settings(configurations), agreement(first, others())];
    tables.extend(others().map(|(other, differences)| counts(first, other, differences)));
    tables.extend(compared.stopwatch.table("while all run at once"));
    let since_start_s = |stamp_ns: u64| starts_at_s + (stamp_ns as f64 - compared.first_stamp_ns as f64) / 1e9;
    tables.extend(others().map(|(other, differences)| stretches(first, other, differences, since_start_s, all)));
    tables
}

/// Settings that two configurations have with different values. A setting that only one kind has follows from the kind.
fn settings(configurations: &[Configuration]) -> Table {
    let mut values: BTreeMap<String, Vec<Option<String>>> = BTreeMap::new();
    for (place, configuration) in configurations.iter().enumerate() {
        for (name, value) in configuration.config.settings() {
            values.entry(name).or_insert_with(|| vec![None; configurations.len()])[place] = Some(value);
        }
    }
    let differ = |cells: &[Option<String>]| {
        let mut there = cells.iter().flatten();
        there.next().is_some_and(|first| there.any(|other| other != first))
    };
    let row = |(name, cells): (String, Vec<Option<String>>)| {
        [name].into_iter().chain(cells.into_iter().map(|cell| cell.unwrap_or_else(|| "-".to_owned()))).collect()
    };
    let rows = values.into_iter().filter(|(_, cells)| differ(cells)).map(row).collect();
    Table { title: "settings that differ".to_owned(), header: header("setting", configurations), rows }
}

fn agreement<'a>(first: &str, others: impl Iterator<Item = (&'a str, &'a Differences)>) -> Table {
    let columns = [
        "revolutions",
        "by one only",
        "same count",
        "same k",
        "same walls",
        "same returns",
        "openings missing",
        "openings added",
    ];
    let row = |(other, of): (&str, &Differences)| {
        let shares = [of.same_count, of.same_k, of.same_walls, of.returns_alike, of.openings_lacking, of.openings_more];
        let [by_both, by_one] = [of.same_count.of, of.answered_by_one.iter().sum()];
        [other.to_owned(), by_both.to_string(), by_one.to_string()].into_iter().chain(shares.map(percent)).collect()
    };
    Table {
        title: format!("against {first}, %"),
        header: ["configuration"].into_iter().chain(columns).map(str::to_owned).collect(),
        rows: others.map(row).collect(),
    }
}

fn counts(first: &str, other: &str, differences: &Differences) -> Table {
    let distinct = |side: usize| {
        let mut counts: Vec<_> = differences.counts.keys().map(|pair| pair[side]).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    };
    let (rows, columns) = (distinct(0), distinct(1));
    let row = |&a: &usize| {
        let cells = columns.iter().map(|&b| differences.counts.get(&[a, b]).copied().unwrap_or(0).to_string());
        [a.to_string()].into_iter().chain(cells).collect()
    };
    Table {
        title: format!("walls by {first} (rows) and by {other} (columns), revolutions"),
        header: ["walls".to_owned()].into_iter().chain(columns.iter().map(ToString::to_string)).collect(),
        rows: rows.iter().map(row).collect(),
    }
}

fn stretches(
    first: &str,
    other: &str,
    differences: &Differences,
    since_start_s: impl Fn(u64) -> f64,
    all: bool,
) -> Table {
    let mut shown: Vec<&Stretch> = differences.stretches.iter().collect();
    if !all && shown.len() > STRETCHES {
        shown.sort_by_key(|stretch| std::cmp::Reverse(stretch.revolutions));
        shown.truncate(STRETCHES);
        shown.sort_by_key(|stretch| stretch.seq[0]);
    }
    let mut title = format!("stretches where the walls of {first} and {other} differ");
    if shown.len() < differences.stretches.len() {
        title += &format!(": the {STRETCHES} longest of {} (--all shows them)", differences.stretches.len());
    }
    let row = |of: &&Stretch| {
        let [from_s, to_s] = of.stamp_ns.map(|stamp_ns| format!("{:.2}", since_start_s(stamp_ns)));
        let [confidence, of_other] =
            of.confidence.map(|of| of.map_or("-".to_owned(), |confidence| format!("{confidence:.2}")));
        let [walls, walls_of_other] = of.junctions.map(|walls| walls.to_string());
        let [from, to] = of.seq.map(|seq| seq.to_string());
        vec![from, to, from_s, to_s, walls, walls_of_other, confidence, of_other]
    };
    let names = [
        format!("walls {first}"),
        format!("walls {other}"),
        format!("confidence {first}"),
        format!("confidence {other}"),
    ];
    Table {
        title,
        header: ["from seq", "to seq", "from s", "to s"].map(str::to_owned).into_iter().chain(names).collect(),
        rows: shown.iter().map(row).collect(),
    }
}

/// All figures and stretches, the complete settings of each configuration, and the problems.
pub(super) fn json(
    configurations: &[Configuration],
    compared: &Compared,
    wrong: &[WrongAnswer<'_>],
    problems: &[String],
) -> String {
    let named = |of: &Configuration| json!({"name": of.name, "settings": of.config.to_string()});
    let comparison = |((other, differences), surer): ((&Configuration, &Differences), &Surer)| {
        let counts = differences.counts.iter();
        let counts: Vec<_> = counts.map(|(walls, n)| json!({"junctions": walls, "revolutions": n})).collect();
        json!({"configuration": other.name, "figures": differences, "counts": counts, "surer": surer})
    };
    let comparisons = configurations[1..].iter().zip(&compared.differences).zip(&compared.surer).map(comparison);
    let document = json!({
        "configurations": configurations.iter().map(named).collect::<Vec<_>>(),
        "against": configurations[0].name,
        "comparisons": comparisons.collect::<Vec<_>>(),
        "verdicts": compared.outcomes.iter().filter(|outcome| outcome.verdict.of > 0).collect::<Vec<_>>(),
        "wrong_answers": wrong,
        "problems": problems,
    });
    format!("{document:#}\n")
}

fn header(first: &str, configurations: &[Configuration]) -> Vec<String> {
    [first.to_owned()].into_iter().chain(configurations.iter().map(|of| of.name.clone())).collect()
}

fn percent(share: Proportion) -> String {
    share.value().map_or_else(|| "-".to_owned(), |share| format!("{:.1}", 100.0 * share))
}
