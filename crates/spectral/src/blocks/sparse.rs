//! One block's Laplacian as a sparse matrix, and its factorisation: for blocks whose edges are long in every order.

use crosscut_stage::StageError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd::Control;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use super::fiedler::ShiftInvert;
use super::graph::Graph;
use super::order::Order;
use crate::decomposition::make_room;

/// No block and no graph of blocks takes more memory than this.
pub(crate) const MOST_BYTES: u64 = 1 << 30;
/// A shift that meets an eigenvalue of a leading part exactly is moved by this.
const NUDGE: f64 = f64::EPSILON;
/// The largest number of such moves.
const NUDGES: usize = 8;
/// With more entries in a column of the factor, on average, columns are worked on in blocks. A return of a cloud
/// has edges to three others, and its column has little in common with the next.
const FULL: usize = 64;

/// The Laplacian of one block, the edges to others set aside, by the columns of its upper triangle; and its LDLᵀ with
/// rows in an order of little fill (approximate minimum degree).
pub(crate) struct Sparse {
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    /// `values` less the shift on the diagonal, which stands at the end of each column.
    shifted: Vec<f64>,
    symbolic: Option<SymbolicCholesky<usize>>,
    factor: Vec<f64>,
    scratch: MemBuffer,
}

impl Default for Sparse {
    fn default() -> Self {
        Self {
            column_starts: Vec::new(),
            rows: Vec::new(),
            values: Vec::new(),
            shifted: Vec::new(),
            symbolic: None,
            factor: Vec::new(),
            scratch: MemBuffer::new(StackReq::empty()),
        }
    }
}

impl Sparse {
    /// Takes one block of `graph`. `leaks` are the weights of each return's edges to other blocks, which are set aside.
    ///
    /// # Errors
    /// When the factor would take more than 1 GB.
    pub(crate) fn form(
        &mut self,
        graph: &Graph<'_>,
        leaks: &[f64],
        order: &Order,
        block: usize,
    ) -> Result<(), StageError> {
        let (scale, rank_of) = (graph.inverse_sqrt_degrees, order.ranks(block));
        self.rows.clear();
        self.values.clear();
        self.column_starts.clear();
        let mut column: Vec<(usize, f64)> = Vec::new();
        for (at, &i) in order.members(block).iter().enumerate() {
            let i = i as usize;
            self.column_starts.push(self.rows.len());
            let (others, weights) = graph.edges.row(i);
            let entry = |(&j, weight): (&u32, &f64)| {
                let rank = rank_of(j as usize).filter(|&rank| rank <= at)?;
                Some((rank, -weight * (scale[i] * scale[j as usize])))
            };
            column.clear();
            column.extend(others.iter().zip(weights).filter_map(entry));
            column.sort_unstable_by_key(|&(rank, _)| rank);
            let leak = leaks[i] * (scale[i] * scale[i]);
            match column.last_mut() {
                Some((rank, value)) if *rank == at => *value += 1.0 - leak,
                _ => column.push((at, 1.0 - leak)),
            }
            self.rows.extend(column.iter().map(|&(rank, _)| rank));
            self.values.extend(column.iter().map(|&(_, value)| value));
        }
        self.column_starts.push(self.rows.len());
        self.plan()
    }

    /// How rows are ordered: if a few are far longer than the others, as of the one return to which all around it have
    /// an edge, they come last, in the order of the block. Minimum degree would search them again and again.
    fn ordering(&self) -> Control {
        let n = self.column_starts.len() - 1;
        let mut lengths = vec![0; n];
        for (column, span) in self.column_starts.windows(2).enumerate() {
            lengths[column] += span[1] - span[0];
            self.rows[span[0]..span[1]].iter().for_each(|&row| lengths[row] += 1);
        }
        let long = n.isqrt();
        let few = lengths.iter().filter(|&&length| length > long).count() < n / 8;
        Control { dense: if few { 1.0 } else { Control::default().dense }, ..Control::default() }
    }

    /// Orders the rows, and makes room for the factor.
    fn plan(&mut self) -> Result<(), StageError> {
        let n = self.column_starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows);
        let plan = |supernodal_flop_ratio_threshold| {
            let params = CholeskySymbolicParams {
                amd_params: self.ordering(),
                supernodal_flop_ratio_threshold,
                ..CholeskySymbolicParams::default()
            };
            factorize_symbolic_cholesky(pattern, Side::Upper, SymmetricOrdering::Amd, params)
                .map_err(|error| StageError::TooLarge(format!("the factor of a block of {n} returns: {error}")))
        };
        let mut symbolic = plan(SupernodalThreshold::FORCE_SIMPLICIAL)?;
        if symbolic.len_val() > FULL * n {
            symbolic = plan(SupernodalThreshold::FORCE_SUPERNODAL)?;
        }
        let bytes = 8 * symbolic.len_val() as u64;
        if bytes > MOST_BYTES {
            return Err(StageError::TooLarge(format!(
                "the factor of a block of {n} returns would need {} MB, more than {} MB: choose a sparser affinity",
                bytes >> 20,
                MOST_BYTES >> 20
            )));
        }
        self.factor.clear();
        self.factor.resize(symbolic.len_val(), 0.0);
        let factorising = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Spec::default());
        let solving = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        make_room(&mut self.scratch, factorising.or(solving));
        self.symbolic = Some(symbolic);
        Ok(())
    }
}

impl ShiftInvert for Sparse {
    fn solve(&mut self, shift: f64, x: &mut Vec<f64>) -> Option<usize> {
        let below = self.count_below(shift)?;
        let symbolic = self.symbolic.as_ref()?;
        let x = MatMut::from_column_major_slice_mut(x, symbolic.nrows(), 1);
        let stack = MemStack::new(&mut self.scratch);
        LdltRef::new(symbolic, &self.factor).solve_in_place_with_conj(Conj::No, x, Par::Seq, stack);
        Some(below)
    }

    fn count_below(&mut self, shift: f64) -> Option<usize> {
        let n = self.column_starts.len() - 1;
        let symbolic = self.symbolic.as_ref()?;
        for nudge in 0..NUDGES {
            let shift = shift + NUDGE * nudge as f64;
            self.shifted.clone_from(&self.values);
            self.column_starts[1..].iter().for_each(|end| self.shifted[end - 1] -= shift);
            let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows);
            let matrix = SparseColMatRef::new(pattern, &self.shifted);
            let done = symbolic.factorize_numeric_ldlt(
                &mut self.factor,
                matrix,
                Side::Upper,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Spec::default(),
            );
            if done.is_ok() {
                return Some(negative_pivots(symbolic, &self.factor));
            }
        }
        None
    }
}

/// The number of negative entries of D in a factor LDLᵀ.
fn negative_pivots(symbolic: &SymbolicCholesky<usize>, factor: &[f64]) -> usize {
    match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(columns) => {
            columns.col_ptr()[..columns.ncols()].iter().filter(|&&start| factor[start] < 0.0).count()
        }
        SymbolicCholeskyRaw::Supernodal(blocks) => {
            let factor = faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef::new(blocks, factor);
            let of_block = |s: usize| {
                let values = factor.supernode(s).val();
                (0..values.ncols()).filter(|&j| values[(j, j)] < 0.0).count()
            };
            (0..blocks.n_supernodes()).map(of_block).sum()
        }
    }
}
