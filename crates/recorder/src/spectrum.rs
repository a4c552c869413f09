//! λ, τ, k and U: exact values, and a chart in which "why 4 and not 3" can be seen.

use crosscut_stage::{Frame, Spectrum};
use rerun::{
    AsComponents, BarChart, Color, LineStrips2D, Points2D, Points3D, Radius, RecordingStream, RecordingStreamResult,
    Scalars, SeriesLines, TensorBuffer, TensorData,
};

use crate::colors::{GREY, TOLERANCE, ZEROS, class_of, color};
use crate::tensors::{f64_matrix, rows_of};

/// The chart spans 1e-18 to 100: rounding leaves zeros at about 1e-16, and λ never exceeds 2.
const FLOOR_DECADE: f32 = -18.0;
/// Eigenvalues drawn; more of them would not be told apart.
const DRAWN: usize = 16;
/// Width of a column of the chart, in decades.
const COLUMN: f32 = 1.6;

/// Look of the entities, and the chart's axis.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static("spectral/embedding", &Points3D::update_fields().with_radii([ui(3.0)]))?;
    let line = |name: &str, rgba| SeriesLines::new().with_names([name]).with_colors([color(rgba)]).with_widths([2.0]);
    rec.log_static("spectral/k", &line("k (zeros)", ZEROS))?;
    rec.log_static("spectral/margin", &line("margin [decades]", GREY))?;
    let decades: Vec<i32> = (-16..=0).step_by(4).collect();
    let right = COLUMN * (DRAWN as f32 + 0.5);
    let grid = LineStrips2D::new(decades.iter().map(|&d| [[0.0, -d as f32], [right, -d as f32]]))
        .with_radii([ui(0.5)])
        .with_colors([color(0x8C8C_8C60)]);
    let marks = Points2D::new(decades.iter().map(|&d| [-1.6, -d as f32]))
        .with_radii([ui(0.0)])
        .with_colors([color(GREY)])
        .with_labels(decades.iter().map(|d| format!("1e{d}")))
        .with_show_labels(true);
    rec.log_static("spectral/chart/axis", &[&grid as &dyn AsComponents, &marks])
}

/// λ, τ, k, margin, U and the embedding of one revolution.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    let spectrum = &frame.spectrum;
    let values = &spectrum.eigenvalues;
    let exact = TensorData::new(vec![values.len() as u64], TensorBuffer::F64(values.clone().into()));
    rec.log("spectral/eigenvalues", &BarChart::new(exact).with_color(color(ZEROS)))?;
    rec.log("spectral/tolerance", &Scalars::single(spectrum.tolerance))?;
    rec.log("spectral/k", &Scalars::single(spectrum.k as f64))?;
    rec.log("spectral/margin", &Scalars::new(spectrum.margin_decades))?;
    log_chart(rec, spectrum)?;
    let (n, k) = (spectrum.u.nrows(), spectrum.u.ncols());
    rec.log("spectral/U", &f64_matrix(rows_of(&spectrum.u), [n, k], ["return", "eigenvector"]))?;
    let wall_of = |i: usize| frame.junction.wall_of_return.get(i).copied().flatten();
    let points = (0..n).map(|i| std::array::from_fn(|j| if j < k { spectrum.u[(i, j)] as f32 } else { 0.0 }));
    let embedding = Points3D::new(points.map(|p: [f32; 3]| p)).with_class_ids((0..n).map(|i| class_of(wall_of(i))));
    rec.log("spectral/embedding", &embedding)
}

/// A column for each eigenvalue on a logarithmic scale, the zeros in colour, and τ across them all.
fn log_chart(rec: &RecordingStream, spectrum: &Spectrum) -> RecordingStreamResult<()> {
    let drawn = &spectrum.eigenvalues[..spectrum.eigenvalues.len().min(DRAWN)];
    let x = |i: usize| COLUMN * (i as f32 + 0.75);
    let bars = LineStrips2D::new(drawn.iter().enumerate().map(|(i, &l)| [[x(i), -FLOOR_DECADE], [x(i), height(l)]]))
        .with_colors((0..drawn.len()).map(|i| zero_or_not(i, spectrum.k)))
        .with_radii([Radius::new_scene_units(0.3 * COLUMN)]);
    let deciding: Vec<usize> = [spectrum.k.checked_sub(1), Some(spectrum.k)].into_iter().flatten().collect();
    let deciding = deciding.into_iter().filter(|&i| i < drawn.len());
    let tops = Points2D::new(deciding.clone().map(|i| [x(i), height(drawn[i]) - 0.8]))
        .with_colors(deciding.clone().map(|i| zero_or_not(i, spectrum.k)))
        .with_radii([Radius::new_ui_points(0.0)])
        .with_labels(deciding.map(|i| format!("λ{} {:.0e}", i + 1, drawn[i])))
        .with_show_labels(true);
    rec.log("spectral/chart/columns", &[&bars as &dyn AsComponents, &tops])?;
    let at = height(spectrum.tolerance);
    let (left, right) = (0.0, COLUMN * (DRAWN as f32 + 0.5));
    let line = LineStrips2D::new([[[left, at], [right, at]]])
        .with_colors([color(TOLERANCE)])
        .with_radii([Radius::new_ui_points(1.5)]);
    let name = Points2D::new([[right - 4.0, at - 0.8]])
        .with_colors([color(TOLERANCE)])
        .with_radii([Radius::new_ui_points(0.0)])
        .with_labels([format!("τ {:.0e} → k = {}", spectrum.tolerance, spectrum.k)])
        .with_show_labels(true);
    rec.log("spectral/chart/tolerance", &[&line as &dyn AsComponents, &name])
}

fn zero_or_not(i: usize, k: usize) -> Color {
    color(if i < k { ZEROS } else { GREY })
}

/// Where a value stands in the chart: 2D views have y downwards.
fn height(value: f64) -> f32 {
    -(value.abs().log10() as f32).clamp(FLOOR_DECADE, 2.0)
}

/// Left, top, right and bottom of the chart.
pub(crate) fn chart_bounds() -> [f64; 4] {
    [-3.0, -1.5, f64::from(COLUMN) * (DRAWN as f64 + 0.5) + 0.5, f64::from(-FLOOR_DECADE) + 0.5]
}
