//! Quantiles of very many numbers in little memory.

/// From one bin of numbers to the next, numbers grow by a factor of 2 to this power: by 1.1 %.
const BIN_OCTAVES: f64 = 1.0 / 64.0;

/// How often numbers of each size occur, to 1 %: at most 4,097 counts.
#[derive(Clone, Debug, Default)]
pub struct Quantiles {
    counts: Vec<u64>,
    total: u64,
}

impl Quantiles {
    pub(crate) fn add(&mut self, number: u64) {
        let at = bin(number);
        if at >= self.counts.len() {
            self.counts.resize(at + 1, 0);
        }
        self.counts[at] += 1;
        self.total += 1;
    }

    /// Median and 99th percentile, nearest rank, to 1 %; `None` before the first number.
    pub fn median_and_p99(&self) -> Option<(u64, u64)> {
        Some((self.percentile(50)?, self.percentile(99)?))
    }

    fn percentile(&self, percent: u64) -> Option<u64> {
        let rank = (u128::from(self.total) * u128::from(percent)).div_ceil(100) as u64;
        let mut passed = 0;
        let at = self.counts.iter().position(|count| {
            passed += count;
            passed >= rank.max(1)
        })?;
        Some(middle(at))
    }
}

/// The bin of a number, 0 in the first one.
fn bin(number: u64) -> usize {
    ((number as f64 + 1.0).log2() / BIN_OCTAVES) as usize
}

/// The middle of the numbers of a bin.
fn middle(bin: usize) -> u64 {
    (((bin as f64 + 0.5) * BIN_OCTAVES).exp2() - 1.0).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_nearest_rank() {
        let mut quantiles = Quantiles::default();
        assert_eq!(quantiles.median_and_p99(), None);
        (1..=100).rev().for_each(|number| quantiles.add(number));
        assert_eq!(quantiles.median_and_p99(), Some((50, 99)));
        let mut one = Quantiles::default();
        one.add(7);
        assert_eq!(one.median_and_p99(), Some((7, 7)));
    }

    #[test]
    fn a_number_of_any_size_comes_back_to_one_percent_and_the_memory_stays_bounded() {
        let mut all = Quantiles::default();
        for number in (0..64).flat_map(|bit| [1u64 << bit, (1 << bit) + (1 << bit) / 3, (1 << bit) - 1, u64::MAX]) {
            let back = middle(bin(number));
            assert!(back.abs_diff(number) as f64 <= number as f64 / 100.0, "{number} came back as {back}");
            all.add(number);
        }
        assert!(all.counts.len() <= 4097, "{}", all.counts.len());
    }
}
