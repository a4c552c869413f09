//! `blocks`: the eigenvalues near zero, block by block, for sparse graphs.

mod band;
mod fiedler;
mod graph;
mod order;
mod split;

use crosscut_stage::NoteCode::{N071, N072};
use crosscut_stage::{Affinity, Kind, Notes, SpectralStage, Spectrum, StageError};
use faer::Mat;

use crate::degrees::check_degrees;
use crate::embedding::make_zero;
use crate::faer_evd::FaerEvd;
use crate::zeros::ZERO_TOLERANCE;
use band::Band;
use fiedler::Fiedler;
use graph::Graph;
use order::Order;
use split::{MOST_DECOMPOSED, Split};

/// Edges of W_ij / √(D_ii D_jj) below this are set aside and their effect is computed, if that leaves zeros.
const WEAK_LINK: f64 = 1e-3;

/// Blocks with longer edges, in the best order of their returns that was found, are decomposed in full.
const WIDEST_BAND: usize = 64;

/// The solver of sparse graphs.
pub const KIND: Kind<dyn SpectralStage> = Kind::spectral(
    "blocks",
    "the zero eigenvalues and the next, block by block by a banded factorisation, for sparse graphs",
    |params| {
        let tolerance = params.get(ZERO_TOLERANCE);
        Box::new(Blocks {
            tolerance,
            graph: Graph::default(),
            solver: Solver::default(),
            full: FaerEvd::new(tolerance),
        })
    },
)
.params(&[ZERO_TOLERANCE.spec])
.stays_sparse();

/// Without its weak edges, L is block diagonal: L_0. A block B of L_0 has the eigenvalue 0, with the eigenvector D^1/2 1_B /
/// ‖D^1/2 1_B‖, and no other below τ if L_B - τI has one negative pivot (Sylvester). Its next eigenvalue is found by
/// inverse iteration: at most a Rayleigh quotient, and at least the last shift that has one eigenvalue below it, by the
/// pivots again, which must not be below τ. Only the least of all blocks is reported, so a block is done when its pivots
/// show that its own is no less than the least so far.
///
/// Weak edges lift the zeros of the m blocks to the eigenvalues θ of the graph of blocks (m×m), which are the ones
/// reported. All are below τ, and λ_m <= θ_m < τ <= μ <= λ_m+1, where μ is the least of the blocks' next eigenvalues: k
/// = m is proved, not estimated. With Z the columns of U and r = ‖LZ - Z(ZᵀLZ)‖, θ is too high by r² / (μ - θ_m) at most,
/// and the span is off by the sine r / (μ - θ_m) at most (Davis, Kahan). The columns of U are those of the blocks, an orthonormal basis of what the eigenvectors of the zeros span.
///
/// A block with an eigenvalue below τ beside its zero (one wall that is almost two, but not along weak edges) is decomposed
/// in full, with a note, together with its weak edges; and so is a block whose edges are long in every order of its
/// returns, as no wall's are.
struct Blocks {
    tolerance: f64,
    graph: Graph,
    solver: Solver,
    full: FaerEvd,
}

/// A block that may have more zeros than one, decomposed in full.
struct Decomposed {
    block: usize,
    /// Its returns, ascending.
    members: Vec<u32>,
    /// All its zeros, their eigenvectors, and the next eigenvalue.
    spectrum: Spectrum,
}

impl Decomposed {
    fn new(
        full: &mut FaerEvd,
        affinity: &Affinity,
        members: Vec<u32>,
        block: usize,
        notes: &mut Notes,
    ) -> Result<Self, StageError> {
        if members.len() > MOST_DECOMPOSED {
            return Err(StageError::TooLarge(format!(
                "a component of {} returns is no wall, and of more than {MOST_DECOMPOSED} it is not decomposed in full: choose \
                 spectral.kind = \"components\", or a sparser affinity",
                members.len(),
            )));
        }
        notes.add(N071, format!("blocks: a component of {} returns by full decomposition", members.len()));
        let mut spectrum = Spectrum::default();
        full.spectrum(&part_of(affinity, &members), &mut spectrum, notes)?;
        Ok(Self { block, members, spectrum })
    }
}

/// The blocks of a graph, and the next eigenvalue of each; holds its buffers.
#[derive(Default)]
struct Solver {
    split: Split,
    order: Order,
    band: Band,
    fiedler: Fiedler,
    zero: Vec<f64>,
    /// The least of the next eigenvalues of the blocks that have one zero.
    next: Option<f64>,
    /// Blocks to be decomposed in full, ascending.
    several: Vec<usize>,
}

