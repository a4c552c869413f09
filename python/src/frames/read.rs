//! Columns to frames.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crosscut_stage::{Csr, Embedding, Failure, FailureCause, Frame, NoteCode, Point, Step, Sweep, Verdict};
use nalgebra::{Complex, Isometry2, Translation2, UnitComplex};
use pyo3::prelude::*;

use super::beam_of_number;
use super::matrices::{Matrices, spans};
use crate::columns::{Columns, Lists, wrong};
use crate::stages::numbered_by_first_return;

/// At most this many reasons of verdicts are stored until the program ends; a stage has a few dozen.
const MOST_REASONS: usize = 1000;

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

/// Reads frames as they are before the report, with W and U where these are there: a stage may have left them out.
#[cfg(feature = "rerun")]
pub(crate) fn read_to_record(columns: &Columns<'_>) -> PyResult<Vec<Frame>> {
    let mut frames = read_scans(columns)?;
    if columns.has("w_value")? {
        read_graphs(columns, &mut frames)?;
    }
    read_verdicts(columns, &mut frames)?;
    read_spectra(columns, &mut frames, columns.has("u_value")?)?;
    read_partitions(columns, &mut frames)?;
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
                fan: None,
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
        frame.notes.extend(notes[row].iter().map(|note| (NoteCode::N101, note.as_str())));
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
    let is_opening: Lists<bool> = columns.read_lists("verdict_is_opening", 1, rows)?;
    let room_ratio: Lists<f64> = columns.read_lists("verdict_room_ratio", 1, rows)?;
    let p: Lists<f64> = columns.read_lists("verdict_p", 1, rows)?;
    let reasons = columns.read_lists_of_texts("verdict_reason", rows)?;
    let holds: Lists<f64> = columns.read_lists("holds_for_width_m", 1, rows)?;
    for (row, frame) in whole(frames) {
        let n = frame.revolution.len();
        let count = is_opening.row(row).len();
        let lengths = [returns.row(row).len() / 2, room_ratio.row(row).len(), p.row(row).len(), reasons[row].len()];
        if lengths != [count; 4] || returns.row(row).iter().any(|&i| i as usize >= n) {
            return Err(wrong("verdict_returns", row, "does not fit the returns and the other columns of verdicts"));
        }
        frame.affinity.holds_for_width_m = holds.row(row).try_into().ok(); // none, where it is not known
        frame.affinity.verdicts.extend((0..count).map(|at| Verdict {
            returns: [returns.row(row)[2 * at], returns.row(row)[2 * at + 1]],
            is_opening: is_opening.row(row)[at],
            room_ratio: room_ratio.row(row)[at],
            p: Some(p.row(row)[at]).filter(|p| !p.is_nan()),
            reason: kept_reason(&reasons[row][at]),
            measured: None,
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
    let tolerances: Vec<f64> = columns.read_numbers("zero_tolerance", Some(rows))?;
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
        spectrum.tolerance = tolerances[row];
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
