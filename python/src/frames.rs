//! Frames as columns, one row a frame, so that the steps of an engine can run in several processes.
//!
//! A column is an array of numpy; of lists, the start of each row's list and the values of all rows; of text, its UTF-8
//! likewise. `python/crosscut/_frames.py` makes Arrow of them. What a later step reads is there, to the last bit, and
//! nothing else: W ends at the spectral step, U at the k-means step.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crosscut_stage::{
    Beam, Csr, Embedding, Failure, FailureCause, Frame, Partition, Point, Step, Sweep, Verdict, Weights,
};
use nalgebra::{Complex, Isometry2, Translation2, UnitComplex};
use pyo3::prelude::*;

use crate::columns::{Columns, Lists, wrong};
use crate::stages::numbered_by_first_return;

/// In `return_of_beam`: a beam that came back with nothing, and one of which nothing is known.
const NO_RETURN: i32 = -1;
const UNKNOWN: i32 = -2;

/// At most this many reasons of verdicts are stored until the program ends; a stage has a few dozen.
const MOST_REASONS: usize = 1000;

/// Writes the scans, and what is noted and measured so far.
pub(crate) fn write_scans(frames: &[Frame], out: &Columns<'_>) -> PyResult<()> {
    let of = |frame: &Frame| (frame.revolution.seq, frame.revolution.stamp_ns);
    out.numbers("seq", frames.iter().map(|frame| of(frame).0))?;
    out.numbers("stamp_ns", frames.iter().map(|frame| of(frame).1))?;
    out.texts("frame_id", frames.iter().map(|frame| frame.revolution.frame_id.as_str()))?;
    out.lists("points_m", 3, frames.iter().map(|f| f.revolution.points_m.iter().flat_map(|p| [p.x, p.y, p.z])))?;
    let absent = Sweep::default();
    let sweeps = || frames.iter().map(|frame| frame.revolution.sweep.as_ref().unwrap_or(&absent));
    out.numbers("has_beams", frames.iter().map(|frame| frame.revolution.sweep.is_some()))?;
    out.lists("ranges_m", 1, sweeps().map(|sweep| sweep.ranges_m.iter().copied()))?;
    out.lists("bearings_rad", 1, sweeps().map(|sweep| sweep.bearings_rad.iter().copied()))?;
    out.lists("return_of_beam", 1, sweeps().map(|sweep| sweep.beams.iter().map(number_of_beam)))?;
    out.numbers("step_rad", sweeps().map(|sweep| sweep.step_rad))?;
    out.numbers("range_max_m", sweeps().map(|sweep| sweep.range_max_m))?;
    out.numbers("full_turn", sweeps().map(|sweep| sweep.full_turn))?;
    out.numbers("missing_beams", sweeps().map(|sweep| sweep.missing as u64))?;
    out.numbers("wire_geometry", sweeps().flat_map(|sweep| sweep.wire_geometry))?;
    out.lists(
        "odometry",
        1,
        frames.iter().map(|frame| {
            let parts = |pose: &Isometry2<f64>| {
                [pose.translation.x, pose.translation.y, pose.rotation.as_ref().re, pose.rotation.as_ref().im]
            };
            frame.revolution.odometry.as_ref().map(parts).into_iter().flatten()
        }),
    )?;
    write_progress(frames, out)
}

