//! The dense Laplacian of a connected part at a shift, factorised within its envelope.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::{LdltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_inverse::invert_unit_lower_triangular;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};

use super::connected::Unseen;
use super::normalised::Normalised;
use crate::decomposition::make_room;

/// Columns that are processed together.
const PANEL: usize = 16;

/// D^1/2 (L - shift·I) D^1/2 = (1 - shift) D - W of one part, n×n, as M Δ Mᵀ without exchange of rows. For indefinite
/// matrices this can be inaccurate, so its results have to be checked.
///
/// The matrix is taken by panels of columns: from the first row of a panel to its end, below which there is nothing.
pub(crate) struct Envelope {
    /// The returns of the part, in the order of the rows.
    pub(crate) members: Vec<u32>,
    /// The diagonal of D^1/2, which L maps to 0.
    pub(crate) roots: Vec<f64>,
    panels: Vec<ColumnPanel>,
    /// M below its blocks on the diagonal.
    factor: Mat<f64>,
    /// The inverses of M's blocks on the diagonal, side by side.
    inverses: Mat<f64>,
    /// Δ.
    pivots: Vec<f64>,
    /// The panel at work, from its first row on: it is the last to go through memory, and only once.
    work: Mat<f64>,
    /// A few rows or columns times Δ.
    scaled: Mat<f64>,
    scratch: MemBuffer,
    /// The shift of the last factorisation.
    pub(crate) shift: f64,
    /// The number of eigenvalues below the shift, by Sylvester's law.
    pub(crate) below: usize,
}

/// Columns `start..next`, and the row `end` from which on they have no entries. It never falls from a panel to the
/// next.
#[derive(Clone, Copy, Debug)]
struct ColumnPanel {
    start: usize,
    next: usize,
    end: usize,
}

impl ColumnPanel {
    fn columns(self) -> usize {
        self.next - self.start
    }

    /// Rows below the diagonal block.
    fn below(self) -> usize {
        self.end - self.next
    }

    fn lower(self, factor: &Mat<f64>) -> MatRef<'_, f64> {
        factor.submatrix(self.next, self.start, self.below(), self.columns())
    }

    fn inverse(self, inverses: &Mat<f64>) -> MatRef<'_, f64> {
        inverses.submatrix(0, self.start, self.columns(), self.columns())
    }
}

impl Default for Envelope {
    fn default() -> Self {
        Self {
            members: Vec::new(),
            roots: Vec::new(),
            panels: Vec::new(),
            factor: Mat::new(),
            inverses: Mat::new(),
            pivots: Vec::new(),
            work: Mat::new(),
            scaled: Mat::new(),
            scratch: MemBuffer::new(StackReq::empty()),
            shift: 0.0,
            below: 0,
        }
    }
}

impl Envelope {
    /// Takes the returns that are connected with `first` out of `unseen`, and factorises L - `shift`·I of them. `false`
    /// if a pivot is 0 or no number, as after a weight that is not finite; the members are found all the same.
    ///
    /// Panel by panel, each as soon as its returns are known: W is read once, and the factor written once.
    pub(crate) fn factorise(&mut self, l: &Normalised<'_>, first: u32, unseen: &mut Unseen, shift: f64) -> bool {
        self.begin(first, unseen.count + 1, shift);
        let mut sound = true;
        let mut start = 0;
        while start < self.members.len() {
            let mut next = start;
            while next < self.members.len().min(start + PANEL) {
                unseen.take_neighbours(l, self.members[next], &mut self.members);
                self.fill(l, start, next);
                next += 1;
            }
            sound = sound && self.eliminate(ColumnPanel { start, next, end: self.members.len() });
            start = next;
        }
        self.below = self.pivots.iter().filter(|&&pivot| pivot < 0.0).count();
        sound && self.pivots.iter().all(|pivot| pivot.is_finite())
    }

    fn begin(&mut self, first: u32, most: usize, shift: f64) {
        self.members.clear();
        self.members.push(first);
        self.roots.clear();
        self.panels.clear();
        self.pivots.clear();
        self.shift = shift;
        reserve(&mut self.factor, most, most);
        reserve(&mut self.inverses, PANEL, most);
        reserve(&mut self.work, most, PANEL);
        reserve(&mut self.scaled, PANEL, most.max(PANEL));
        make_room(&mut self.scratch, cholesky_in_place_scratch::<f64>(PANEL, Par::Seq, Spec::default()));
    }

    /// Writes column `j` of the panel from `start` on, as far as members are known.
    fn fill(&mut self, l: &Normalised<'_>, start: usize, j: usize) {
        let return_j = self.members[j] as usize;
        let (weights, degree) = (l.w.col_as_slice(return_j), l.degrees[return_j]);
        let (column, rest) = self.work.col_as_slice_mut(j - start).split_at_mut(self.members.len() - start);
        for (entry, &i) in column.iter_mut().zip(&self.members[start..]) {
            *entry = -weights[i as usize];
        }
        column[j - start] += (1.0 - self.shift) * degree;
        rest.fill(0.0);
        self.roots.push(degree.sqrt());
    }

