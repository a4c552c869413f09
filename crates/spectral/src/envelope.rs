//! The dense Laplacian of a connected part within its envelope, and its factorisation at a shift.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_inverse::invert_unit_lower_triangular;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, ColRef, Mat, MatMut, MatRef, Par, Spec, unzip, zip};

/// Columns that are worked on together.
const PANEL: usize = 32;
/// Smaller entries of D^-1/2 W D^-1/2 connect nothing, and are left out where that makes the envelope smaller: all of them together
/// move the eigenvalues of n returns by n·1e-15 at most (Gershgorin), a twentieth of what k may depend on.
const NOTHING: f64 = 1e-15;

/// L of one part, n×n, by panels of columns: from the first row of a panel to its end, below which L has nothing.
///
/// L - shift·I = M Δ Mᵀ without exchange of rows. For indefinite matrices this can be inaccurate; what comes of it has to be
/// checked.
pub(crate) struct Envelope {
    members: Vec<u32>,
    panels: Vec<Panel>,
    laplacian: Mat<f64>,
    /// M below its unit diagonal.
    factor: Mat<f64>,
    /// Δ.
    pivots: Vec<f64>,
    /// The inverses of M's blocks on the diagonal, side by side.
    inverses: Mat<f64>,
    /// M Δ of one panel.
    scaled: Mat<f64>,
    /// A few rows of a solution.
    rows: Mat<f64>,
    scratch: MemBuffer,
    shift: f64,
    below: usize,
}

/// Columns `start..next`, and the row `end` from which on they have no entries.
#[derive(Clone, Copy, Debug)]
struct Panel {
    start: usize,
    next: usize,
    end: usize,
}

impl Panel {
    fn columns(self) -> usize {
        self.next - self.start
    }

    /// Rows below the diagonal block.
    fn below(self) -> usize {
        self.end - self.next
    }

    fn lower(self, matrix: &Mat<f64>) -> MatRef<'_, f64> {
        matrix.submatrix(self.next, self.start, self.below(), self.columns())
    }
}

impl Default for Envelope {
    fn default() -> Self {
        Self {
            members: Vec::new(),
            panels: Vec::new(),
            laplacian: Mat::new(),
            factor: Mat::new(),
            pivots: Vec::new(),
            inverses: Mat::new(),
            scaled: Mat::new(),
            rows: Mat::new(),
            scratch: MemBuffer::new(StackReq::empty()),
            shift: 0.0,
            below: 0,
        }
    }
}

impl Envelope {
    /// Takes the returns that are connected with the first of `unseen` out of it, and forms equation (2) for them, `scale` being
    /// the diagonal of D^-1/2 of all. `false` if a weight of theirs is not finite.
    ///
    /// They are ordered breadth first from that one, those found from the same return as they stand in `unseen`: from the least
    /// degree at an end of the walls to larger ones, that is the order of Cuthill and McKee.
    pub(crate) fn take(&mut self, w: &Mat<f64>, scale: &[f64], unseen: &mut Vec<u32>) -> bool {
        let Self { members, panels, laplacian, .. } = self;
        members.clear();
        panels.clear();
        members.extend(unseen.first());
        laplacian.resize_with(unseen.len(), unseen.len(), |_, _| 0.0);
        unseen.retain(|&i| Some(&i) != members.first());
        let mut ends: Vec<usize> = Vec::new();
        let mut finite = true;
        while let Some(&of_column) = members.get(ends.len()) {
            let (j, start) = (ends.len(), ends.len() / PANEL * PANEL);
            let weights = w.col_as_slice(of_column as usize);
            let scale_j = scale[of_column as usize];
            unseen.retain(|&i| {
                let is_apart = (weights[i as usize] * scale[i as usize]).abs() < NOTHING / scale_j;
                if !is_apart {
                    members.push(i);
                }
                is_apart
            });
            let column = &mut laplacian.col_as_slice_mut(j)[start..members.len()];
            for (l, &i) in column.iter_mut().zip(&members[start..]) {
                *l = -weights[i as usize] * (scale[i as usize] * scale_j);
            }
            column[j - start] += 1.0;
            finite &= column.iter().fold(true, |finite, l| finite & l.is_finite());
            ends.push(members.len());
        }
        for (start, ends) in (0..).step_by(PANEL).zip(ends.chunks(PANEL)) {
            let panel = Panel { start, next: start + ends.len(), end: ends[ends.len() - 1] };
            for (j, &end) in (start..).zip(ends) {
                laplacian.col_as_slice_mut(j)[end..panel.end].fill(0.0);
            }
            panels.push(panel);
        }
        finite
    }

    /// The returns of the part, in the order of the rows.
    pub(crate) fn members(&self) -> &[u32] {
        &self.members
    }

