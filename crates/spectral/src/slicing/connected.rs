//! The connected parts of a dense W, in an order in which L is narrow.

use super::normalised::Normalised;

/// Smaller entries of D^-1/2 W D^-1/2 connect nothing, and are left out where that makes the envelope smaller: all of
/// them together move the eigenvalues of n returns by n·1e-15 at most (Gershgorin), a twentieth of what k may depend
/// on.
const NOTHING: f64 = 1e-15;
/// Returns that are checked together.
const CHUNK: usize = 8;

/// The returns that have not been found yet.
pub(crate) struct Unseen {
    /// The entry of D^-1/2 of each return, 0 once the return has been found.
    scale: Vec<f64>,
    pub(crate) count: usize,
}

impl Unseen {
    /// All returns.
    pub(crate) fn all(l: &Normalised<'_>) -> Self {
        Self { scale: l.scale.clone(), count: l.scale.len() }
    }

    /// Takes the return of least degree, which is at an end of a wall.
    pub(crate) fn take_first(&mut self) -> Option<u32> {
        let largest = self.scale.iter().copied().fold(0.0, f64::max);
        let first = self.scale.iter().position(|&scale| scale > 0.0 && scale == largest)?;
        self.scale[first] = 0.0;
        self.count -= 1;
        Some(first as u32)
    }

    /// Makes returns unseen again.
    pub(crate) fn put_back(&mut self, l: &Normalised<'_>, members: &[u32]) {
        members.iter().for_each(|&i| self.scale[i as usize] = l.scale[i as usize]);
        self.count += members.len();
    }

    /// Moves those that are connected with return `j` to the end of `found`, from the least degree to larger ones.
    ///
    /// One return after the other as they come to stand in `found`, that is the order of Cuthill and McKee.
    pub(crate) fn take_neighbours(&mut self, l: &Normalised<'_>, j: u32, found: &mut Vec<u32>) {
        if self.count == 0 {
            return;
        }
        let from = found.len();
        let least = NOTHING / l.scale[j as usize];
        // A weight that is no number is not apart, so that it is come upon.
        let is_apart = |weight: f64, scale: f64| (weight * scale).abs() < least;
        let chunks = l.w.col_as_slice(j as usize).chunks(CHUNK).zip(self.scale.chunks_mut(CHUNK));
        for (start, (weights, scale)) in (0..).step_by(CHUNK).zip(chunks) {
            // Most chunks have none: in arrays, it takes a few instructions to see that.
            if let (Ok(weights), Ok(scale)) = (<&[f64; CHUNK]>::try_from(weights), <&[f64; CHUNK]>::try_from(&*scale))
                && (0..CHUNK).fold(true, |all, i| all & is_apart(weights[i], scale[i]))
            {
                continue;
            }
            for (i, (&weight, scale)) in (start..).zip(weights.iter().zip(scale)) {
                if *scale > 0.0 && !is_apart(weight, *scale) {
                    *scale = 0.0;
                    found.push(i);
                }
            }
        }
        self.count -= found.len() - from;
        found[from..].sort_by(|&a, &b| l.degrees[a as usize].total_cmp(&l.degrees[b as usize]));
    }
}
