//! k-means++: where the centres start (Arthur and Vassilvitskii 2007).

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::rows::{Rows, distance_squared};

/// Chooses rows to start from: the first at random, each further one with a probability in proportion to its squared
/// distance to the nearest chosen so far. Of 2 + ⌊ln k⌋ rows drawn so, the one that leaves the smallest sum of squared
/// distances is taken: the greedy variant of the same paper, with the number of draws that scikit-learn uses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seeding {
    /// Squared distance of each row to the nearest centre.
    nearest: Vec<f64>,
    /// Squared distance of each row to the nearest centre, if the drawn row becomes one.
    drawn: Vec<f64>,
    /// Squared distance of each row to the nearest centre, if the best row drawn so far becomes one.
    best: Vec<f64>,
}

impl Seeding {
    /// The rows to start from: k of them, or as many as there are distinct rows; n and k > 0.
    pub(crate) fn choose(&mut self, rows: &Rows, rng: &mut Pcg64) -> Vec<usize> {
        let k = rows.dimension();
        let first = rng.random_range(0..rows.len());
        let mut chosen = vec![first];
        self.nearest.clear();
        self.nearest.extend(distances_to(rows, first));
        for _ in 1..k {
            let sum: f64 = self.nearest.iter().sum();
            if sum == 0.0 {
                return chosen;
            }
            let mut least = None;
            for _ in 0..draws(k) {
                let row = draw(&self.nearest, rng.random::<f64>() * sum);
                self.drawn.clear();
                self.drawn.extend(self.nearest.iter().zip(distances_to(rows, row)).map(|(d, to_row)| d.min(to_row)));
                let left: f64 = self.drawn.iter().sum();
                if least.is_none_or(|(least, _)| left < least) {
                    least = Some((left, row));
                    std::mem::swap(&mut self.best, &mut self.drawn);
                }
            }
            if let Some((_, row)) = least {
                chosen.push(row);
                std::mem::swap(&mut self.nearest, &mut self.best);
            }
        }
        chosen
    }
}

/// Squared distances of all rows to row `i`.
fn distances_to(rows: &Rows, i: usize) -> impl Iterator<Item = f64> {
    rows.iter().map(move |row| distance_squared(row, rows.row(i)))
}

/// How many rows are drawn for each of k centres.
fn draws(k: usize) -> usize {
    2 + (k as f64).ln() as usize
}

/// The first index at which the running sum of `weights` passes `threshold`; its weight is not zero. If rounding keeps
/// the sum below the threshold, the last index of a nonzero weight.
fn draw(weights: &[f64], threshold: f64) -> usize {
    let mut sum = 0.0;
    let passed = weights.iter().position(|weight| {
        sum += weight;
        sum > threshold
    });
    passed.or_else(|| weights.iter().rposition(|&weight| weight > 0.0)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draw_never_lands_on_a_weight_of_zero() {
        let weights = [0.0, 1.0, 0.0, 3.0, 0.0];
        let drawn: Vec<usize> = [0.0, 0.99, 1.0, 3.99, 4.0, f64::NAN].map(|at| draw(&weights, at)).into();
        assert_eq!(drawn, [1, 1, 3, 3, 3, 3]);
    }
}
