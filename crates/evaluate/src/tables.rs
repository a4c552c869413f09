//! Tables of a scoreboard, independent of their format.

use crate::confidence::BINS;
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
    vec![
        by_family(scoreboard, "right: count equal and every wall matched, % [95 % interval]", right),
        by_family(scoreboard, "right counts, %", |figures| share(figures.right_count)),
    ]
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
            "openings: % of the true ones missed, % of the reported ones false, errors of those matched",
            &["missed", "false", "bearing median °", "bearing p95 °", "width median %", "width p95 %"],
            |f| {
                let degrees = |of: fn(&Percentiles) -> f64| {
                    number(f.openings.bearing_error_rad.as_ref().map(|p| of(p).to_degrees()), 1)
                };
                let width = |of: fn(&Percentiles) -> f64| percent(f.openings.width_error.as_ref().map(of));
                vec![
                    share(f.openings.missed),
                    share(f.openings.false_alarms),
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
