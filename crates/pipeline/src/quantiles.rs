//! Quantiles of very many numbers in little memory.

/// Smaller numbers are counted one by one, larger ones by their leading bits.
const EXACT: u64 = 1 << (LEADING_BITS + 1);
/// Bits of a large number, after the highest, that decide where it is counted.
const LEADING_BITS: u32 = 6;

/// The frequency of each number, large ones to within 1/128: at most some 4,000 counts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Quantiles {
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

    /// Median and 99th percentile, nearest rank; `None` before the first number.
    pub(crate) fn median_and_p99(&self) -> Option<(u64, u64)> {
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

fn bin(number: u64) -> usize {
    if number < EXACT {
        return number as usize;
    }
    // The highest bit and the LEADING_BITS after it.
    let shift = number.ilog2() - LEADING_BITS;
    ((u64::from(shift) << LEADING_BITS) + (number >> shift)) as usize
}

/// The middle of the numbers of a bin.
fn middle(bin: usize) -> u64 {
    let bin = bin as u64;
    if bin < EXACT {
        return bin;
    }
    let shift = (bin >> LEADING_BITS) - 1;
    let lowest = ((bin & (EXACT / 2 - 1)) + EXACT / 2) << shift;
    lowest + (1 << shift) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_small_numbers_are_exact_and_of_the_nearest_rank() {
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
            assert!(back.abs_diff(number) as f64 <= number as f64 / 128.0, "{number} came back as {back}");
            all.add(number);
        }
        assert!(all.counts.len() <= 64 << LEADING_BITS, "{}", all.counts.len());
    }

    #[test]
    fn bins_ascend_with_their_numbers() {
        let bins: Vec<usize> = (0..5000).map(bin).collect();
        assert!(bins.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1));
    }
}