    /// L, n×n.
    pub(crate) fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.n(), self.n());
        for panel in &self.panels {
            let (rows, columns) = (panel.end - panel.start, panel.columns());
            let block = self.laplacian.submatrix(panel.start, panel.start, rows, columns);
            dense.submatrix_mut(panel.start, panel.start, rows, columns).copy_from(block);
            dense.submatrix_mut(panel.start, panel.start, columns, rows).copy_from(block.transpose());
        }
        dense
    }

    /// Number of returns.
    pub(crate) fn n(&self) -> usize {
        self.members.len()
    }

    /// L x.
    pub(crate) fn times(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.n(), x.ncols());
        for panel in &self.panels {
            let all = self.laplacian.submatrix(panel.start, panel.start, panel.end - panel.start, panel.columns());
            let of_panel = x.subrows(panel.start, panel.columns());
            add(out.subrows_mut(panel.start, all.nrows()), 1.0, all, of_panel);
            let lower = panel.lower(&self.laplacian);
            add(
                out.subrows_mut(panel.start, panel.columns()),
                1.0,
                lower.transpose(),
                x.subrows(panel.next, panel.below()),
            );
        }
        out
    }

    /// Factorises L - `shift`·I. `false` if a pivot is 0.
    pub(crate) fn factorise(&mut self, shift: f64) -> bool {
        self.shift = shift;
        self.pivots.clear();
        self.factor.resize_with(self.n(), self.n(), |_, _| 0.0);
        self.inverses.resize_with(PANEL, self.n(), |_, _| 0.0);
        self.scaled.resize_with(self.n(), PANEL, |_, _| 0.0);
        let needed = factor::cholesky_in_place_scratch::<f64>(PANEL, Par::Seq, Spec::default());
        if self.scratch.len() < needed.unaligned_bytes_required() {
            self.scratch = MemBuffer::new(needed);
        }
        for panel in &self.panels {
            for j in panel.start..panel.next {
                let column = &mut self.factor.col_as_slice_mut(j)[j..panel.end];
                column.copy_from_slice(&self.laplacian.col_as_slice(j)[j..panel.end]);
                column[0] -= shift;
            }
        }
        let done = (0..self.panels.len()).all(|panel| self.eliminate(self.panels[panel]));
        self.below = self.pivots.iter().filter(|&&pivot| pivot < 0.0).count();
        done
    }

    /// One panel of the factor, and what it takes off those to its right. `false` if a pivot is 0.
    fn eliminate(&mut self, panel: Panel) -> bool {
        let Self { factor, pivots, inverses, scaled, scratch, .. } = self;
        let (mut left, mut right) = factor.as_mut().split_at_col_mut(panel.next);
        let (top, bottom) = left.rb_mut().subcols_mut(panel.start, panel.columns()).split_at_row_mut(panel.next);
        let mut diagonal = top.subrows_mut(panel.start, panel.columns());
        let scratch = MemStack::new(scratch);
        let signs = factor::LdltRegularization::default();
        if factor::cholesky_in_place(diagonal.rb_mut(), signs, Par::Seq, scratch, Spec::default()).is_err() {
            return false;
        }
        let mut inverse = inverses.submatrix_mut(0, panel.start, panel.columns(), panel.columns());
        inverse.fill(0.0);
        invert_unit_lower_triangular(inverse.rb_mut(), diagonal.rb(), Par::Seq);
        inverse.rb_mut().diagonal_mut().fill(1.0);

        let mut lower = bottom.subrows_mut(0, panel.below());
        let mut scaled = scaled.submatrix_mut(0, 0, panel.below(), panel.columns());
        set(scaled.rb_mut(), lower.rb(), inverse.rb().transpose());
        for j in 0..panel.columns() {
            let pivot = diagonal[(j, j)];
            pivots.push(pivot);
            let columns = zip!(lower.rb_mut().col_mut(j), scaled.rb().col(j));
            columns.for_each(|unzip!(lower, scaled)| *lower = scaled / pivot);
        }
        triangular::matmul(
            right.rb_mut().submatrix_mut(panel.next, 0, panel.below(), panel.below()),
            BlockStructure::TriangularLower,
            Accum::Add,
            lower.rb(),
            BlockStructure::Rectangular,
            scaled.rb().transpose(),
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        true
    }

    /// The shift of the last factorisation.
    pub(crate) fn shift(&self) -> f64 {
        self.shift
    }

    /// The number of eigenvalues below the shift, by Sylvester's law.
    pub(crate) fn below(&self) -> usize {
        self.below
    }

    /// Solves (L - shift·I) X = `x` in place.
    pub(crate) fn solve(&mut self, mut x: MatMut<'_, f64>) {
        let Self { panels, factor, pivots, inverses, rows, .. } = self;
        rows.resize_with(PANEL, x.ncols(), |_, _| 0.0);
        for panel in panels.iter() {
            let (top, mut bottom) = x.rb_mut().split_at_row_mut(panel.next);
            let mut of_panel = top.subrows_mut(panel.start, panel.columns());
            let mut rows = rows.subrows_mut(0, panel.columns());
            set(rows.rb_mut(), inverses.submatrix(0, panel.start, panel.columns(), panel.columns()), of_panel.rb());
            add(bottom.rb_mut().subrows_mut(0, panel.below()), -1.0, panel.lower(factor), rows.rb());
            for j in 0..rows.ncols() {
                let pivots = &pivots[panel.start..panel.next];
                let columns = zip!(of_panel.rb_mut().col_mut(j), rows.rb().col(j), ColRef::from_slice(pivots));
                columns.for_each(|unzip!(x, row, pivot)| *x = row / pivot);
            }
        }
        for panel in panels.iter().rev() {
            let (top, bottom) = x.rb_mut().split_at_row_mut(panel.next);
            let mut of_panel = top.subrows_mut(panel.start, panel.columns());
            add(of_panel.rb_mut(), -1.0, panel.lower(factor).transpose(), bottom.rb().subrows(0, panel.below()));
            let mut rows = rows.subrows_mut(0, panel.columns());
            let inverse = inverses.submatrix(0, panel.start, panel.columns(), panel.columns());
            set(rows.rb_mut(), inverse.transpose(), of_panel.rb());
            of_panel.copy_from(rows);
        }
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