impl Solver {
    fn solve(&mut self, graph: &Graph, weak_link: f64, tolerance: f64) -> Result<(), StageError> {
        self.split.form(graph, weak_link, tolerance)?;
        self.order.form(&self.split);
        self.next = None;
        self.several.clear();
        // A large block has a small one as a rule: of the others it is then enough to know that theirs is no less.
        let largest = (0..self.split.volumes.len()).max_by_key(|&block| self.order.members(block).len());
        let others = (0..self.split.volumes.len()).filter(|&block| Some(block) != largest);
        for block in largest.into_iter().chain(others) {
            if self.order.members(block).len() == 1 {
                continue;
            }
            self.order.shorten(graph, block);
            if self.order.longest[block] > WIDEST_BAND {
                self.several.push(block);
                continue;
            }
            let Self { split, order, band, fiedler, zero, .. } = self;
            band.form(graph, &split.leaks, order, block);
            if self.next.is_some_and(|next| band.count_below(next) <= 1) {
                continue;
            }
            let volume = split.volumes[block];
            zero.clear();
            zero.extend(order.members(block).iter().map(|&i| (graph.degrees[i as usize] / volume).sqrt()));
            match fiedler.find(band, zero) {
                Some(next) if next.lower >= tolerance => {
                    self.next = Some(self.next.map_or(next.upper, |least| least.min(next.upper)));
                }
                _ => self.several.push(block),
            }
        }
        self.several.sort_unstable();
        Ok(())
    }

    /// The returns of a block, ascending.
    fn members(&self, block: usize) -> Vec<u32> {
        let mut members = self.order.members(block).to_vec();
        members.sort_unstable();
        members
    }

    /// Writes U of returns of these degrees: one column for each block, in their order, or those of `decomposed`,
    /// ascending.
    fn embed(&self, degrees: &[f64], decomposed: &[Decomposed], u: &mut Mat<f64>) -> Result<(), StageError> {
        let mut first: Vec<usize> = (0..self.split.volumes.len()).collect();
        for Decomposed { block, spectrum, .. } in decomposed {
            first[block + 1..].iter_mut().for_each(|first| *first += spectrum.k - 1);
        }
        let columns = self.split.volumes.len() + decomposed.iter().map(|block| block.spectrum.k - 1).sum::<usize>();
        make_zero(u, degrees.len(), columns)?;
        for (i, (degree, &block)) in degrees.iter().zip(&self.split.block_of_return).enumerate() {
            u[(i, first[block as usize])] = (degree / self.split.volumes[block as usize]).sqrt();
        }
        for Decomposed { block, members, spectrum } in decomposed {
            for (rank, &i) in members.iter().enumerate() {
                (0..spectrum.k).for_each(|j| u[(i as usize, first[*block] + j)] = spectrum.u[(rank, j)]);
            }
        }
        Ok(())
    }
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
        let degrees = &affinity.degrees;
        let Self { tolerance, ref mut graph, ref mut solver, ref mut full } = *self;
        graph.fill(affinity)?;
        solver.solve(graph, WEAK_LINK, tolerance)?;
        if !solver.split.between.is_empty() && !solver.several.is_empty() {
            notes.add(
                N072,
                "blocks: no edge set aside, as a wall between weak edges is itself almost two, or its edges are long",
            );
            solver.solve(graph, 0.0, tolerance)?;
        }
        let several = solver.several.iter();
        let decompose = |&block| Decomposed::new(full, affinity, solver.members(block), block, notes);
        let decomposed: Vec<Decomposed> = several.map(decompose).collect::<Result<_, _>>()?;
        solver.embed(degrees, &decomposed, &mut out.u)?;

        out.k = out.u.ncols();
        out.tolerance = tolerance;
        out.eigenvalues.clear();
        let spectra = || decomposed.iter().map(|block| &block.spectrum);
        out.eigenvalues.extend(spectra().flat_map(|spectrum| &spectrum.eigenvalues[..spectrum.k]));
        out.eigenvalues.extend(&solver.split.eigenvalues);
        out.eigenvalues.resize(out.k, 0.0);
        out.eigenvalues.sort_unstable_by(f64::total_cmp);
        let others = spectra().filter_map(|spectrum| spectrum.eigenvalues.get(spectrum.k).copied());
        let next = others.chain(solver.next).min_by(f64::total_cmp);
        out.eigenvalues.extend(next);
        out.margin_decades = Spectrum::tolerance_margin_decades(&out.eigenvalues, degrees.len(), out.k, tolerance);
        Ok(())
    }
}
