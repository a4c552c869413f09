//! Tables of a scoreboard, independent of their format.

use crosscut_messages::TruthKind;

use crate::confidence::BINS;
use crate::flights::{FlightFigures, RADIUS_M};
use crate::maps::MapFigures;
use crate::{Evaluation, Figures, Percentiles, Proportion, Scoreboard};

/// A table of text, without a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Title, with the unit.
    pub title: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Rows, each as long as the header.
    pub rows: Vec<Vec<String>>,
}

/// Shares of right answers and of right counts: a row per family, a column per configuration.
pub fn overview(scoreboard: &Scoreboard) -> Vec<Table> {
    let right = |figures: &Figures| match figures.right.interval95() {
        Some([low, high]) => format!("{} [{}, {}]", share(figures.right), percent(Some(low)), percent(Some(high))),
        None => NO_VALUE.to_owned(),
    };
    let mut tables = vec![
        by_family(scoreboard, "right: count equal and every wall matched, % [95 % interval]", right),
        by_family(scoreboard, "right counts, %", |figures| share(figures.right_count)),
    ];
    tables.extend(flights(scoreboard));
    tables
}

/// Places, steady answers and maps of flights: a row for each family that has flights whose mine is known, and
/// configuration. No table without such a flight.
pub fn flights(scoreboard: &Scoreboard) -> Vec<Table> {
    let each = scoreboard.families().iter().map(|family| (family.name.as_str(), family.flights.clone()));
    let all = Some((ALL, scoreboard.all_flights())).filter(|_| scoreboard.families().len() > 1);
    let mut named: Vec<([String; 2], FlightFigures)> = Vec::new();
    for (family, of_configurations) in each.chain(all) {
        for (configuration, figures) in scoreboard.configurations().iter().zip(of_configurations) {
            named.extend(figures.map(|figures| ([family.to_owned(), configuration.clone()], figures)));
        }
    }
    if named.is_empty() { Vec::new() } else { vec![places(&named), maps(&named)] }
}

fn places(named: &[([String; 2], FlightFigures)]) -> Table {
    const KINDS: [TruthKind; 4] = [TruthKind::Junction, TruthKind::Passage, TruthKind::DeadEnd, TruthKind::Chamber];
    let rows = named.iter().flat_map(|(names, figures)| {
        let answers = [
            ("single", &figures.here, figures.count, figures.flicker),
            ("steady", &figures.steady_here, figures.steady_count, figures.steady_flicker),
        ];
        answers.map(|(answer, here, count, flicker)| {
            let of_kinds = KINDS.map(|kind| share(here.get(&kind).copied().unwrap_or_default()));
            let names = names.iter().cloned().chain([answer.to_owned()]);
            names.chain(of_kinds).chain([share(count), number(flicker.value().map(|share| 100.0 * share), 2)]).collect()
        })
    });
    let header =
        ["family", "configuration", "answer", "junction", "passage", "dead end", "chamber", "count right", "flicker"];
    Table {
        title:
            "flights: % of the revolutions whose place is right, by kind of place; right counts; counts that flicker"
                .to_owned(),
        header: header.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    }
}

/// Columns of a table of maps, after those that name the row.
pub const MAP_COLUMNS: [&str; 11] = [
    "exact",
    "F1",
    "nodes / true",
    "same place P",
    "same place R",
    "false merges",
    "ways right",
    "passages (false)",
    "loops (false)",
    "length off",
    "precision, recall",
];

/// The cells of [`MAP_COLUMNS`].
pub fn map_cells(figures: &MapFigures) -> Vec<String> {
    let with_false = |of: Proportion, wrong: u64| format!("{} of {} ({wrong})", of.hits, of.of);
    let has_ways = figures.degree.of + figures.passages.of > 0;
    let lengths = Percentiles::of(&figures.length_errors);
    let only = |cell: String| if has_ways { cell } else { NO_VALUE.to_owned() };
    vec![
        only(format!("{} of {}", figures.exact.hits, figures.exact.of)),
        number(figures.f1(), 3),
        number(figures.over_count(), 2),
        share(figures.same_precision),
        share(figures.same_recall),
        figures.false_merges.to_string(),
        share(figures.degree),
        only(with_false(figures.passages, figures.false_passages)),
        only(with_false(figures.loops, figures.false_loops)),
        percent(lengths.map(|errors| errors.p50)),
        format!("{}, {}", share(figures.precision), share(figures.recall)),
    ]
}

fn maps(named: &[([String; 2], FlightFigures)]) -> Table {
    let radius = format!("{RADIUS_M} m radius");
    let rows = named.iter().flat_map(|(names, figures)| {
        let ways = [("map", &figures.map), ("every change", &figures.every_change), (&radius, &figures.radius)];
        ways.map(|(way, figures)| {
            names.iter().cloned().chain([way.to_owned()]).chain(map_cells(figures)).collect::<Vec<_>>()
        })
    });
    let header = ["family", "configuration", "nodes by"].into_iter().chain(MAP_COLUMNS);
    Table {
        title: "maps: flights whose map is exact; nodes against places, pairs of visits, ways, passages, loops; %"
            .to_owned(),
        header: header.map(str::to_owned).collect(),
        rows: rows.collect(),
    }
}

