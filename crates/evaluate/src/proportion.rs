//! A number of hits among a number of cases, with its confidence interval.

use serde::{Serialize, Serializer, ser::SerializeStruct};

/// The normal quantile of a two-sided 95 % interval.
const Z95: f64 = 1.959_963_984_540_054;

/// `hits` of `of` cases. In JSON: `hits`, `of`, `share` and `interval95` (both null without cases).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Proportion {
    /// Number of hits.
    pub hits: u64,
    /// Number of cases.
    pub of: u64,
}

impl Proportion {
    /// Counts one more case.
    pub fn count(&mut self, hit: bool) {
        self.hits += u64::from(hit);
        self.of += 1;
    }

    /// Adds the cases of `other`.
    pub fn merge(&mut self, other: Self) {
        self.hits += other.hits;
        self.of += other.of;
    }

    /// Whether there are no cases.
    pub fn is_of_none(&self) -> bool {
        self.of == 0
    }

    /// p = hits / of; `None` without cases.
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }

    /// The 95 % interval of Wilson's score, within [0, 1]; `None` without cases.
    ///
    /// ```text
    /// (p + z²/2n ± z·sqrt(p(1-p)/n + z²/4n²)) / (1 + z²/n),   z = 1.96
    /// ```
    pub fn interval95(&self) -> Option<[f64; 2]> {
        let (p, n) = (self.value()?, self.of as f64);
        let z2_n = Z95 * Z95 / n;
        let middle = p + 0.5 * z2_n;
        let half = (z2_n * (p * (1.0 - p) + 0.25 * z2_n)).sqrt();
        Some([middle - half, middle + half].map(|end| (end / (1.0 + z2_n)).clamp(0.0, 1.0)))
    }
}

impl Serialize for Proportion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Proportion", 4)?;
        fields.serialize_field("hits", &self.hits)?;
        fields.serialize_field("of", &self.of)?;
        fields.serialize_field("share", &self.value())?;
        fields.serialize_field("interval95", &self.interval95())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(hits: u64, of: u64) -> [f64; 2] {
        Proportion { hits, of }.interval95().expect("something was counted")
    }

    #[test]
    fn wilson_intervals_agree_with_scipy() {
        // scipy.stats.binomtest(hits, of).proportion_ci(method="wilson")
        let known = [
            (0, 10, [0.0, 0.277_532_799_862_889]),
            (7, 10, [0.396_778_147_461_145, 0.892_208_732_593_700]),
            (10, 10, [0.722_467_200_137_111, 1.0]),
            (495, 500, [0.976_806_900_244_269, 0.995_721_246_103_409]),
        ];
        for (hits, of, [low, high]) in known {
            let found = interval(hits, of);
            assert!((found[0] - low).abs() < 1e-12 && (found[1] - high).abs() < 1e-12, "{hits} of {of}: {found:?}");
        }
    }

    #[test]
    fn without_cases_there_is_no_share() {
        assert_eq!((Proportion::default().value(), Proportion::default().interval95()), (None, None));
    }
}
