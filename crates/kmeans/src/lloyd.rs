//! Lloyd's iteration: rows to their nearest centre, centres to the mean of their rows, until nothing changes.

use crate::row_distances::RowDistances;
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
    /// Squared distances of all rows to one centre after the other.
    to_centres: Vec<f64>,
    /// The centres that have moved since their distances were computed.
    has_moved: Vec<bool>,
    /// Number of rows of each centre.
    sizes: Vec<usize>,
    moved: Vec<f64>,
    next_labels: Vec<u32>,
}

impl Lloyd {
    /// Puts the centres where the `chosen` rows are.
    pub(crate) fn start_at(&mut self, rows: &Rows, distances: &mut RowDistances, chosen: &[usize]) {
        self.centroids.clear();
        self.to_centres.clear();
        for &i in chosen {
            self.centroids.extend_from_slice(rows.row(i));
            self.to_centres.extend_from_slice(distances.to(rows, i));
        }
        self.has_moved.clear();
        self.has_moved.resize(chosen.len(), false);
    }

    /// Runs from the centres in `self.centroids` until no row changes its centre, the centres move by no more than
    /// `still` (a sum of squares), or `max_iterations` were done; whether it settled before that.
    pub(crate) fn run(&mut self, rows: &Rows, max_iterations: usize, still: f64) -> bool {
        self.labels.clear();
        self.labels.resize(rows.len(), u32::MAX);
        self.assign(rows);
        for _ in 0..max_iterations {
            let step = self.move_centroids(rows);
            if !self.assign(rows) || step <= still {
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
        self.measure(rows);
        self.distances.clear();
        self.distances.resize(rows.len(), f64::INFINITY);
        self.next_labels.clear();
        self.next_labels.resize(rows.len(), 0);
        for (c, to_centre) in (0u32..).zip(self.to_centres.chunks_exact(rows.len())) {
            for ((&distance, least), nearest) in to_centre.iter().zip(&mut self.distances).zip(&mut self.next_labels) {
                if distance < *least {
                    (*nearest, *least) = (c, distance);
                }
            }
        }
        let mut changed = self.labels != self.next_labels;
        std::mem::swap(&mut self.labels, &mut self.next_labels);
        self.sizes.clear();
        self.sizes.resize(self.has_moved.len(), 0);
        self.labels.iter().for_each(|&label| self.sizes[label as usize] += 1);
        while let Some(empty) = self.sizes.iter().position(|&size| size == 0) {
            if !self.fill(empty, rows) {
                break;
            }
            changed = true;
        }
        changed
    }

    /// Computes the distances to the centres that have moved. Most of many centres have one row, and stay.
    fn measure(&mut self, rows: &Rows) {
        let (n, k) = (rows.len(), rows.dimension());
        let centres = self.centroids.len() / k;
        self.has_moved.resize(centres, true);
        self.to_centres.resize(centres * n, 0.0);
        let columns = self.to_centres.chunks_exact_mut(n).zip(self.centroids.chunks_exact(k));
        for (has_moved, (to_centre, centroid)) in self.has_moved.iter_mut().zip(columns) {
            if std::mem::take(has_moved) {
                rows.iter().zip(to_centre).for_each(|(row, to)| *to = distance_squared(row, centroid));
            }
        }
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
        self.has_moved[empty] = true;
        self.sizes[self.labels[i] as usize] -= 1;
        self.sizes[empty] = 1;
        self.labels[i] = empty as u32;
        self.distances[i] = 0.0;
        true
    }

    /// Moves each centre to the mean of its rows; the sum of the squared steps.
    fn move_centroids(&mut self, rows: &Rows) -> f64 {
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
            self.has_moved[c] |= *sums != self.centroids[c * k..][..k];
        }
        let step = distance_squared(&self.moved, &self.centroids);
        std::mem::swap(&mut self.centroids, &mut self.moved);
        step
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
        rows.copy_from(&Spectrum { k: 2, u: u.into(), ..Spectrum::default() }).expect("finite");
        rows
    }

    #[test]
    fn no_iteration_makes_the_objective_worse() {
        let scattered: Vec<[f64; 2]> = (0..60).map(|i| [f64::from(i * 37 % 61), f64::from(i * i % 53)]).collect();
        let rows = rows(&scattered);
        let mut previous = f64::INFINITY;
        for iterations in 0..20 {
            let mut lloyd = Lloyd { centroids: vec![0.0, 0.0, 1.0, 0.0, 60.0, 50.0], ..Lloyd::default() };
            lloyd.run(&rows, iterations, 0.0);
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
        assert!(lloyd.run(&rows, 10, 0.0));
        assert_eq!(lloyd.labels, [0, 0, 1, 1]);
        assert_eq!((lloyd.centroids.as_slice(), lloyd.inertia()), (&[0.5, 0.0, 7.5, 0.0][..], 5.0));
    }
}