/// Writes what step `step` gave, and what every step changes.
pub(crate) fn write_step(step: Step, frames: &[Frame], out: &Columns<'_>) -> PyResult<()> {
    let done = |frame: &Frame| frame.failure.is_none();
    match step {
        Step::Affinity => {
            let (no_weights, no_verdicts) = (Weights::default(), Vec::new());
            let weights = frames.iter().map(|f| if done(f) { &f.affinity.weights } else { &no_weights });
            let matrices: Vec<_> = weights
                .map(|w| {
                    let sparse = match w {
                        Weights::Sparse(rows) => Some(rows),
                        _ => None,
                    };
                    RowMajor::of(sparse, [w.n(), w.n()], |entry| w.for_each(entry))
                })
                .collect();
            write_matrices("w", &matrices, out)?;
            let verdicts = || frames.iter().map(|f| if done(f) { &f.affinity.verdicts } else { &no_verdicts }.iter());
            out.lists("verdict_returns", 2, verdicts().map(|of| of.flat_map(|verdict| verdict.returns)))?;
            out.lists("verdict_is_way", 1, verdicts().map(|of| of.map(|verdict| verdict.is_way)))?;
            out.lists("verdict_room_ratio", 1, verdicts().map(|of| of.map(|verdict| verdict.room_ratio)))?;
            out.lists("verdict_p", 1, verdicts().map(|of| of.map(|verdict| verdict.p.unwrap_or(f64::NAN))))?;
            out.lists_of_texts("verdict_reason", verdicts().map(|of| of.map(|verdict| verdict.reason)))?;
        }
        Step::Spectral => {
            let none = Default::default();
            let spectra = || frames.iter().map(|frame| if done(frame) { &frame.spectrum } else { &none });
            out.lists("eigenvalues", 1, spectra().map(|of| of.eigenvalues.iter().copied()))?;
            out.numbers("k", spectra().map(|of| of.k as u64))?;
            out.numbers("margin_decades", spectra().map(|of| of.margin_decades.unwrap_or(f64::NAN)))?;
            let matrices: Vec<_> = spectra()
                .map(|of| {
                    let sparse = match &of.u {
                        Embedding::Sparse { rows, .. } => Some(rows),
                        _ => None,
                    };
                    RowMajor::of(sparse, [of.u.nrows(), of.u.ncols()], |entry| of.u.for_each(entry))
                })
                .collect();
            write_matrices("u", &matrices, out)?;
        }
        Step::Kmeans => {
            let none = Partition::default();
            let partitions = frames.iter().map(|frame| if done(frame) { &frame.partition } else { &none });
            out.lists(
                "clusters",
                1,
                partitions.map(|of| of.labels.iter().map(|label| label.map_or(-1, u32::cast_signed))),
            )?;
        }
        Step::Ingest | Step::Report => {}
    }
    write_progress(frames, out)
}

fn write_progress(frames: &[Frame], out: &Columns<'_>) -> PyResult<()> {
    out.lists_of_texts("notes", frames.iter().map(|frame| frame.notes.iter()))?;
    out.numbers("timings_ns", frames.iter().flat_map(|frame| Step::ALL.map(|step| frame.timings.ns(step))))?;
    let failures = || frames.iter().map(|frame| frame.failure.as_ref());
    out.texts("failed_step", failures().map(|failure| failure.map_or("", |failure| failure.step.name())))?;
    out.texts("failure", failures().map(|failure| failure.map_or("", |failure| text_of(&failure.cause))))?;
    out.numbers("panicked", failures().map(|of| of.is_some_and(|of| matches!(of.cause, FailureCause::Panic(_)))))
}

fn text_of(cause: &FailureCause) -> &str {
    let (FailureCause::Error(text) | FailureCause::Panic(text)) = cause;
    text
}

fn number_of_beam(beam: &Beam) -> i32 {
    match beam {
        Beam::Return(i) => i.cast_signed(),
        Beam::NoReturn => NO_RETURN,
        Beam::Unknown => UNKNOWN,
    }
}

