//! A comparison as text, as JSON and as CSV. No file holds times, so that it is the same whenever it is made.

use std::collections::BTreeMap;

use crosscut_evaluate::experiment::{self, Experiment, Outcome};
use crosscut_evaluate::flights::FlightFigures;
use crosscut_evaluate::tables::{self, Table};
use crosscut_evaluate::times::Stopwatch;
use crosscut_evaluate::tolerance::{SUITS, Tolerances};
use crosscut_evaluate::verdict::Surer;
use crosscut_evaluate::{Differences, Evaluation, Proportion, Scoreboard, Stretch};
use crosscut_stage::counted;
use serde_json::{Value, json};

use super::flight::{Answers, Compared};
use crate::input::InputArgs;
use crate::input::configurations::{Configuration, Grid};
use crate::output::looking::{self, Looks, WrongAnswer};
use crate::output::typeset;

/// This many of the longest stretches are shown by default.
const STRETCHES: usize = 15;

/// The figures of a row of CSV.
const FIGURES: [&str; 14] = [
    "revolutions",
    "failed",
    "mean_walls",
    "flips",
    "mean_confidence",
    "sure",
    "same_walls",
    "compared",
    "right",
    "right_count",
    "sure_right",
    "auroc",
    "openings_missed",
    "openings_false",
];

/// All flights together.
pub(super) struct Shown<'a> {
    configurations: &'a [Configuration],
    grid: &'a Grid,
    flights: &'a [Compared],
    scoreboard: Scoreboard,
    outcomes: Vec<Outcome>,
    stopwatch: Stopwatch,
    /// Of every configuration but the first.
    differences: Vec<Differences>,
    surer: Vec<Surer>,
    looks: Looks<'a>,
}

impl<'a> Shown<'a> {
    pub(super) fn of(
        configurations: &'a [Configuration],
        grid: &'a Grid,
        input: &InputArgs,
        flights: &'a [Compared],
    ) -> Self {
        let names: Vec<String> = configurations.iter().map(|of| of.name.clone()).collect();
        let (mut scoreboard, mut experiment) = (Scoreboard::new(names.clone()), Experiment::new(names.clone()));
        let mut stopwatch = Stopwatch::new(names);
        let mut differences = vec![Differences::default(); configurations.len() - 1];
        let mut surer: Vec<Surer> = flights.first().map_or_else(Vec::new, |first| first.surer.clone());
        for (number, of) in flights.iter().enumerate() {
            for (place, answers) in of.answers.iter().enumerate() {
                answers.timings.iter().for_each(|(seq, timings)| stopwatch.add(place, number, *seq, timings));
                if of.has_truth {
                    scoreboard.merge(&of.name, place, &answers.evaluation);
                    answers.flight.iter().for_each(|figures| scoreboard.add_flight(&of.name, place, figures));
                    answers.right.iter().for_each(|(seq, right)| experiment.add(&of.name, place, *seq, *right));
                }
            }
            for (sum, part) in differences.iter_mut().zip(&of.differences) {
                sum.merge(part.clone(), &of.name);
            }
        }
        for of in flights.iter().skip(1) {
            surer.iter_mut().zip(&of.surer).for_each(|(sum, part)| sum.merge(*part));
        }
        let options = configurations.iter().map(|of| [input.options(), of.options.clone()].concat()).collect();
        let again = flights.iter().filter(|of| !of.parts.is_empty());
        let looks = Looks { flights: again.map(|of| (of.name.as_str(), &of.parts[..])).collect(), options };
        let outcomes = experiment.outcomes();
        Self { configurations, grid, flights, scoreboard, outcomes, stopwatch, differences, surer, looks }
    }

