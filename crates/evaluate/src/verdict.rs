//! Is the second of two configurations better than the first? A sentence with its p.
//!
//! Both answered the same revolutions. Those that the first answers wrong and the second right are **mended**, those that
//! the first answers right and the second wrong are **broken**; the others do not tell them apart. If neither were better,
//! a revolution that tells them apart would be mended with probability 1/2, so the exact test of McNemar is
//! ```text
//! p = min(1, 2 · Σ_{i ≤ min(m, b)} C(m + b, i) / 2^(m + b)),   m mended, b broken
//! ```
//! It assumes independent revolutions. Neighbours in a flight are not, so there p is too small.

use crosscut_stage::counted;
use serde::Serialize;

/// What a second configuration makes better and worse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SwapVerdict {
    /// Revolutions that only the second answers right.
    pub mends: u64,
    /// Revolutions that only the first answers right.
    pub breaks: u64,
    /// Revolutions that both answered.
    pub of: u64,
}

impl SwapVerdict {
    /// Adds a revolution that the first, and the second, answers right or not.
    pub fn add(&mut self, right: [bool; 2]) {
        self.of += 1;
        self.mends += u64::from(right == [false, true]);
        self.breaks += u64::from(right == [true, false]);
    }

    /// Adds the revolutions of `other`.
    pub fn merge(&mut self, other: Self) {
        self.mends += other.mends;
        self.breaks += other.breaks;
        self.of += other.of;
    }

    /// The two-sided p of the exact test of McNemar.
    pub fn p(&self) -> f64 {
        let (tells, fewer) = (self.mends + self.breaks, self.mends.min(self.breaks));
        let sum: f64 = fair_coin(tells).take(fewer as usize + 1).sum();
        (2.0 * sum).min(1.0)
    }

    /// "B mends 119 and breaks 57 of 3,000 (exact McNemar p = 3e-6)"; `holm` is p as [`holm`] corrects it, where there are
    /// several configurations.
    pub fn sentence(&self, second: &str, holm: Option<f64>) -> String {
        let Self { mends, breaks, of } = *self;
        let corrected = holm.map_or_else(String::new, |p| format!(", {} with Holm's correction", short(p)));
        let of = thousands(of);
        let (mends, breaks) = (thousands(mends), thousands(breaks));
        format!("{second} mends {mends} and breaks {breaks} of {of} (exact McNemar p = {}{corrected})", short(self.p()))
    }
}

/// C(n, i) / 2^n for i from 0 to n: the probability of i heads in n tosses of a fair coin.
pub(crate) fn fair_coin(n: u64) -> impl Iterator<Item = f64> {
    // ln C(n, i) - n ln 2, from one i to the next.
    let mut ln_share = -(n as f64) * std::f64::consts::LN_2;
    (0..=n).map(move |i| {
        if i > 0 {
            ln_share += ((n - i + 1) as f64).ln() - (i as f64).ln();
        }
        ln_share.exp()
    })
}

/// Which of two configurations is surer where they differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Surer {
    /// Whether their confidences are computed by the same rule; those of two rules are not compared.
    pub same_rule: bool,
    /// Revolutions whose walls differ.
    pub differ: u64,
    /// Revolutions that both answered.
    pub of: u64,
    /// Where they differ and the first is surer.
    pub first: u64,
    /// Where they differ and the second is surer.
    pub second: u64,
}

impl Surer {
    /// Of no revolution yet, for two configurations whose confidences are computed by these rules (`report.confidence`).
    pub fn by(rules: [&str; 2]) -> Self {
        Self { same_rule: rules[0] == rules[1], differ: 0, of: 0, first: 0, second: 0 }
    }

    /// Adds a revolution with the two confidences.
    pub fn add(&mut self, differ: bool, confidence: [Option<f64>; 2]) {
        self.of += 1;
        self.differ += u64::from(differ);
        if let ([Some(first), Some(second)], true) = (confidence, differ && self.same_rule) {
            self.first += u64::from(first > second);
            self.second += u64::from(second > first);
        }
    }

    /// Adds the revolutions of `other`.
    pub fn merge(&mut self, other: Self) {
        self.differ += other.differ;
        self.of += other.of;
        self.first += other.first;
        self.second += other.second;
    }

    /// "A and B differ in 40 of 688, in 31 of them A is surer".
    pub fn sentence(&self, first: &str, second: &str) -> String {
        let differ = format!("{first} and {second} differ in {} of {}", thousands(self.differ), thousands(self.of));
        match (self.first, self.second) {
            _ if !self.same_rule => {
                format!(
                    "{differ}; their confidences follow two rules (`report.confidence`), so that none is called surer"
                )
            }
            (0, 0) => differ,
            (a, b) if a >= b => format!("{differ}, in {} of them {first} is surer", thousands(a)),
            (_, b) => format!("{differ}, in {} of them {second} is surer", thousands(b)),
        }
    }
}