/// A matrix row by row: all entries, or those that are stored, with their columns and the start of each row.
#[derive(Default)]
struct RowMajor {
    starts: Vec<u64>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl RowMajor {
    /// Of a sparse matrix, its `rows`; of one with all entries, the values that `for_each` gives in any order.
    fn of(
        rows: Option<&Csr>,
        [nrows, ncols]: [usize; 2],
        for_each: impl FnOnce(&mut dyn FnMut(usize, usize, f64)),
    ) -> Self {
        let mut this = Self::default();
        if let Some(rows) = rows {
            this.starts.push(0);
            for i in 0..nrows {
                let (columns, values) = rows.row(i);
                this.columns.extend_from_slice(columns);
                this.values.extend_from_slice(values);
                this.starts.push(this.values.len() as u64);
            }
        } else {
            this.values.resize(nrows * ncols, 0.0);
            for_each(&mut |i, j, value| this.values[i * ncols + j] = value);
        }
        this
    }
}

/// Row starts are an empty list for a matrix with all its entries.
fn write_matrices(name: &str, matrices: &[RowMajor], out: &Columns<'_>) -> PyResult<()> {
    out.lists(&format!("{name}_row_start"), 1, matrices.iter().map(|m| m.starts.iter().copied()))?;
    out.lists(&format!("{name}_column"), 1, matrices.iter().map(|m| m.columns.iter().copied()))?;
    out.lists(&format!("{name}_value"), 1, matrices.iter().map(|m| m.values.iter().copied()))
}

/// Reads frames as they are before step `step`.
pub(crate) fn read(step: Step, columns: &Columns<'_>) -> PyResult<Vec<Frame>> {
    let mut frames = read_scans(columns)?;
    match step {
        Step::Ingest | Step::Affinity => {}
        Step::Spectral => read_graphs(columns, &mut frames)?,
        Step::Kmeans => read_spectra(columns, &mut frames, true)?,
        Step::Report => {
            read_verdicts(columns, &mut frames)?;
            read_spectra(columns, &mut frames, false)?;
            read_partitions(columns, &mut frames)?;
        }
    }
    Ok(frames)
}

fn read_scans(columns: &Columns<'_>) -> PyResult<Vec<Frame>> {
    let seq: Vec<u64> = columns.read_numbers("seq", None)?;
    let rows = seq.len();
    let stamps_ns: Vec<u64> = columns.read_numbers("stamp_ns", Some(rows))?;
    let frame_ids = columns.read_texts("frame_id", rows)?;
    let points: Lists<f64> = columns.read_lists("points_m", 3, rows)?;
    let has_beams: Vec<bool> = columns.read_numbers("has_beams", Some(rows))?;
    let ranges_m: Lists<f32> = columns.read_lists("ranges_m", 1, rows)?;
    let bearings_rad: Lists<f64> = columns.read_lists("bearings_rad", 1, rows)?;
    let return_of_beam: Lists<i32> = columns.read_lists("return_of_beam", 1, rows)?;
    let steps_rad: Vec<f64> = columns.read_numbers("step_rad", Some(rows))?;
    let range_max_m: Vec<f64> = columns.read_numbers("range_max_m", Some(rows))?;
    let full_turn: Vec<bool> = columns.read_numbers("full_turn", Some(rows))?;
    let missing: Vec<u64> = columns.read_numbers("missing_beams", Some(rows))?;
    let wire_geometry: Vec<f32> = columns.read_numbers("wire_geometry", Some(4 * rows))?;
    let odometry: Lists<f64> = columns.read_lists("odometry", 1, rows)?;
    let notes = columns.read_lists_of_texts("notes", rows)?;
    let timings_ns: Vec<u64> = columns.read_numbers("timings_ns", Some(Step::ALL.len() * rows))?;
    let failed_steps = columns.read_texts("failed_step", rows)?;
    let failures = columns.read_texts("failure", rows)?;
    let panicked: Vec<bool> = columns.read_numbers("panicked", Some(rows))?;

    let mut frames = vec![Frame::default(); rows];
    for (row, frame) in frames.iter_mut().enumerate() {
        let revolution = &mut frame.revolution;
        (revolution.seq, revolution.stamp_ns) = (seq[row], stamps_ns[row]);
        revolution.frame_id.push_str(&frame_ids[row]);
        revolution.points_m.extend(points.row(row).chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])));
        if has_beams[row] {
            let beams: Option<Vec<_>> = return_of_beam
                .row(row)
                .iter()
                .map(|&number| beam_of_number(number, revolution.points_m.len()))
                .collect();
            let beams = beams.ok_or_else(|| wrong("return_of_beam", row, "numbers a return that is not there"))?;
            if beams.len() != bearings_rad.row(row).len() {
                return Err(wrong("bearings_rad", row, "is not as long as return_of_beam"));
            }
            revolution.sweep = Some(Sweep {
                ranges_m: ranges_m.row(row).to_vec(),
                bearings_rad: bearings_rad.row(row).to_vec(),
                beams,
                step_rad: steps_rad[row],
                range_max_m: range_max_m[row],
                full_turn: full_turn[row],
                missing: missing[row] as usize,
                wire_geometry: [0, 1, 2, 3].map(|at| wire_geometry[4 * row + at]),
            });
        }
        revolution.odometry = match *odometry.row(row) {
            [] => None,
            [x_m, y_m, cos, sin] => {
                let rotation = UnitComplex::new_unchecked(Complex::new(cos, sin));
                Some(Isometry2::from_parts(Translation2::new(x_m, y_m), rotation))
            }
            _ => return Err(wrong("odometry", row, "is not x_m, y_m and the cosine and sine of the yaw")),
        };
        frame.notes.extend(notes[row].iter().map(String::as_str));
        for (step, ns) in Step::ALL.into_iter().zip(&timings_ns[Step::ALL.len() * row..]) {
            frame.timings.set_ns(step, *ns);
        }
        if !failed_steps[row].is_empty() {
            let step = Step::ALL.into_iter().find(|step| step.name() == failed_steps[row]);
            let step = step.ok_or_else(|| wrong("failed_step", row, "is no step"))?;
            let cause = if panicked[row] { FailureCause::Panic } else { FailureCause::Error };
            frame.failure = Some(Failure { step, seq: seq[row], cause: cause(failures[row].clone()) });
        }
    }
    Ok(frames)
}