    /// The verdict where there is a truth, else where the configurations differ; `details`: all of both.
    pub(super) fn text(&self, details: bool) -> String {
        let has_truth = self.flights.iter().any(|of| of.has_truth);
        let shows_differences =
            self.configurations.len() > 1 && (details || self.flights.iter().any(|of| !of.has_truth));
        let wrong = self.looks.wrong_answers(&self.outcomes);
        let mut sentences = experiment::sentences(&self.outcomes);
        if shows_differences {
            sentences.extend(self.others(&self.surer).map(|(other, surer)| surer.sentence(self.first(), other)));
        }
        sentences.extend(self.other_tolerances());
        sentences.extend(looking::hint(&wrong, details));
        let mut shown = Vec::new();
        if !self.grid.keys.is_empty() {
            shown.push(self.combinations());
        }
        if has_truth && (details || self.grid.keys.is_empty()) {
            shown.extend(tables::overview(&self.scoreboard));
            shown.extend(experiment::tables(&self.outcomes));
        } else {
            shown.extend(tables::flights(&self.scoreboard));
        }
        if has_truth && details {
            shown.extend(tables::details(&self.scoreboard));
        }
        if shows_differences {
            shown.extend([self.settings(), self.agreement()]);
            if details || self.grid.keys.is_empty() {
                shown.extend(self.others(&self.differences).map(|(other, of)| counts(self.first(), other, of)));
                let stretches = self.others(&self.differences).map(|(other, of)| self.stretches(other, of, details));
                shown.extend(stretches);
            }
        }
        if details || self.grid.keys.is_empty() {
            shown.extend(self.stopwatch.table("one after the other"));
        }
        shown.extend(looking::table(&wrong).filter(|_| details));
        let to_look = if shows_differences { self.to_look() } else { None };
        let sentences: String = sentences.into_iter().map(|sentence| sentence + "\n").collect();
        let space = if sentences.is_empty() { "" } else { "\n" };
        format!("{sentences}{space}{}{}", typeset::text(&shown), to_look.unwrap_or_default())
    }

    /// For each configuration by which hardly any count is right, the zero tolerance that the scans suggest: the eigenvalues of a
    /// stage of one's own may lie elsewhere.
    fn other_tolerances(&self) -> Vec<String> {
        const KEY: &str = "spectral.zero_tolerance";
        let hint = |(place, of): (usize, &Configuration)| {
            let mut tolerances = Tolerances::default();
            self.flights.iter().for_each(|flight| tolerances.merge(&flight.answers[place].tolerances));
            let right = self.scoreboard.all()[place].figures().right_count.value()?;
            let (tolerance, share) = tolerances.best().filter(|(_, share)| right < SUITS && *share > right + SUITS)?;
            of.config.settings().find(|(key, _)| key == KEY)?;
            Some(format!(
                "{}: {:.1} % of its counts are right; its eigenvalues suggest another tolerance: with --set {KEY}={tolerance:e} \
                 about {:.1} % would be",
                of.name,
                100.0 * right,
                100.0 * share
            ))
        };
        self.configurations.iter().enumerate().filter_map(hint).collect()
    }

    /// The commands that show the first stretch where the first two configurations differ.
    fn to_look(&self) -> Option<String> {
        let stretches = &self.differences.first()?.stretches;
        let Stretch { flight, seq: [from, _], .. } = stretches.first()?;
        let (a, b) = (self.looks.look(flight, 0, "A")?, self.looks.look(flight, 1, "B")?);
        let commands = [a.record.clone(), b.record.clone(), Some(a.beside(&b, *from))];
        let commands: String = commands.into_iter().flatten().map(|command| format!("  {command}\n")).collect();
        let [of_a, of_b] = [0, 1].map(|place| &self.configurations[place].name);
        let other = if stretches.len() > 1 { "; --at takes any other" } else { "" };
        Some(format!("\nto see where {of_a} and {of_b} differ, from revolution {from} on{other}:\n{commands}"))
    }

    fn first(&self) -> &str {
        &self.configurations[0].name
    }