/// The p of several tests, each corrected for all of them by Holm's step-down method: the smallest times their number, the
/// next times one less, never below one before. Source: Holm 1979, Scandinavian Journal of Statistics 6.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let (mut corrected, mut least) = (vec![0.0; p.len()], 0.0_f64);
    for (rank, &at) in order.iter().enumerate() {
        least = least.max((p.len() - rank) as f64 * p[at]).min(1.0);
        corrected[at] = least;
    }
    corrected
}

/// Numbers as people list them: "3, 7-9, 12"; after `most` parts the rest is counted.
pub fn listed(numbers: &[u64], most: usize) -> String {
    let mut spans: Vec<[u64; 2]> = Vec::new();
    for &number in numbers {
        match spans.last_mut() {
            Some(span) if span[1] + 1 == number => span[1] = number,
            _ => spans.push([number; 2]),
        }
    }
    let part = |[from, to]: &[u64; 2]| if from == to { from.to_string() } else { format!("{from}-{to}") };
    let mut text = spans.iter().take(most).map(part).collect::<Vec<_>>().join(", ");
    let left: u64 = spans.iter().skip(most).map(|[from, to]| to - from + 1).sum();
    if left > 0 {
        text += &format!(" and {}", counted(left, "more revolution").replace("more revolutions", "more"));
    }
    text
}

/// A number with commas between thousands.
pub fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// One digit that counts: 3e-6, 0.04, 1.
pub(crate) fn short(p: f64) -> String {
    if p >= 0.995 {
        "1".to_owned()
    } else if p >= 0.1 {
        format!("{p:.2}")
    } else if p >= 0.001 {
        format!("{p:.*}", if p >= 0.01 { 2 } else { 3 })
    } else {
        // What is less is rounded to nothing.
        format!("{:.0e}", p.max(1e-300))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By scipy 1.17: `binomtest(min(m, b), m + b).pvalue`.
    #[test]
    fn p_is_that_of_an_independent_program() {
        for (mends, breaks, p) in SCIPY {
            let ours = SwapVerdict { mends, breaks, of: 0 }.p();
            assert!((ours - p).abs() <= 1e-10 * p, "{mends} and {breaks}: {ours:e} instead of {p:e}");
        }
    }

    const SCIPY: [(u64, u64, f64); 8] = [
        (119, 57, 3.4184678768492402e-06),
        (57, 119, 3.4184678768492402e-06),
        (0, 0, 1.0),
        (5, 0, 0.0625),
        (3, 4, 1.0),
        (1, 9, 0.021484375),
        (400, 300, 0.0001784763144856244),
        (2500, 2100, 3.943985037158039e-09),
    ];

    #[test]
    fn sentences_have_their_figures() {
        let verdict = SwapVerdict { mends: 119, breaks: 57, of: 3000 };
        assert_eq!(verdict.sentence("B", None), "B mends 119 and breaks 57 of 3,000 (exact McNemar p = 3e-6)");
        let none = SwapVerdict { of: 7, ..SwapVerdict::default() };
        assert_eq!(
            none.sentence("B", Some(1.0)),
            "B mends 0 and breaks 0 of 7 (exact McNemar p = 1, 1 with Holm's correction)"
        );
        let [mut surer, mut by_two] = [["scene"; 2], ["scene", "margin"]].map(Surer::by);
        for (differ, confidence) in
            [(true, [Some(0.9), Some(0.4)]), (true, [None, Some(0.4)]), (false, [Some(0.9), Some(0.1)])]
        {
            surer.add(differ, confidence);
            by_two.add(differ, confidence);
        }
        assert!(by_two.sentence("A", "B").contains("A and B differ in 2 of 3; their confidences follow two rules"));
        assert_eq!(surer.sentence("A", "B"), "A and B differ in 2 of 3, in 1 of them A is surer");
    }

    #[test]
    fn holm_never_lets_a_larger_p_pass_a_smaller_one() {
        // R 4.4: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
        let corrected = holm(&[0.01, 0.04, 0.03, 0.005]);
        for (ours, expected) in corrected.iter().zip([0.03, 0.06, 0.06, 0.02]) {
            assert!((ours - expected).abs() < 1e-15, "{corrected:?}");
        }
        assert_eq!(holm(&[0.9, 0.8]), [1.0, 1.0]);
    }

    #[test]
    fn neighbours_are_listed_as_spans() {
        assert_eq!(listed(&[3, 7, 8, 9, 12], 10), "3, 7-9, 12");
        assert_eq!(listed(&[3, 7, 8, 9, 12, 14], 2), "3, 7-9 and 2 more");
        assert_eq!(
            (listed(&[], 3), thousands(1_234_567), thousands(999)),
            (String::new(), "1,234,567".into(), "999".into())
        );
    }
}