fn beam_of_number(number: i32, returns: usize) -> Option<Beam> {
    match number {
        NO_RETURN => Some(Beam::NoReturn),
        UNKNOWN => Some(Beam::Unknown),
        i => u32::try_from(i).ok().filter(|&i| (i as usize) < returns).map(Beam::Return),
    }
}

/// Frames that have not failed, with their rows.
fn whole(frames: &mut [Frame]) -> impl Iterator<Item = (usize, &mut Frame)> {
    frames.iter_mut().enumerate().filter(|(_, frame)| frame.failure.is_none())
}

/// Degrees are the sums of the rows of W, whoever made it.
fn read_graphs(columns: &Columns<'_>, frames: &mut [Frame]) -> PyResult<()> {
    let matrices = Matrices::read("w", columns, frames.len())?;
    for (row, frame) in whole(frames) {
        let n = frame.revolution.len();
        let weights = &mut frame.affinity.weights;
        match matrices.row(row, [n, n])? {
            (None, values) => {
                let dense = weights.make_dense(n);
                (0..n).for_each(|j| (0..n).for_each(|i| dense[(i, j)] = values[i * n + j]));
            }
            (Some((starts, of_entry)), values) => {
                let sparse = weights.make_sparse();
                spans(starts).for_each(|span| sparse.push_row(&of_entry[span.clone()], &values[span]));
            }
        }
        frame.affinity.sum_degrees();
    }
    Ok(())
}

fn read_verdicts(columns: &Columns<'_>, frames: &mut [Frame]) -> PyResult<()> {
    let rows = frames.len();
    let returns: Lists<u32> = columns.read_lists("verdict_returns", 2, rows)?;
    let is_way: Lists<bool> = columns.read_lists("verdict_is_way", 1, rows)?;
    let room_ratio: Lists<f64> = columns.read_lists("verdict_room_ratio", 1, rows)?;
    let p: Lists<f64> = columns.read_lists("verdict_p", 1, rows)?;
    let reasons = columns.read_lists_of_texts("verdict_reason", rows)?;
    for (row, frame) in whole(frames) {
        let n = frame.revolution.len();
        let count = is_way.row(row).len();
        let lengths = [returns.row(row).len() / 2, room_ratio.row(row).len(), p.row(row).len(), reasons[row].len()];
        if lengths != [count; 4] || returns.row(row).iter().any(|&i| i as usize >= n) {
            return Err(wrong("verdict_returns", row, "does not fit the returns and the other columns of verdicts"));
        }
        frame.affinity.verdicts.extend((0..count).map(|at| Verdict {
            returns: [returns.row(row)[2 * at], returns.row(row)[2 * at + 1]],
            is_way: is_way.row(row)[at],
            room_ratio: room_ratio.row(row)[at],
            p: Some(p.row(row)[at]).filter(|p| !p.is_nan()),
            reason: kept_reason(&reasons[row][at]),
        }));
    }
    Ok(())
}

/// The text with a lifetime up to the end of the program.
fn kept_reason(reason: &str) -> &'static str {
    static KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(same) = kept.get(reason) {
        return same;
    }
    if kept.len() == MOST_REASONS {
        return "one of very many reasons";
    }
    let new: &'static str = Box::leak(reason.into());
    kept.insert(new);
    new
}

