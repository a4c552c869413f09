//! `slicing`: the lowest eigenvalues of a dense W, connected part by connected part.

use crosscut_stage::{
    Affinity, Kind, Notes, ParamError, ParamSpec, Shape, SpectralStage, Spectrum, StageError, Value, Weights,
};
use faer::Mat;

use crate::decomposition::Decomposition;
use crate::degrees::check_degrees;
use crate::embedding::sign_of_largest;
use crate::krylov::{Krylov, Lowest};
use crate::laplacian::dense_bytes;
use crate::ldlt::Ldlt;
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

/// Smaller weights connect nothing: all of them together move the eigenvalues of n returns by n·1e-14 at most.
const NOTHING: f64 = 1e-14;
/// Parts of fewer returns for each eigenvalue are decomposed in full, which is faster then.
const RETURNS_PER_EIGENVALUE: usize = 8;

const EIGENVALUES: ParamSpec = ParamSpec {
    name: "eigenvalues",
    unit: "",
    shape: Shape::Integer { default: 1, min: 1, max: 1000 },
    doc: "so many of the smallest are computed at least, and always the zeros and the next",
};

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "slicing",
    doc: "the lowest eigenvalues of a dense Laplacian, by the inertia of L - τI and shift-and-invert: the paper's, faster",
    params: &[ZERO_TOLERANCE, EIGENVALUES],
    build: |params| Box::new(Slicing::with(ZeroRule::of(params), params.count(EIGENVALUES.name))),
};

/// Weights below 1e-14 set aside, L is block diagonal. Of each block:
///
/// 1. L_B - τI = M Δ Mᵀ; as many eigenvalues are below τ as Δ has negative entries (Sylvester's law of inertia). So k is known
///    before any eigenvector.
/// 2. Block Krylov spaces of (L_B - τI)⁻¹ from random columns give the lowest eigenvalues and their eigenvectors, until all
///    residuals are small. They must agree with the count; a block in which they do not, or a pivot is 0, is decomposed in
///    full, with a note.
///
/// The zeros are found to 1e-10 and better, and their span to 100·n·ε / (λ_k+1 - λ_k). k is that of a full decomposition unless an
/// eigenvalue is within 100·n·ε of τ.
pub struct Slicing {
    rule: ZeroRule,
    eigenvalues: usize,
    laplacian: Mat<f64>,
    /// The diagonal of D^-1/2.
    scale: Vec<f64>,
    ldlt: Ldlt,
    krylov: Krylov,
    full: Decomposition,
}

/// The lowest eigenpairs of the returns in `members`.
struct Part {
    members: Vec<u32>,
    lowest: Lowest,
}

impl Slicing {
    /// Takes as zero what `rule` says, and computes at least so many eigenvalues, 1 to 1000.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn new(rule: ZeroRule, eigenvalues: u32) -> Result<Self, ParamError> {
        EIGENVALUES.check(Value::Integer(eigenvalues.into()))?;
        rule.checked().map(|rule| Self::with(rule, eigenvalues as usize))
    }

    fn with(rule: ZeroRule, eigenvalues: usize) -> Self {
        Self {
            rule,
            eigenvalues,
            laplacian: Mat::new(),
            scale: Vec::new(),
            ldlt: Ldlt::default(),
            krylov: Krylov::default(),
            full: Decomposition::default(),
        }
    }

    /// The zeros of one part and the next eigenvalue, or as many as are asked for.
    fn solve(
        &mut self,
        w: &Mat<f64>,
        degrees: &[f64],
        members: &[u32],
        notes: &mut Notes,
    ) -> Result<Lowest, StageError> {
        let ZeroRule::Tolerance(tolerance) = self.rule;
        self.form(w, degrees, members);
        let n = members.len();
        let factorised = self.ldlt.factorise(self.laplacian.as_ref(), tolerance);
        let wanted = self.eigenvalues.max(self.ldlt.below() + 1).min(n);
        if n >= RETURNS_PER_EIGENVALUE * wanted {
            let volume: f64 = members.iter().map(|&i| degrees[i as usize]).sum();
            let zero: Vec<f64> = members.iter().map(|&i| (degrees[i as usize] / volume).sqrt()).collect();
            if factorised
                && let Some(lowest) = self.krylov.lowest(self.laplacian.as_ref(), &self.ldlt, wanted, &zero)?
            {
                return Ok(lowest);
            }
            notes.add(format!("slicing: {n} connected returns by full decomposition"));
        }
        let mut eigenvalues = Vec::new();
        self.full.decompose(self.laplacian.as_ref(), &mut eigenvalues)?;
        let below = eigenvalues.partition_point(|&eigenvalue| eigenvalue < tolerance);
        eigenvalues.truncate(self.eigenvalues.max(below + 1));
        let vectors = Mat::from_fn(n, eigenvalues.len(), |i, j| self.full.eigenvector(j)[i]);
        Ok(Lowest { eigenvalues, vectors })
    }

    /// Equation (2) for the returns of one part.
    fn form(&mut self, w: &Mat<f64>, degrees: &[f64], members: &[u32]) {
        self.scale.clear();
        self.scale.extend(members.iter().map(|&i| degrees[i as usize].sqrt().recip()));
        self.laplacian.resize_with(members.len(), members.len(), |_, _| 0.0);
        let is_all = members.len() == w.nrows();
        for (j, &from) in members.iter().enumerate() {
            let weights = w.col_as_slice(from as usize);
            let column = self.laplacian.col_as_slice_mut(j);
            if is_all {
                column.copy_from_slice(weights);
            } else {
                column.iter_mut().zip(members).for_each(|(l, &i)| *l = weights[i as usize]);
            }
            let scale_j = self.scale[j];
            column.iter_mut().zip(&self.scale).for_each(|(l, scale_i)| *l *= -(scale_i * scale_j));
            column[j] += 1.0;
        }
    }
}

