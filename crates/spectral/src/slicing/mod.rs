//! `slicing`: the lowest eigenvalues of a dense W, connected part by connected part.

mod connected;
mod envelope;
mod krylov;
mod normalised;

use crosscut_stage::NoteCode::N070;
use crosscut_stage::{Affinity, Count, Kind, Notes, SpectralStage, Spectrum, StageError, Weights};
use faer::Mat;

use crate::decomposition::Decomposition;
use crate::embedding::{make_zero, sign_of_largest};
use crate::zeros::{ZERO_TOLERANCE, count_zeros};
use connected::Unseen;
use envelope::Envelope;
use krylov::{Krylov, Lowest};
use normalised::Normalised;

/// Smaller parts are decomposed in full, which is faster: those of fewer returns than this and the next.
const FEWEST_RETURNS: usize = 20;
/// What each eigenvalue adds to that number of returns.
const RETURNS_PER_EIGENVALUE: usize = 4;
/// Eigenvalues of a part that are computed beyond its share.
const SPARE: usize = 2;

const EIGENVALUES: Count = Count::new("eigenvalues", "", 1)
    .from(1)
    .to(1000)
    .doc("at least this many of the smallest are computed, and always the zeros and the next");

/// The fast solver of dense graphs.
pub const KIND: Kind<dyn SpectralStage> = Kind::spectral(
    "slicing",
    "the lowest eigenvalues of a dense Laplacian, by the inertia of L - τI and shift-and-invert, as in the paper",
    |params| {
        Box::new(Slicing {
            tolerance: params.get(ZERO_TOLERANCE),
            eigenvalues: params.get(EIGENVALUES),
            envelope: Envelope::default(),
            krylov: Krylov::default(),
            full: Decomposition::default(),
        })
    },
)
.params(&[ZERO_TOLERANCE.spec, EIGENVALUES.spec]);

/// Entries of D^-1/2 W D^-1/2 below 1e-15 set aside, L is block diagonal. Of each block B:
///
/// 1. Its returns are ordered so that L_B is narrow (Cuthill, McKee): what lies outside its envelope is not worked on.
/// 2. D^1/2 (L_B - τI) D^1/2 = M Δ Mᵀ; as many eigenvalues are below τ as Δ has negative entries (Sylvester's law of
///    inertia). So k is known before any eigenvector.
/// 3. Block Krylov spaces of (L_B - τI)⁻¹ from random columns give the lowest eigenvalues and their eigenvectors, until
///    all residuals are small. They must agree with the count; a block in which they do not, as where τ is near rounding, or
///    in which a pivot is 0, is decomposed in full, with a note.
///
/// A block of few returns for the eigenvalues that are wanted of it, as where it has many zeros, is decomposed in full: that is
/// faster.
///
/// Of the eigenvalues that are asked for, a block first computes its share of the trace of D^-1/2 W D^-1/2, and all of them
/// only if it may have more.
///
/// The zeros are found to 100·n·ε, and their span to 100·n·ε / (λ_k+1 - λ_k); the other eigenvalues to 1e-12. k is that
/// of a full decomposition unless an eigenvalue is within 100·n·ε of τ.
struct Slicing {
    tolerance: f64,
    eigenvalues: usize,
    envelope: Envelope,
    krylov: Krylov,
    full: Decomposition,
}

/// The lowest eigenpairs of returns that are connected, `members` in the order of the rows.
struct Part {
    members: Vec<u32>,
    lowest: Lowest,
}

impl Part {
    /// Whether there may be more of the `wanted` lowest eigenvalues of all parts, up to `last`, in this one.
    fn may_lack(&self, wanted: usize, last: f64) -> bool {
        let known = &self.lowest.eigenvalues;
        known.len() < wanted.min(self.members.len()) && known.last().is_none_or(|&highest| highest < last)
    }
}