fn read_spectra(columns: &Columns<'_>, frames: &mut [Frame], with_u: bool) -> PyResult<()> {
    let rows = frames.len();
    let eigenvalues: Lists<f64> = columns.read_lists("eigenvalues", 1, rows)?;
    let k: Vec<u64> = columns.read_numbers("k", Some(rows))?;
    let margins: Vec<f64> = columns.read_numbers("margin_decades", Some(rows))?;
    let matrices = if with_u { Some(Matrices::read("u", columns, rows)?) } else { None };
    for (row, frame) in whole(frames) {
        let (n, k) = (frame.revolution.len(), k[row] as usize);
        if k > n {
            return Err(wrong("k", row, "is more than there are returns"));
        }
        let spectrum = &mut frame.spectrum;
        spectrum.eigenvalues.extend_from_slice(eigenvalues.row(row));
        spectrum.k = k;
        spectrum.margin_decades = Some(margins[row]).filter(|margin| !margin.is_nan());
        let Some(matrices) = &matrices else { continue };
        match matrices.row(row, [n, k])? {
            (None, values) => {
                let dense = spectrum.u.make_dense(n, k);
                (0..k).for_each(|j| (0..n).for_each(|i| dense[(i, j)] = values[i * k + j]));
            }
            (Some((starts, of_entry)), values) => {
                let mut sparse = Csr::default();
                spans(starts).for_each(|span| sparse.push_row(&of_entry[span.clone()], &values[span]));
                spectrum.u = Embedding::Sparse { columns: k, rows: sparse };
            }
        }
    }
    Ok(())
}

/// Clusters are numbered by their first return, whoever numbered them.
fn read_partitions(columns: &Columns<'_>, frames: &mut [Frame]) -> PyResult<()> {
    let clusters: Lists<i32> = columns.read_lists("clusters", 1, frames.len())?;
    for (row, frame) in whole(frames) {
        let given = clusters.row(row);
        if given.len() != frame.revolution.len() {
            return Err(wrong("clusters", row, "is not as long as points_m"));
        }
        let given: Vec<_> = given.iter().map(|&label| i64::from(label)).collect();
        (frame.partition.clusters, frame.partition.labels) = numbered_by_first_return(&given);
    }
    Ok(())
}

/// The matrices of all rows.
struct Matrices<'a> {
    name: &'a str,
    starts: Lists<u64>,
    columns: Lists<u32>,
    values: Lists<f64>,
}

impl<'a> Matrices<'a> {
    fn read(name: &'a str, columns: &Columns<'_>, rows: usize) -> PyResult<Self> {
        Ok(Self {
            name,
            starts: columns.read_lists(&format!("{name}_row_start"), 1, rows)?,
            columns: columns.read_lists(&format!("{name}_column"), 1, rows)?,
            values: columns.read_lists(&format!("{name}_value"), 1, rows)?,
        })
    }

    /// The values of the matrix in row `row`; of a sparse one also the starts of its rows and the columns.
    #[expect(clippy::type_complexity)] // taken apart where it is called
    fn row(&self, row: usize, [nrows, ncols]: [usize; 2]) -> PyResult<(Option<(&[u64], &[u32])>, &[f64])> {
        let (starts, columns, values) = (self.starts.row(row), self.columns.row(row), self.values.row(row));
        let shape = format!("is no matrix of {nrows} rows and {ncols} columns");
        if starts.is_empty() {
            let fits = nrows.checked_mul(ncols) == Some(values.len());
            return if fits { Ok((None, values)) } else { Err(wrong(&format!("{}_value", self.name), row, &shape)) };
        }
        let ends_fit = starts.len() == nrows + 1 && starts[0] == 0 && starts[nrows] as usize == values.len();
        let rows_fit = ends_fit && starts.is_sorted() && columns.len() == values.len();
        let ascending = rows_fit && spans(starts).all(|span| columns[span].is_sorted_by(|a, b| a < b));
        if !ascending || columns.iter().any(|&column| column as usize >= ncols) {
            return Err(wrong(&format!("{}_row_start", self.name), row, &shape));
        }
        Ok((Some((starts, columns)), values))
    }
}

fn spans(starts: &[u64]) -> impl Iterator<Item = std::ops::Range<usize>> {
    starts.windows(2).map(|pair| pair[0] as usize..pair[1] as usize)
}