    fn others<'s, T>(&'s self, of: &'s [T]) -> impl Iterator<Item = (&'s str, &'s T)> {
        self.configurations[1..].iter().map(|other| other.name.as_str()).zip(of)
    }

    /// A row for each configuration, over all flights.
    fn combinations(&self) -> Table {
        let percent = |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1}", 100.0 * share));
        let row = |(place, of): (usize, &Configuration)| {
            let mut all = Answers::default();
            self.flights.iter().for_each(|flight| all.merge(&flight.answers[place]));
            let figures = all.evaluation.figures();
            let ms = self.stopwatch.median_ms(place).map_or("-".to_owned(), |ms| format!("{ms:.3}"));
            let shares = [figures.right.value(), all.sure(), figures.confidence.sure_right.value()].map(percent);
            let [right, sure, sure_right] = shares;
            vec![of.name.clone(), all.revolutions().to_string(), right, sure, sure_right, all.flips.to_string(), ms]
        };
        let columns = ["configuration", "revolutions", "right %", "sure %", "right of sure %", "flips", "ms"];
        Table {
            title: "configurations, over all flights".to_owned(),
            header: columns.map(str::to_owned).to_vec(),
            rows: self.configurations.iter().enumerate().map(row).collect(),
        }
    }

    /// Settings that two configurations have with different values. A setting that only one kind has follows from the kind.
    fn settings(&self) -> Table {
        let configurations = self.configurations;
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
        let names = configurations.iter().map(|of| of.name.clone());
        Table {
            title: "settings that differ".to_owned(),
            header: ["setting".to_owned()].into_iter().chain(names).collect(),
            rows: values.into_iter().filter(|(_, cells)| differ(cells)).map(row).collect(),
        }
    }

    fn agreement(&self) -> Table {
        let has_ways = self.differences.iter().any(|of| !of.ways_lacking.is_of_none() || !of.ways_more.is_of_none());
        let columns = [
            "configuration",
            "revolutions",
            "by one only",
            "same count",
            "same k",
            "same walls",
            "same returns",
            "openings missing",
            "openings added",
            "ways missing",
            "ways added",
        ];
        let columns = &columns[..if has_ways { columns.len() } else { columns.len() - 2 }];
        let percent = |share: Proportion| share.value().map_or("-".to_owned(), |share| format!("{:.1}", 100.0 * share));
        let row = |(other, of): (&str, &Differences)| {
            let ways = [of.ways_lacking, of.ways_more].into_iter().filter(|_| has_ways);
            let shares =
                [of.same_count, of.same_k, of.same_walls, of.returns_alike, of.openings_lacking, of.openings_more];
            let shares = shares.into_iter().chain(ways);
            let [by_both, by_one] = [of.same_count.of, of.answered_by_one.iter().sum()];
            [other.to_owned(), by_both.to_string(), by_one.to_string()].into_iter().chain(shares.map(percent)).collect()
        };
        Table {
            title: format!("against {}, %", self.first()),
            header: columns.iter().map(|&name| name.to_owned()).collect(),
            rows: self.others(&self.differences).map(row).collect(),
        }
    }

    /// Times are seconds after the first scan of the flight.
    fn stretches(&self, other: &str, differences: &Differences, all: bool) -> Table {
        let first = self.first();
        let mut shown: Vec<&Stretch> = differences.stretches.iter().collect();
        if !all && shown.len() > STRETCHES {
            let mut longest: Vec<usize> = (0..shown.len()).collect();
            longest.sort_by_key(|at| std::cmp::Reverse(shown[*at].revolutions));
            longest.truncate(STRETCHES);
            longest.sort_unstable();
            shown = longest.into_iter().map(|at| shown[at]).collect();
        }
        let or_ways = if differences.stretches.iter().any(|of| of.ways.is_some()) { " or ways" } else { "" };
        let mut title = format!("stretches where the walls{or_ways} of {first} and {other} differ");
        if shown.len() < differences.stretches.len() {
            title += &format!(": the {STRETCHES} longest of {} (--details shows them)", differences.stretches.len());
        }
        let names = ["from seq", "to seq", "from s", "to s"].map(str::to_owned).into_iter().chain([
            format!("walls {first}"),
            format!("walls {other}"),
            format!("confidence {first}"),
            format!("confidence {other}"),
        ]);
        let flight = (self.flights.len() > 1).then(|| "flight".to_owned());
        Table {
            title,
            header: flight.into_iter().chain(names).collect(),
            rows: shown.iter().map(|stretch| self.stretch(stretch)).collect(),
        }
    }

    fn stretch(&self, of: &Stretch) -> Vec<String> {
        let flight = self.flights.iter().find(|flight| flight.name == of.flight).expect("it is of a flight");
        let since_start_s = |stamp_ns: u64| {
            flight.flown.starts_at_s + (i128::from(stamp_ns) - i128::from(flight.first_stamp_ns)) as f64 / 1e9
        };
        let [from, to] = of.seq.map(|seq| seq.to_string());
        let [from_s, to_s] = of.stamp_ns.map(|stamp_ns| format!("{:.2}", since_start_s(stamp_ns)));
        let ways = of.ways.map(|ways| ways.map(|ways| format!(", {} on", counted(ways as u64, "way"))));
        let [ways, ways_of_other] = ways.unwrap_or_default();
        let [walls, walls_of_other] = of.junctions;
        let (walls, mut walls_of_other) = (format!("{walls}{ways}"), format!("{walls_of_other}{ways_of_other}"));
        if walls == walls_of_other {
            walls_of_other += " (grouped otherwise)";
        }
        let [confidence, of_other] =
            of.confidence.map(|of| of.map_or("-".to_owned(), |confidence| format!("{confidence:.2}")));
        let name = (self.flights.len() > 1).then(|| of.flight.clone());
        name.into_iter().chain([from, to, from_s, to_s, walls, walls_of_other, confidence, of_other]).collect()
    }

    /// All figures by family and configuration, verdicts, differences, the complete settings of each configuration, and the
    /// problems.
    pub(super) fn json(&self, problems: &[String]) -> String {
        let wrong: Vec<WrongAnswer<'_>> = self.looks.wrong_answers(&self.outcomes);
        let named = |of: &Configuration| json!({"name": of.name, "settings": of.config.to_string()});
        let comparison = |((other, differences), surer): ((&str, &Differences), &Surer)| {
            let counts = differences.counts.iter();
            let counts: Vec<_> = counts.map(|(walls, n)| json!({"junctions": walls, "revolutions": n})).collect();
            json!({"configuration": other, "figures": differences, "counts": counts, "surer": surer})
        };
        let results = |evaluations: &[Evaluation], flights: &[Option<FlightFigures>]| -> Vec<Value> {
            let named = self.configurations.iter().zip(evaluations).zip(flights);
            let result = |((of, evaluation), flight): ((&Configuration, &Evaluation), &Option<FlightFigures>)| {
                let mut result = json!({"configuration": of.name, "figures": evaluation.figures()});
                if let Some(flight) = flight {
                    result["flight"] = json!(flight);
                }
                result
            };
            named.map(result).collect()
        };
        let families = self.scoreboard.families().iter();
        let families = families.map(|of| json!({"family": of.name, "results": results(&of.evaluations, &of.flights)}));
        let document = json!({
            "configurations": self.configurations.iter().map(named).collect::<Vec<_>>(),
            "against": self.first(),
            "verdicts": self.outcomes.iter().filter(|outcome| outcome.verdict.of > 0).collect::<Vec<_>>(),
            "wrong_answers": wrong,
            "families": families.collect::<Vec<_>>(),
            "all": results(&self.scoreboard.all(), &self.scoreboard.all_flights()),
            "comparisons": self.others(&self.differences).zip(&self.surer).map(comparison).collect::<Vec<_>>(),
            "problems": problems,
        });
        format!("{document:#}\n")
    }

    /// A row for each flight and configuration: the settings of the grid, and figures, empty where there is nothing to tell.
    pub(super) fn csv(&self) -> String {
        let names = ["flight", "configuration"].into_iter().chain(self.grid.keys.iter().map(String::as_str));
        let mut text = line(names.chain(FIGURES).map(str::to_owned));
        for flight in self.flights {
            for (place, (of, answers)) in self.configurations.iter().zip(&flight.answers).enumerate() {
                let first = [flight.name.clone(), of.name.clone()].into_iter().chain(of.point.iter().cloned());
                let differences = place.checked_sub(1).map(|other| &flight.differences[other]);
                text += &line(first.chain(figures_of(answers, differences)));
            }
        }
        text
    }
}

fn figures_of(answers: &Answers, differences: Option<&Differences>) -> [String; FIGURES.len()] {
    let figures = answers.evaluation.figures();
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let share = |share: Proportion| number(share.value());
    [
        answers.revolutions().to_string(),
        answers.without().to_string(),
        number(answers.mean_walls()),
        answers.flips.to_string(),
        number(answers.mean_confidence()),
        number(answers.sure()),
        differences.map_or_else(String::new, |of| share(of.same_walls)),
        figures.revolutions.to_string(),
        share(figures.right),
        share(figures.right_count),
        share(figures.confidence.sure_right),
        number(figures.confidence.auroc),
        share(figures.openings.missed),
        share(figures.openings.false_alarms),
    ]
}

/// A line of CSV.
fn line(cells: impl Iterator<Item = String>) -> String {
    cells.map(|cell| typeset::csv_field(&cell).into_owned()).collect::<Vec<_>>().join(",") + "\n"
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
