//! `blocks`: the eigenvalues near zero, block by block, for sparse graphs.

use crosscut_stage::{
    Affinity, Embedding, Interval, Kind, Notes, ParamError, ParamSpec, Shape, SpectralStage, Spectrum, StageError,
    Value,
};
use faer::Mat;

use crate::FaerEvd;
use crate::band::Band;
use crate::degrees::check_degrees;
use crate::laplacian::dense_bytes;
use crate::split::Split;
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

const WEAK_LINK: ParamSpec = ParamSpec {
    name: "weak_link",
    unit: "",
    shape: Shape::Number { default: 1e-3, range: Interval::closed(0.0, 1.0) },
    doc: "edges of W_ij / √(D_ii D_jj) below it are set aside and their effect is computed, if that leaves zeros; 0: none",
};

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "blocks",
    doc: "the zero eigenvalues and the next, block by block by a banded factorisation, for sparse graphs",
    params: &[ZERO_TOLERANCE, WEAK_LINK],
    build: |params| Box::new(Blocks::with(ZeroRule::of(params), params.number(WEAK_LINK.name))),
};

/// Weak links aside, L is block diagonal: L_0. A block B of L_0 has the eigenvalue 0, with the eigenvector
/// D^1/2 1_B / ‖D^1/2 1_B‖, and no other below τ if L_B - τI has one negative pivot (Sylvester). Its next eigenvalue is
/// found by inverse iteration, and believed if one eigenvalue lies below it and two lie at or below it, by the pivots
/// again.
///
/// Weak links lift the zeros of the m blocks to the eigenvalues θ of the graph of blocks (m×m), which are the ones
/// reported. All are below τ, and λ_m <= θ_m < τ <= μ <= λ_m+1, where μ is the least of the blocks' next eigenvalues: k = m is
/// proved, not estimated. [`Spectrum::zeros_bound`] and [`Spectrum::span_bound`] say how far θ and U may be off. The columns of
/// U are those of the blocks, an orthonormal basis of what the eigenvectors of the zeros span.
///
/// A block with an eigenvalue below τ beside its zero (one wall that is almost two, but not along weak links) goes through
/// the full decomposition, with a note; if links were set aside, with those.
pub struct Blocks {
    rule: ZeroRule,
    weak_link: f64,
    split: Split,
    band: Band,
    full: FaerEvd,
}

/// What a block adds: its next eigenvalue, and, if it has zeros beside the known one, all of them and their eigenvectors.
struct Block {
    next: Option<f64>,
    zeros: Option<(Vec<f64>, Mat<f64>)>,
}

impl Block {
    fn columns(&self) -> usize {
        self.zeros.as_ref().map_or(1, |(zeros, _)| zeros.len())
    }
}

