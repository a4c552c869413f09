//! Frames to columns.

use crosscut_stage::{Embedding, FailureCause, Frame, Partition, Step, Sweep, Weights};
use nalgebra::Isometry2;
use pyo3::prelude::*;

use super::matrices::{RowMajor, write_matrices};
use super::number_of_beam;
use crate::columns::Columns;

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
            out.lists("verdict_is_opening", 1, verdicts().map(|of| of.map(|verdict| verdict.is_opening)))?;
            out.lists("verdict_room_ratio", 1, verdicts().map(|of| of.map(|verdict| verdict.room_ratio)))?;
            out.lists("verdict_p", 1, verdicts().map(|of| of.map(|verdict| verdict.p.unwrap_or(f64::NAN))))?;
            out.lists_of_texts("verdict_reason", verdicts().map(|of| of.map(|verdict| verdict.reason)))?;
        }
        Step::Spectral => {
            let none = Default::default();
            let spectra = || frames.iter().map(|frame| if done(frame) { &frame.spectrum } else { &none });
            out.lists("eigenvalues", 1, spectra().map(|of| of.eigenvalues.iter().copied()))?;
            out.numbers("k", spectra().map(|of| of.k as u64))?;
            out.numbers("zero_tolerance", spectra().map(|of| of.tolerance))?;
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
