//! How much longer one configuration takes than another for the same revolutions.
//!
//! Each revolution has a ratio of its two times. A machine that is interrupted makes some ratios large, so the median is
//! reported. Its 95 % interval is that of the sign test: if m is the median, each of the n ratios is below m with probability
//! 1/2, so from the ordered ratios x_1 ≤ ... ≤ x_n
//! ```text
//! P(x_l ≤ m ≤ x_{n+1-l}) ≥ 1 - 2 · Σ_{i<l} C(n, i) / 2^n,   l the largest with Σ_{i<l} C(n, i) / 2^n ≤ 0.025
//! ```
//! Source: David and Nagaraja, Order Statistics, 2003, section 7.1. It assumes independent revolutions; neighbours in a flight
//! are alike, so there the interval is too narrow.

use std::collections::BTreeMap;

use crosscut_stage::{Step, Timings};

use crate::tables::Table;
use crate::verdict::fair_coin;

/// Times of the steps of one revolution, nanoseconds; 4.3 s at most.
type StepTimes = [u32; Step::ALL.len()];

/// Times by recording and revolution.
type Taken = BTreeMap<(usize, u64), StepTimes>;

/// The times of several configurations, revolution by revolution.
#[derive(Clone, Debug, Default)]
pub struct Stopwatch {
    names: Vec<String>,
    /// For each configuration.
    taken: Vec<Taken>,
}

/// The median ratio of two times.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ratio {
    median: f64,
    /// `None` with fewer than 6 revolutions.
    interval95: Option<[f64; 2]>,
}

/// The name of the row of all steps but the first, which only reads.
const TOGETHER: &str = "without ingest";

impl Stopwatch {
    /// Of these configurations, without times.
    pub fn new(names: Vec<String>) -> Self {
        let taken = vec![BTreeMap::new(); names.len()];
        Self { names, taken }
    }

    /// Adds what the configuration of this index took for a revolution of a recording.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn add(&mut self, configuration: usize, recording: usize, seq: u64, timings: &Timings) {
        let taken = Step::ALL.map(|step| u32::try_from(timings.ns(step)).unwrap_or(u32::MAX));
        self.taken[configuration].insert((recording, seq), taken);
    }

    /// The median time of all steps but ingest of the configuration of this index, ms. `None` without revolutions.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn median_ms(&self, configuration: usize) -> Option<f64> {
        median_ms(&self.taken[configuration], &Step::ALL[1..])
    }

    /// The median time of each step by configuration, ms, and beside it how much longer each takes than the first. `when` says
    /// under which circumstances. `None` without revolutions.
    pub fn table(&self, when: &str) -> Option<Table> {
        let (first, others) = self.taken.split_first().filter(|(first, _)| !first.is_empty())?;
        let row = |name: &str, steps: &[Step]| {
            let of = |taken: &StepTimes| sum_ns(taken, steps);
            let cell = |taken: &Taken| median_ms(taken, steps).map_or("-".to_owned(), |ms| format!("{ms:.3}"));
            let relative = others.iter().flat_map(|other| {
                let pairs =
                    first.iter().filter_map(|(revolution, taken)| Some([of(taken), of(other.get(revolution)?)]));
                [cell(other), Ratio::of(pairs).map_or("-".to_owned(), |ratio| ratio.to_string())]
            });
            [name.to_owned(), cell(first)].into_iter().chain(relative).collect()
        };
        let relative = self.names[1..].iter().flat_map(|name| [name.clone(), format!("/ {}", self.names[0])]);
        let beside = if others.is_empty() { "" } else { "; relative: median ratio [95 % interval of the sign test]" };
        Some(Table {
            title: format!("median time of a revolution, ms, {when}{beside}"),
            header: ["stage".to_owned(), self.names[0].clone()].into_iter().chain(relative).collect(),
            rows: Step::ALL
                .iter()
                .map(|step| row(step.name(), &[*step]))
                .chain([row(TOGETHER, &Step::ALL[1..])])
                .collect(),
        })
    }
}

impl Ratio {
    /// Of the second to the first; pairs whose first took no time are left out. `None` if none is left.
    fn of(pairs: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let mut ratios: Vec<f64> =
            pairs.filter(|[first, _]| *first > 0.0).map(|[first, second]| second / first).collect();
        let median = median(&mut ratios)?;
        let mut below = 0.0;
        let within = |share: &f64| {
            below += share;
            below <= 0.025
        };
        let rank = fair_coin(ratios.len() as u64).take_while(within).count();
        let interval95 = (rank > 0).then(|| [ratios[rank - 1], ratios[ratios.len() - rank]]);
        Some(Self { median, interval95 })
    }
}

impl std::fmt::Display for Ratio {
    /// "0.18 [0.17, 0.19]"; small ratios with three decimals.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let decimals = if self.median < 0.1 { 3 } else { 2 };
        write!(f, "{:.decimals$}", self.median)?;
        self.interval95.map_or(Ok(()), |[low, high]| write!(f, " [{low:.decimals$}, {high:.decimals$}]"))
    }
}

fn sum_ns(taken: &StepTimes, steps: &[Step]) -> f64 {
    steps.iter().map(|step| f64::from(taken[*step as usize])).sum()
}

fn median_ms(taken: &Taken, steps: &[Step]) -> Option<f64> {
    let median_ns = median(&mut taken.values().map(|taken| sum_ns(taken, steps)).collect::<Vec<_>>());
    median_ns.map(|ns| ns * 1e-6)
}

/// Sorts the values; the mean of the middle two if their number is even.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(0.5 * (values[last / 2] + values[last.div_ceil(2)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(ratios: &[f64]) -> Ratio {
        Ratio::of(ratios.iter().map(|ratio| [2.0, 2.0 * ratio])).expect("there are ratios")
    }

    /// The ranks are those of exact sums of whole numbers (Python's `math.comb`).
    #[test]
    fn the_interval_ends_at_the_ranks_of_an_independent_program() {
        for (n, rank) in [(6, 1), (10, 2), (100, 40), (1000, 469)] {
            let ratios: Vec<f64> = (1..=n).rev().map(f64::from).collect();
            let found = ratio(&ratios);
            assert_eq!(found.median, 0.5 * f64::from(n + 1));
            assert_eq!(found.interval95, Some([f64::from(rank), f64::from(n + 1 - rank)]), "{n}");
        }
        assert_eq!(ratio(&[1.0, 2.0, 3.0, 4.0, 5.0]), Ratio { median: 3.0, interval95: None });
    }

    #[test]
    fn only_revolutions_of_both_are_compared() {
        let mut stopwatch = Stopwatch::new(["A", "B"].map(str::to_owned).to_vec());
        assert_eq!(stopwatch.table("here"), None);
        let timings = |ns: u64| {
            let mut timings = Timings::default();
            timings.set_ns(Step::Affinity, ns);
            timings
        };
        for seq in 0..10 {
            stopwatch.add(0, 0, seq, &timings(1_000_000));
            stopwatch.add(1, usize::from(seq >= 8), seq, &timings(if seq < 8 { 250_000 } else { u64::MAX }));
        }
        let table = stopwatch.table("here").expect("there are times");
        assert_eq!(table.header, ["stage", "A", "B", "/ A"]);
        assert_eq!(table.rows[1], ["affinity", "1.000", "0.250", "0.25 [0.25, 0.25]"]);
        assert_eq!(table.rows[5][3], "0.25 [0.25, 0.25]");
        assert_eq!(table.rows[2], ["spectral", "0.000", "0.000", "-"]);
    }
}
