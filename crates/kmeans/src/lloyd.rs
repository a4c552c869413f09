//! Lloyd's iteration: rows to their nearest centre, centres to the mean of their rows, until nothing changes.

use crate::rows::{Rows, distance_squared};

/// Centres, and the centre of each row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lloyd {
    /// The centres, one after the other; their number stays what it was at the start.
    pub(crate) centroids: Vec<f64>,
    /// The nearest centre of each row, the first of equals.
    pub(crate) labels: Vec<u32>,
    /// Squared distance of each row to its centre.
    distances: Vec<f64>,
    /// Number of rows of each centre.
    sizes: Vec<usize>,
    moved: Vec<f64>,
    next_labels: Vec<u32>,
}

impl Lloyd {
    /// Puts the centres where the `chosen` rows are.
    pub(crate) fn start_at(&mut self, rows: &Rows, chosen: &[usize]) {
        self.centroids.clear();
        chosen.iter().for_each(|&i| self.centroids.extend_from_slice(rows.row(i)));
    }

    /// Runs from the centres in `self.centroids` until no row changes its centre, no centre moves, or
    /// `max_iterations` were done; whether it settled before that.
    pub(crate) fn run(&mut self, rows: &Rows, max_iterations: usize) -> bool {
        self.labels.clear();
        self.labels.resize(rows.len(), u32::MAX);
        self.assign(rows);
        for _ in 0..max_iterations {
            let has_moved = self.move_centroids(rows);
            if !self.assign(rows) || !has_moved {
                return true;
            }
        }
        false
    }

    /// f(C, U) = Σ_i ‖u_i - c‖², c the centre of row i.
    pub(crate) fn inertia(&self) -> f64 {
        self.distances.iter().sum()
    }

    /// Gives each row its nearest centre; whether any row got another one than before.
    fn assign(&mut self, rows: &Rows) -> bool {
        self.distances.clear();
        self.next_labels.clear();
        for row in rows.iter() {
            let (mut nearest, mut least) = (0, f64::INFINITY);
            for (c, centroid) in (0u32..).zip(self.centroids.chunks_exact(rows.dimension())) {
                let distance = distance_squared(row, centroid);
                if distance < least {
                    (nearest, least) = (c, distance);
                }
            }
            self.next_labels.push(nearest);
            self.distances.push(least);
        }
        let mut changed = self.labels != self.next_labels;
        std::mem::swap(&mut self.labels, &mut self.next_labels);
        self.sizes.clear();
        self.sizes.resize(self.centroids.len() / rows.dimension(), 0);
        self.labels.iter().for_each(|&label| self.sizes[label as usize] += 1);
        while let Some(empty) = self.sizes.iter().position(|&size| size == 0) {
            if !self.fill(empty, rows) {
                break;
            }
            changed = true;
        }
        changed
    }

    /// The rule for a centre without rows: it starts again at the row farthest from its own centre (the first of
    /// equals) among those that are not alone with it. Never twice at one row, which is then alone; not at all if every
    /// row is where its centre is.
    fn fill(&mut self, empty: usize, rows: &Rows) -> bool {
        let mut farthest = None;
        let mut distance = 0.0;
        for (i, (&d, &label)) in self.distances.iter().zip(&self.labels).enumerate() {
            if d > distance && self.sizes[label as usize] > 1 {
                (farthest, distance) = (Some(i), d);
            }
        }
        let Some(i) = farthest else { return false };
        let k = rows.dimension();
        self.centroids[empty * k..][..k].copy_from_slice(rows.row(i));
        self.sizes[self.labels[i] as usize] -= 1;
        self.sizes[empty] = 1;
        self.labels[i] = empty as u32;
        self.distances[i] = 0.0;
        true
    }

    /// Moves each centre to the mean of its rows; whether any moved.
    fn move_centroids(&mut self, rows: &Rows) -> bool {
        let k = rows.dimension();
        self.moved.clear();
        self.moved.resize(self.centroids.len(), 0.0);
        for (row, &label) in rows.iter().zip(&self.labels) {
            for (sum, x) in self.moved[label as usize * k..][..k].iter_mut().zip(row) {
                *sum += x;
            }
        }
        for (c, sums) in self.moved.chunks_exact_mut(k).enumerate() {
            match self.sizes[c] {
                0 => sums.copy_from_slice(&self.centroids[c * k..][..k]),
                size => sums.iter_mut().for_each(|sum| *sum /= size as f64),
            }
        }
        std::mem::swap(&mut self.centroids, &mut self.moved);
        self.centroids != self.moved
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::Spectrum;
    use faer::Mat;

    use super::*;

    fn rows(values: &[[f64; 2]]) -> Rows {
        let u = Mat::from_fn(values.len(), 2, |i, j| values[i][j]);
        let mut rows = Rows::default();
        rows.copy_from(&Spectrum { k: 2, u, ..Spectrum::default() }).expect("finite");
        rows
    }

    #[test]
    fn no_iteration_makes_the_objective_worse() {
        let scattered: Vec<[f64; 2]> = (0..60).map(|i| [f64::from(i * 37 % 61), f64::from(i * i % 53)]).collect();
        let rows = rows(&scattered);
        let mut previous = f64::INFINITY;
        for iterations in 0..20 {
            let mut lloyd = Lloyd { centroids: vec![0.0, 0.0, 1.0, 0.0, 60.0, 50.0], ..Lloyd::default() };
            lloyd.run(&rows, iterations);
            assert!(lloyd.inertia() <= previous, "{} after {previous}", lloyd.inertia());
            previous = lloyd.inertia();
        }
        assert!(previous < 30_000.0, "three centres are better than the spread about one: {previous}");
    }

    #[test]
    fn a_centre_without_rows_starts_again_at_the_farthest_row() {
        let rows = rows(&[[0.0, 0.0], [1.0, 0.0], [6.0, 0.0], [9.0, 0.0]]);
        // Both centres far to the left: the second gets nothing.
        let mut lloyd = Lloyd { centroids: vec![-1.0, 0.0, -50.0, 0.0], ..Lloyd::default() };
        assert!(lloyd.run(&rows, 10));
        assert_eq!(lloyd.labels, [0, 0, 1, 1]);
        assert_eq!((lloyd.centroids.as_slice(), lloyd.inertia()), (&[0.5, 0.0, 7.5, 0.0][..], 5.0));
    }
}
