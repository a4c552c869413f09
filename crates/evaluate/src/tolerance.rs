//! The zero tolerance that scans of a known count suggest.

/// A share of right counts below this is that of a tolerance that does not suit the eigenvalues.
pub const SUITS: f64 = 0.1;

/// Below this an eigenvalue is rounding error.
const ROUNDING: f64 = 1e-15;

/// For each scan the tolerances by which it has as many zeros as true walls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerances {
    /// From above the last zero to the next eigenvalue.
    ranges: Vec<[f64; 2]>,
    scans: usize,
}

impl Tolerances {
    /// Adds a scan of this true number of walls, with its smallest eigenvalues, ascending.
    pub fn add(&mut self, eigenvalues: &[f64], walls: usize) {
        self.scans += 1;
        let last = walls.checked_sub(1).and_then(|last| eigenvalues.get(last));
        if let (Some(last), Some(next)) = (last, eigenvalues.get(walls)) {
            self.ranges.extend(Some([last.max(ROUNDING), *next]).filter(|[from, to]| from < to));
        }
    }

    /// Adds the scans of another flight.
    pub fn merge(&mut self, other: &Self) {
        self.ranges.extend(&other.ranges);
        self.scans += other.scans;
    }

    /// The tolerance by which the most scans have as many zeros as walls, to one digit, and their share of all.
    pub fn best(&self) -> Option<(f64, f64)> {
        let share = |tolerance: f64| {
            let hits = self.ranges.iter().filter(|[from, to]| *from < tolerance && tolerance <= *to).count();
            (tolerance, hits as f64 / self.scans as f64)
        };
        let decades = -14..0;
        let tried = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| share(digit * 10f64.powi(decade))));
        tried.filter(|(_, share)| *share > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tolerance_lies_in_the_gap_of_most_scans() {
        let mut tolerances = Tolerances::default();
        assert_eq!(tolerances.best(), None);
        for _ in 0..3 {
            tolerances.add(&[0.0, 2e-4, 3e-3, 0.1], 2);
        }
        tolerances.add(&[0.0, 1e-8, 1e-7], 2);
        tolerances.add(&[0.0, 1e-8], 2);
        let (tolerance, share) = tolerances.best().expect("four scans have a gap");
        assert!((2e-4..3e-3).contains(&tolerance) && share == 0.6, "{tolerance}: {share}");
    }
}
