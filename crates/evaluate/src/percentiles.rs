//! Percentiles of measured values.

use serde::Serialize;

/// The 5th, 50th and 95th percentile by nearest rank.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Percentiles {
    /// Number of values.
    pub count: usize,
    /// 5th percentile.
    pub p05: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
}

impl Percentiles {
    /// Percentiles of values in any order; `None` without values.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = |percent: usize| sorted.get((sorted.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { count: sorted.len(), p05: rank(5)?, p50: rank(50)?, p95: rank(95)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_at_their_nearest_rank() {
        let hundred: Vec<_> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(Percentiles::of(&hundred), Some(Percentiles { count: 100, p05: 5.0, p50: 50.0, p95: 95.0 }));
        assert_eq!(Percentiles::of(&[7.0]), Some(Percentiles { count: 1, p05: 7.0, p50: 7.0, p95: 7.0 }));
        assert_eq!(Percentiles::of(&[2.0, 1.0, 3.0]).map(|p| (p.p05, p.p50, p.p95)), Some((1.0, 2.0, 3.0)));
        assert_eq!(Percentiles::of(&[]), None);
    }
}