/// All other figures: tables with a row per family and configuration, then confusion and reliability per configuration.
pub fn details(scoreboard: &Scoreboard) -> Vec<Table> {
    let mut tables = vec![
        by_family_and_configuration(scoreboard, "counts, % of the revolutions", &["right", "over", "under"], |f| {
            [f.right_count, f.over_count, f.under_count].map(share).to_vec()
        }),
        by_family_and_configuration(
            scoreboard,
            "labels: % of the returns right; adjusted Rand index",
            &["returns right", "index p5", "index median"],
            |f| {
                let index = |of: fn(&Percentiles) -> f64| number(f.labels.adjusted_rand_index.as_ref().map(of), 3);
                vec![percent(f.labels.share), index(|p| p.p05), index(|p| p.p50)]
            },
        ),
        by_family_and_configuration(
            scoreboard,
            "openings: % of the true ones missed, % of the reported ones false, also of those seen through; % of the gaps judged; errors of those matched",
            &[
                "missed",
                "false",
                "seen and false",
                "gaps judged",
                "bearing median °",
                "bearing p95 °",
                "width median %",
                "width p95 %",
            ],
            |f| {
                let degrees = |of: fn(&Percentiles) -> f64| {
                    number(f.openings.bearing_error_rad.as_ref().map(|p| of(p).to_degrees()), 1)
                };
                let width = |of: fn(&Percentiles) -> f64| percent(f.openings.width_error.as_ref().map(of));
                vec![
                    share(f.openings.missed),
                    share(f.openings.false_alarms),
                    share(f.openings.seen_false),
                    share(f.openings.judged_gaps),
                    degrees(|p| p.p50),
                    degrees(|p| p.p95),
                    width(|p| p.p50),
                    width(|p| p.p95),
                ]
            },
        ),
        by_family_and_configuration(
            scoreboard,
            "confidence: % of the answers at 0.9 and above, % of those right, right against wrong",
            &["sure", "sure and right", "AUROC"],
            |f| vec![share(f.confidence.sure), share(f.confidence.sure_right), number(f.confidence.auroc, 3)],
        ),
    ];
    for (name, evaluation) in scoreboard.configurations().iter().zip(scoreboard.all()) {
        let figures = evaluation.figures();
        tables.push(confusion(name, &figures));
        tables.push(reliability(name, &figures));
    }
    tables
}

const NO_VALUE: &str = "-";
const ALL: &str = "all";

/// The figures of each family, and of all families together.
fn families(scoreboard: &Scoreboard) -> impl Iterator<Item = (&str, Vec<Figures>)> {
    let figures = |evaluations: &[Evaluation]| evaluations.iter().map(Evaluation::figures).collect::<Vec<_>>();
    let each = scoreboard.families().iter().map(move |family| (family.name.as_str(), figures(&family.evaluations)));
    each.chain([(ALL, figures(&scoreboard.all()))])
}

fn by_family(scoreboard: &Scoreboard, title: &str, cell: impl Fn(&Figures) -> String) -> Table {
    let header = ["family", "revolutions"].into_iter().map(str::to_owned).chain(scoreboard.configurations().to_vec());
    let rows = families(scoreboard).map(|(family, figures)| {
        let revolutions = figures.iter().map(|figures| figures.revolutions).max().unwrap_or(0);
        [family.to_owned(), revolutions.to_string()].into_iter().chain(figures.iter().map(&cell)).collect()
    });
    Table { title: title.to_owned(), header: header.collect(), rows: rows.collect() }
}

fn by_family_and_configuration(
    scoreboard: &Scoreboard,
    title: &str,
    columns: &[&str],
    cells: impl Fn(&Figures) -> Vec<String>,
) -> Table {
    let header = ["family", "configuration"].iter().chain(columns).map(ToString::to_string);
    let mut rows = Vec::new();
    for (family, figures) in families(scoreboard) {
        for (configuration, figures) in scoreboard.configurations().iter().zip(&figures) {
            rows.push([family.to_owned(), configuration.clone()].into_iter().chain(cells(figures)).collect());
        }
    }
    Table { title: title.to_owned(), header: header.collect(), rows }
}

/// Confusion of counts; reported counts far above the true ones share a column.
fn confusion(configuration: &str, figures: &Figures) -> Table {
    let mut truths: Vec<usize> = figures.confusion.iter().map(|entry| entry.truth).collect();
    truths.dedup();
    let beyond = truths.last().map_or(0, |most| most + 3);
    let last = figures.confusion.iter().map(|entry| entry.reported).max().unwrap_or(0).min(beyond);
    let header = (0..=last).map(|n| if n == beyond { format!("{n} and more") } else { n.to_string() });
    let rows = truths.iter().map(|&truth| {
        let cells = (0..=last).map(|column| {
            let entries = figures.confusion.iter().filter(|e| e.truth == truth && e.reported.min(beyond) == column);
            entries.map(|entry| entry.revolutions).sum::<u64>().to_string()
        });
        [truth.to_string()].into_iter().chain(cells).collect()
    });
    Table {
        title: format!("{configuration}: true walls (rows) and reported walls (columns), revolutions of all families"),
        header: ["true".to_owned()].into_iter().chain(header).collect(),
        rows: rows.collect(),
    }
}

fn reliability(configuration: &str, figures: &Figures) -> Table {
    let rows = figures.confidence.reliability.iter().map(|bin| {
        vec![
            format!("{:.1} to {:.1}", bin.from, bin.from + 1.0 / BINS as f64),
            bin.right.of.to_string(),
            number(bin.mean_confidence, 3),
            share(bin.right),
        ]
    });
    Table {
        title: format!("{configuration}: confidence against the share of right answers, all families"),
        header: ["confidence", "answers", "mean confidence", "right %"].map(str::to_owned).to_vec(),
        rows: rows.collect(),
    }
}

fn share(share: Proportion) -> String {
    percent(share.value())
}

fn percent(part: Option<f64>) -> String {
    number(part.map(|part| 100.0 * part), 1)
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| NO_VALUE.to_owned(), |value| format!("{value:.decimals$}"))
}
