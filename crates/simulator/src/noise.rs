//! Named random generators, and noise that is correlated along a wall or in time.

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

/// The only generator of this crate: a fixed algorithm, because a seed must always give the same bytes.
pub(crate) type Generator = rand_pcg::Pcg64;

/// The generator of `seed` for one `purpose`. Each purpose has its own, so that more draws for one do not change the
/// others.
pub(crate) fn generator(seed: u64, purpose: &str) -> Generator {
    // FNV-1a, because the standard library does not guarantee its hashes.
    let hash = purpose
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    Generator::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(hash))
}

/// A standard normal value.
pub(crate) fn normal(rng: &mut Generator) -> f64 {
    rng.sample(StandardNormal)
}

/// `n` values of unit variance around a closed chain of spacing `step_m`; correlation exp(-s²/2ℓ²) at distance s.
///
/// White noise is convolved with exp(-s²/ℓ²), whose autocorrelation is exp(-s²/2ℓ²), and divided by the kernel's norm.
pub(crate) fn around_closed_chain(n: usize, step_m: f64, length_m: f64, rng: &mut Generator) -> Vec<f64> {
    if n == 0 {
        return Vec::new();
    }
    let reach = ((2.5 * length_m / step_m).ceil() as usize).min(n / 2);
    let kernel: Vec<f64> = (0..=2 * reach)
        .map(|i| {
            let s_m = (i as f64 - reach as f64) * step_m;
            (-(s_m / length_m).powi(2)).exp()
        })
        .collect();
    let norm = kernel.iter().map(|k| k * k).sum::<f64>().sqrt();
    // The chain is closed, so the white noise is repeated beyond its end.
    let white: Vec<f64> = (0..n).map(|_| normal(rng)).collect();
    let unrolled: Vec<f64> = (0..n + 2 * reach).map(|i| white[i % n]).collect();
    (0..n).map(|i| kernel.iter().zip(&unrolled[i..]).map(|(k, w)| k * w).sum::<f64>() / norm).collect()
}

/// Noise along time: stationary, mean 0, correlation exp(-t/τ) (an Ornstein-Uhlenbeck process).
#[derive(Clone, Debug)]
pub(crate) struct Drifting {
    sd: f64,
    time_s: f64,
    value: f64,
}

impl Drifting {
    /// Starts at 0.
    pub(crate) fn new(sd: f64, time_s: f64) -> Self {
        Self { sd, time_s, value: 0.0 }
    }

    /// Advances by `dt_s` and returns the value.
    pub(crate) fn step(&mut self, dt_s: f64, rng: &mut Generator) -> f64 {
        let keep = (-dt_s / self.time_s).exp();
        self.value = keep * self.value + self.sd * (1.0 - keep * keep).sqrt() * normal(rng);
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bumps_have_the_stated_correlation_and_close() {
        let (n, step_m, length_m) = (200_000, 0.1, 1.0);
        let noise = around_closed_chain(n, step_m, length_m, &mut generator(1, "test"));
        let correlation = |lag: usize| (0..n).map(|i| noise[i] * noise[(i + lag) % n]).sum::<f64>() / n as f64;
        assert!((correlation(0) - 1.0).abs() < 0.05, "variance {}", correlation(0));
        assert!((correlation(10) - (-0.5_f64).exp()).abs() < 0.05, "at one length {}", correlation(10));
        assert!(correlation(40).abs() < 0.05, "at four lengths {}", correlation(40));
        let largest_step = (0..n).map(|i| (noise[(i + 1) % n] - noise[i]).abs()).fold(0.0, f64::max);
        assert!((noise[0] - noise[n - 1]).abs() <= largest_step);
        assert!(largest_step < 0.6, "neighbours 0.1 m apart differ by {largest_step}");
    }

    #[test]
    fn purposes_and_seeds_have_separate_generators() {
        let first = |seed, purpose| generator(seed, purpose).random::<u64>();
        assert_eq!(first(1, "walls"), first(1, "walls"));
        assert_ne!(first(1, "walls"), first(2, "walls"));
        assert_ne!(first(1, "walls"), first(1, "lidar"));
    }

    #[test]
    fn drifting_noise_keeps_its_standard_deviation_over_time() {
        let (mut noise, mut rng) = (Drifting::new(2.0, 0.5), generator(3, "test"));
        let n = 100_000;
        let variance = (0..n).map(|_| noise.step(0.1, &mut rng).powi(2)).sum::<f64>() / f64::from(n);
        assert!((variance.sqrt() - 2.0).abs() < 0.1, "standard deviation {}", variance.sqrt());
    }
}