impl Blocks {
    /// Takes as zero what `rule` says. Links of W_ij / √(D_ii D_jj) below `weak_link`, in [0, 1], may be set aside.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn new(rule: ZeroRule, weak_link: f64) -> Result<Self, ParamError> {
        WEAK_LINK.check(Value::Number(weak_link))?;
        rule.checked().map(|rule| Self::with(rule, weak_link))
    }

    fn with(rule: ZeroRule, weak_link: f64) -> Self {
        Self { rule, weak_link, split: Split::default(), band: Band::default(), full: FaerEvd::with(rule) }
    }

    /// The returns of each block, and its next eigenvalue; `None` for one that has more than one zero.
    fn solve(&mut self, affinity: &Affinity, weak_link: f64) -> Result<Solved, StageError> {
        let ZeroRule::Tolerance(tolerance) = self.rule;
        self.split.form(affinity, weak_link, tolerance)?;
        let mut members = vec![Vec::new(); self.split.len()];
        let blocks = self.split.block_of_return().iter().enumerate();
        blocks.for_each(|(i, &block)| members[block as usize].push(i as u32));
        let next = |members: &Vec<u32>| {
            if members.len() == 1 {
                return Some(None);
            }
            self.band.form(affinity, members, self.split.leaks());
            self.band.second_eigenvalue().filter(|&next| next >= tolerance).map(Some)
        };
        let next = members.iter().map(next).collect();
        Ok(Solved { members, next })
    }

    /// A component that has more zeros than one.
    fn decompose(&mut self, affinity: &Affinity, members: &[u32], notes: &mut Notes) -> Result<Block, StageError> {
        notes.add(format!("blocks: a component of {} returns by full decomposition", members.len()));
        let mut spectrum = Spectrum::default();
        self.full.spectrum(&part_of(affinity, members), &mut spectrum, notes)?;
        let next = spectrum.eigenvalues.get(spectrum.k).copied();
        spectrum.eigenvalues.truncate(spectrum.k);
        Ok(Block { next, zeros: Some((spectrum.eigenvalues, spectrum.u.to_dense())) })
    }

    /// How far the zeros and their span may be off because of the links that were set aside.
    fn bounds(&self, affinity: &Affinity, zeros: &[f64], next: Option<f64>) -> (f64, f64) {
        // Without a next eigenvalue the columns of Z span everything, and nothing is neglected.
        let (true, Some(next), Some(largest)) = (self.split.has_links(), next, zeros.last()) else { return (0.0, 0.0) };
        let (coupling, gap) = (self.split.coupling(&affinity.degrees), next - largest);
        // No eigenvalue is negative.
        ((coupling * coupling / gap).min(*largest), (coupling / gap).min(1.0))
    }

    /// Writes U: the columns of one block after those of the other.
    fn embed(&self, affinity: &Affinity, members: &[Vec<u32>], blocks: &[Block], u: &mut Embedding) {
        let n = affinity.degrees.len();
        let mut place = vec![0; n];
        for members in members {
            members.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at);
        }
        let mut first = Vec::with_capacity(blocks.len());
        let columns = blocks.iter().fold(0, |columns, block| {
            first.push(columns as u32);
            columns + block.columns()
        });
        u.write_rows(n, columns, |i, row| {
            let at = self.split.block_of_return()[i] as usize;
            match &blocks[at].zeros {
                Some((_, vectors)) => row.extend((first[at]..).zip(vectors.row(place[i]).iter().copied())),
                None => row.push((first[at], (affinity.degrees[i] / self.split.volumes()[at]).sqrt())),
            }
        });
    }
}

/// The returns of each block, and its next eigenvalue if it has one zero (none if it has one return).
struct Solved {
    members: Vec<Vec<u32>>,
    next: Vec<Option<Option<f64>>>,
}

/// The graph of some returns alone.
fn part_of(affinity: &Affinity, members: &[u32]) -> Affinity {
    let mut place = vec![usize::MAX; affinity.degrees.len()];
    members.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at);
    let mut part =
        Affinity { degrees: members.iter().map(|&i| affinity.degrees[i as usize]).collect(), ..Affinity::default() };
    let w = part.weights.make_dense(members.len());
    w.fill(0.0);
    affinity.weights.for_each(|i, j, weight| {
        if place[i] != usize::MAX && place[j] != usize::MAX {
            w[(place[i], place[j])] = weight;
        }
    });
    part
}

impl SpectralStage for Blocks {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, notes: &mut Notes) -> Result<(), StageError> {
        check_degrees(affinity)?;
        let mut solved = self.solve(affinity, self.weak_link)?;
        if self.split.has_links() && solved.next.contains(&None) {
            notes.add("blocks: no link set aside, as a wall between weak links is itself almost two");
            solved = self.solve(affinity, 0.0)?;
        }
        let Solved { members, next } = solved;
        let blocks = members.iter().zip(next).map(|(members, next)| match next {
            Some(next) => Ok(Block { next, zeros: None }),
            None => self.decompose(affinity, members, notes),
        });
        let blocks = blocks.collect::<Result<Vec<_>, _>>()?;
        self.embed(affinity, &members, &blocks, &mut out.u);

        let ZeroRule::Tolerance(tolerance) = self.rule;
        let next = blocks.iter().filter_map(|block| block.next).min_by(f64::total_cmp);
        let beyond_known = blocks.iter().filter_map(|block| block.zeros.as_ref()).flat_map(|(zeros, _)| zeros);
        out.k = out.u.ncols();
        out.eigenvalues.clear();
        out.eigenvalues.extend(beyond_known.chain(self.split.eigenvalues()));
        out.eigenvalues.resize(out.k, 0.0);
        out.eigenvalues.sort_by(f64::total_cmp);
        (out.zeros_bound, out.span_bound) = self.bounds(affinity, &out.eigenvalues, next);
        out.eigenvalues.extend(next);
        out.tolerance = tolerance;
        out.margin_decades =
            Spectrum::tolerance_margin_decades(&out.eigenvalues, affinity.degrees.len(), out.k, tolerance);
        Ok(())
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        // At worst one component that needs the full decomposition, and its part of W made dense.
        self.full.memory_bytes(n).saturating_add(dense_bytes(n))
    }
}