    /// The next panel of the factor. `false` if a pivot is 0.
    fn eliminate(&mut self, panel: ColumnPanel) -> bool {
        self.subtract_before(panel);
        let Self { panels, factor, inverses, pivots, work, scaled, scratch, .. } = self;
        let columns = panel.columns();
        let (mut diagonal, lower) = work.get_mut(..panel.end - panel.start, ..columns).split_at_row_mut(columns);
        let (signs, scratch) = (LdltRegularization::default(), MemStack::new(scratch));
        if cholesky_in_place(diagonal.rb_mut(), signs, Par::Seq, scratch, Spec::default()).is_err() {
            return false;
        }
        let mut inverse = inverses.submatrix_mut(0, panel.start, columns, columns);
        inverse.fill(0.0);
        invert_unit_lower_triangular(inverse.rb_mut(), diagonal.rb(), Par::Seq);
        inverse.rb_mut().diagonal_mut().fill(1.0);
        // M of this panel = (what is there) (Δ⁻¹ inverse)ᵀ.
        pivots.extend((0..columns).map(|j| diagonal[(j, j)]));
        for j in 0..columns {
            let quotients = inverses.col_as_slice(panel.start + j).iter().zip(&pivots[panel.start..]);
            scaled.col_as_slice_mut(j).iter_mut().zip(quotients).for_each(|(scaled, (x, pivot))| *scaled = x / pivot);
        }
        let out = factor.submatrix_mut(panel.next, panel.start, panel.below(), columns);
        set(out, lower.rb(), scaled.submatrix(0, 0, columns, columns).transpose());
        panels.push(panel);
        true
    }

    /// Subtracts M Δ Mᵀ of the panels before it from the panel at work; panels that end alike together.
    fn subtract_before(&mut self, panel: ColumnPanel) {
        let Self { panels, factor, pivots, work, scaled, .. } = self;
        let first = panels.partition_point(|before| before.end <= panel.start);
        for alike in panels[first..].chunk_by(|a, b| a.end == b.end) {
            let (start, next, end) = (alike[0].start, alike[alike.len() - 1].next, alike[0].end);
            let rows = factor.get(panel.start..end, start..next);
            let columns = end.min(panel.next) - panel.start;
            for (j, pivot) in pivots[start..next].iter().enumerate() {
                let column = &factor.col_as_slice(start + j)[panel.start..][..columns];
                scaled.col_as_slice_mut(j).iter_mut().zip(column).for_each(|(scaled, x)| *scaled = x * pivot);
            }
            let scaled = scaled.submatrix(0, 0, columns, next - start);
            add(work.submatrix_mut(0, 0, rows.nrows(), columns), -1.0, rows, scaled.transpose());
        }
    }

    /// The number of eigenvalues that count as zero if the shift is τ: those below it, and always the first, which
    /// rounding may have lifted above a small τ.
    pub(crate) fn zeros(&self) -> usize {
        self.below.max(1)
    }

    /// Solves (L - shift·I) X = `x` in place.
    pub(crate) fn solve(&mut self, x: &mut Mat<f64>) {
        for_columns(x, &self.roots, |x, root| x * root);
        let Self { panels, factor, inverses, work, .. } = self;
        reserve(work, PANEL, x.ncols());
        for panel in panels.iter() {
            let (top, bottom) = x.as_mut().split_at_row_mut(panel.next);
            let mut of_panel = top.get_mut(panel.start.., ..);
            let mut solved = work.submatrix_mut(0, 0, panel.columns(), of_panel.ncols());
            set(solved.rb_mut(), panel.inverse(inverses), of_panel.rb());
            add(bottom.get_mut(..panel.below(), ..), -1.0, panel.lower(factor), solved.rb());
            of_panel.copy_from(solved);
        }
        for_columns(x, &self.pivots, |x, pivot| x / pivot);
        for panel in panels.iter().rev() {
            let (top, bottom) = x.as_mut().split_at_row_mut(panel.next);
            let mut of_panel = top.get_mut(panel.start.., ..);
            let mut solved = work.submatrix_mut(0, 0, panel.columns(), of_panel.ncols());
            let below = bottom.rb().get(..panel.below(), ..);
            add(of_panel.rb_mut(), -1.0, panel.lower(factor).transpose(), below);
            set(solved.rb_mut(), panel.inverse(inverses).transpose(), of_panel.rb());
            of_panel.copy_from(solved);
        }
        for_columns(x, &self.roots, |x, root| x * root);
    }
}

/// Makes room for this many rows and columns.
fn reserve(matrix: &mut Mat<f64>, rows: usize, columns: usize) {
    if matrix.nrows() < rows || matrix.ncols() < columns {
        matrix.resize_with(matrix.nrows().max(rows), matrix.ncols().max(columns), |_, _| 0.0);
    }
}

/// Each column entry by entry with `diagonal`.
fn for_columns(x: &mut Mat<f64>, diagonal: &[f64], of: impl Fn(f64, f64) -> f64) {
    for j in 0..x.ncols() {
        x.col_as_slice_mut(j).iter_mut().zip(diagonal).for_each(|(x, &entry)| *x = of(*x, entry));
    }
}

/// out = a b.
fn set(out: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
}

/// out += factor·a b.
fn add(out: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(out, Accum::Add, a, b, factor, Par::Seq);
}