impl SpectralStage for Slicing {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, notes: &mut Notes) -> Result<(), StageError> {
        check_degrees(affinity)?;
        let copy;
        let w = match &affinity.weights {
            Weights::Dense(w) => w,
            sparse => {
                copy = dense(sparse);
                &copy
            }
        };
        let finite = |&j: &usize| w.col_as_slice(j).iter().fold(true, |finite, weight| finite & weight.is_finite());
        if let Some(index) = (0..w.ncols()).find(|j| !finite(j)) {
            return Err(StageError::NotFinite { what: "the affinity", index });
        }
        let parts = connected(w).into_iter().map(|members| {
            let lowest = self.solve(w, &affinity.degrees, &members, notes)?;
            Ok(Part { members, lowest })
        });
        let parts = parts.collect::<Result<Vec<_>, StageError>>()?;
        self.assemble(&parts, affinity.degrees.len(), out)
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        // A copy of W if it is sparse, L, its factor, and at worst what a full decomposition takes.
        dense_bytes(n).saturating_mul(3).saturating_add(Decomposition::memory_bytes(n))
    }
}

impl Slicing {
    /// The eigenvalues of all parts in one row, and U.
    fn assemble(&self, parts: &[Part], n: usize, out: &mut Spectrum) -> Result<(), StageError> {
        let mut all: Vec<(f64, &Part, usize)> = Vec::new();
        for part in parts {
            all.extend(part.lowest.eigenvalues.iter().enumerate().map(|(j, &eigenvalue)| (eigenvalue, part, j)));
        }
        if all.iter().any(|(eigenvalue, ..)| !eigenvalue.is_finite()) {
            return Err(StageError::NoConvergence { n });
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        out.eigenvalues.clear();
        out.eigenvalues.extend(all.iter().map(|(eigenvalue, ..)| eigenvalue));
        self.rule.count(out, n);
        // Of each part those are known: what comes after may be missing in one of them.
        out.eigenvalues.truncate(self.eigenvalues.max(out.k + 1));
        let u = out.u.make_dense(n, out.k);
        u.fill(0.0);
        for (j, (_, part, column)) in all[..out.k].iter().enumerate() {
            let vector = part.lowest.vectors.col_as_slice(*column);
            let sign = sign_of_largest(vector);
            for (&i, x) in part.members.iter().zip(vector) {
                u[(i as usize, j)] = sign * x;
            }
        }
        Ok(())
    }
}

/// The returns that are connected by weights of [`NOTHING`] and more, each part ascending, by their first return.
fn connected(w: &Mat<f64>) -> Vec<Vec<u32>> {
    let mut unseen: Vec<u32> = (0..w.nrows() as u32).collect();
    let mut parts = Vec::new();
    while !unseen.is_empty() {
        let mut part = vec![unseen.remove(0)];
        let mut next = 0;
        while let Some(&from) = part.get(next) {
            next += 1;
            let weights = w.col_as_slice(from as usize);
            unseen.retain(|&i| {
                let is_tied = weights[i as usize] >= NOTHING;
                if is_tied {
                    part.push(i);
                }
                !is_tied
            });
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts
}

fn dense(weights: &Weights) -> Mat<f64> {
    let mut w = Mat::zeros(weights.n(), weights.n());
    weights.for_each(|i, j, weight| w[(i, j)] = weight);
    w
}
