//! `blocks`: the eigenvalues near zero, component by component, for sparse graphs.

use crosscut_stage::{Affinity, Kind, Notes, ParamError, SpectralStage, Spectrum, StageError};

use crate::FaerEvd;
use crate::band::Band;
use crate::degrees::check_degrees;
use crate::forest::Forest;
use crate::laplacian::dense_bytes;
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "blocks",
    doc: "the zero eigenvalues and the next, component by component by a banded factorisation, for sparse graphs",
    params: &[ZERO_TOLERANCE],
    build: |params| Box::new(Blocks::with(ZeroRule::of(params))),
};

/// L is block diagonal, one block for each component C of the graph. A block has the eigenvalue 0, with the eigenvector
/// D^1/2 1_C / ‖D^1/2 1_C‖, and no other below τ if L_C - τI has one negative pivot (Sylvester). Its next eigenvalue is
/// found by inverse iteration, and believed if one eigenvalue lies below it and two lie at or below it, by the pivots
/// again. A block that does not pass goes through the full decomposition, with a note.
pub struct Blocks {
    rule: ZeroRule,
    forest: Forest,
    band: Band,
    full: FaerEvd,
}

/// What a block adds: its zeros, its next eigenvalue, and the columns of U, if they are not the known ones.
struct Block {
    zeros: Vec<f64>,
    next: Option<f64>,
    columns: Option<faer::Mat<f64>>,
}

impl Blocks {
    /// Takes as zero what `rule` says.
    ///
    /// # Errors
    /// When a number of the rule is out of range.
    pub fn new(rule: ZeroRule) -> Result<Self, ParamError> {
        rule.checked().map(Self::with)
    }

    fn with(rule: ZeroRule) -> Self {
        Self { rule, forest: Forest::default(), band: Band::default(), full: FaerEvd::with(rule) }
    }

    fn block(&mut self, affinity: &Affinity, members: &[u32], notes: &mut Notes) -> Result<Block, StageError> {
        if members.len() == 1 {
            return Ok(Block { zeros: vec![0.0], next: None, columns: None });
        }
        let ZeroRule::Tolerance(tolerance) = self.rule;
        self.band.form(affinity, members);
        if let Some(next) = self.band.second_eigenvalue().filter(|&next| next >= tolerance) {
            return Ok(Block { zeros: vec![0.0], next: Some(next), columns: None });
        }
        notes.add(format!("blocks: a component of {} returns by full decomposition", members.len()));
        let mut spectrum = Spectrum::default();
        self.full.spectrum(&part_of(affinity, members), &mut spectrum, notes)?;
        let next = spectrum.eigenvalues.get(spectrum.k).copied();
        spectrum.eigenvalues.truncate(spectrum.k);
        Ok(Block { zeros: spectrum.eigenvalues, next, columns: Some(spectrum.u) })
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
        let n = affinity.degrees.len();
        let components = self.forest.components(&affinity.weights)?.to_vec();
        let mut members = vec![Vec::new(); components.iter().max().map_or(0, |last| *last as usize + 1)];
        components.iter().enumerate().for_each(|(i, &component)| members[component as usize].push(i as u32));

        let blocks = members.iter().map(|members| self.block(affinity, members, notes));
        let blocks = blocks.collect::<Result<Vec<_>, _>>()?;
        out.k = blocks.iter().map(|block| block.zeros.len()).sum();
        out.u.resize_with(n, out.k, |_, _| 0.0);
        out.u.fill(0.0);
        // Columns in the order of their eigenvalues, of equal ones in the order of the components.
        let mut columns: Vec<(f64, usize, usize)> = Vec::with_capacity(out.k);
        for (at, block) in blocks.iter().enumerate() {
            columns.extend(block.zeros.iter().enumerate().map(|(column, &zero)| (zero, at, column)));
        }
        columns.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (j, &(_, at, column)) in columns.iter().enumerate() {
            let volume: f64 = members[at].iter().map(|&i| affinity.degrees[i as usize]).sum();
            for (row, &i) in members[at].iter().enumerate() {
                out.u[(i as usize, j)] = match &blocks[at].columns {
                    Some(u) => u[(row, column)],
                    None => (affinity.degrees[i as usize] / volume).sqrt(),
                };
            }
        }
        let ZeroRule::Tolerance(tolerance) = self.rule;
        out.eigenvalues.clear();
        out.eigenvalues.extend(columns.iter().map(|(zero, ..)| zero));
        out.eigenvalues.extend(blocks.iter().filter_map(|block| block.next).min_by(f64::total_cmp));
        out.tolerance = tolerance;
        out.margin_decades = Spectrum::tolerance_margin_decades(&out.eigenvalues, n, out.k, tolerance);
        Ok(())
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        // At worst one component that needs the full decomposition, and its part of W made dense.
        self.full.memory_bytes(n).saturating_add(dense_bytes(n))
    }
}