impl Slicing {
    /// The zeros and the next eigenvalue, or `eigenvalues` of the returns if that is more, of the part of return `first`.
    fn solve(
        &mut self,
        l: &Normalised<'_>,
        first: u32,
        eigenvalues: impl Fn(&[u32]) -> usize,
        unseen: &mut Unseen,
        notes: &mut Notes,
    ) -> Result<Part, StageError> {
        let Self { tolerance, envelope, krylov, full, .. } = self;
        let tolerance = *tolerance;
        let factorised = envelope.factorise(l, first, unseen, tolerance);
        if !factorised {
            l.check_finite()?;
        }
        let members = envelope.members.clone();
        let n = members.len();
        let wanted = eigenvalues(&members).max(envelope.zeros() + 1).min(n);
        if n >= FEWEST_RETURNS + RETURNS_PER_EIGENVALUE * wanted {
            match if factorised { krylov.lowest(l, envelope, wanted) } else { Ok(None) } {
                Ok(Some(lowest)) => return Ok(Part { members, lowest }),
                Ok(None) | Err(StageError::NoConvergence { .. }) => {}
                Err(error) => return Err(error),
            }
            notes.add(N070, format!("slicing: {n} connected returns by full decomposition"));
        }
        let mut all = Vec::new();
        full.decompose(l.form(&members).as_ref(), &mut all)?;
        let below = all.partition_point(|&eigenvalue| eigenvalue < tolerance);
        all.truncate(wanted.max(below + 1));
        let vectors = Mat::from_fn(n, all.len(), |i, j| full.eigenvector(j)[i]);
        Ok(Part { members, lowest: Lowest { eigenvalues: all, vectors } })
    }
}

impl SpectralStage for Slicing {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, notes: &mut Notes) -> Result<(), StageError> {
        let copy;
        let w = match &affinity.weights {
            Weights::Dense(w) => w,
            sparse => {
                copy = sparse.to_dense();
                &copy
            }
        };
        let l = Normalised::new(affinity, w)?;
        let mut unseen = Unseen::all(&l);
        let mut parts = Vec::new();
        let all = self.eigenvalues;
        let trace: f64 = l.degrees.iter().map(|degree| degree.recip()).sum();
        let share = |members: &[u32]| {
            let of_part: f64 = members.iter().map(|&i| l.degrees[i as usize].recip()).sum();
            all.min((all as f64 * of_part / trace).ceil() as usize + SPARE)
        };
        while let Some(first) = unseen.take_first() {
            parts.push(self.solve(&l, first, share, &mut unseen, notes)?);
        }
        let last = last_of_all(&parts, all);
        for part in parts.iter_mut().filter(|part| part.may_lack(all, last)) {
            unseen.put_back(&l, &part.members);
            if let Some(first) = unseen.take_first() {
                *part = self.solve(&l, first, |_| all, &mut unseen, notes)?;
            }
        }
        self.assemble(&parts, affinity.degrees.len(), out)
    }
}

impl Slicing {
    /// The eigenvalues of all parts in one row, and U.
    fn assemble(&self, parts: &[Part], n: usize, out: &mut Spectrum) -> Result<(), StageError> {
        let mut all: Vec<(f64, &[u32], &[f64])> = Vec::new();
        for Part { members, lowest } in parts {
            let vector = |j| if j < lowest.vectors.ncols() { lowest.vectors.col_as_slice(j) } else { &[] };
            let pairs = lowest.eigenvalues.iter().enumerate();
            all.extend(pairs.map(|(j, &eigenvalue)| (eigenvalue, &members[..], vector(j))));
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.eigenvalues.clear();
        out.eigenvalues.extend(all.iter().map(|(eigenvalue, ..)| eigenvalue));
        count_zeros(out, n, self.tolerance);
        // Every part gave these; a larger one may be missing in some part.
        out.eigenvalues.truncate(self.eigenvalues.max(out.k + 1));
        make_zero(&mut out.u, n, out.k)?;
        for (j, (_, members, vector)) in all[..out.k].iter().enumerate() {
            let column = out.u.col_as_slice_mut(j);
            members.iter().zip(*vector).for_each(|(&i, x)| column[i as usize] = *x);
            let sign = sign_of_largest(column);
            column.iter_mut().for_each(|x| *x *= sign);
        }
        Ok(())
    }
}

/// The last of the `wanted` lowest eigenvalues of what is known of the parts.
fn last_of_all(parts: &[Part], wanted: usize) -> f64 {
    let mut all: Vec<f64> = parts.iter().flat_map(|part| &part.lowest.eigenvalues).copied().collect();
    all.sort_by(f64::total_cmp);
    all.get(wanted - 1).copied().unwrap_or(f64::INFINITY)
}
