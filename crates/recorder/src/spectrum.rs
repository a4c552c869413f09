//! λ, τ, k and U: exact values, and a chart in which "why 4 and not 3" can be seen.

use crosscut_explain::inequality;
use crosscut_stage::{Frame, Spectrum};
use faer::Mat;
use rerun::{
    AsComponents, BarChart, LineStrips2D, LineStrips3D, Points2D, Points3D, Radius, RecordingStream,
    RecordingStreamResult, Scalars, TensorBuffer, TensorData,
};

use crate::colors::{GREY, GRID, TOLERANCE, WORDS, ZEROS, color, series};
use crate::rows::Rows;
use crate::schema::{
    SPECTRAL_AXES, SPECTRAL_CHART, SPECTRAL_CHART_AXIS, SPECTRAL_EIGENVALUES, SPECTRAL_EMBEDDING, SPECTRAL_K,
    SPECTRAL_MARGIN, SPECTRAL_TOLERANCE, SPECTRAL_U,
};
use crate::tensors::{f16_matrix, rows_of};
use crate::tracks::Classes;
use crate::words;

/// Lower end of the chart. Rounding leaves zeros at about 1e-16.
const FLOOR_DECADE: f32 = -18.0;
/// Least height of a column: an exact zero can be seen and counted as well.
const STUB_DECADES: f32 = 0.7;
/// Number of eigenvalues that are recorded; more only if k is larger.
const STORED: usize = 32;
/// Number of eigenvalues that are drawn; more of them would be too narrow to see.
const DRAWN: usize = 16;
/// Coordinates of the drawn embedding are multiples of this; its farthest point lies at 1.
const DRAWN_STEP: f64 = 1.0 / 128.0;
/// Width of a column of the chart, in decades.
const COLUMN: f32 = 1.6;
/// Right end of the chart.
const RIGHT: f32 = COLUMN * (DRAWN as f32 + 0.5);

/// Look of the entities, and the chart's axis.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static(SPECTRAL_EMBEDDING.path, &Points3D::update_fields().with_radii([ui(3.0)]))?;
    log_axes(rec)?;
    rec.log_static(SPECTRAL_EIGENVALUES.path, &BarChart::update_fields().with_color(color(ZEROS)))?;
    let words = Points2D::update_fields().with_radii([ui(0.0)]).with_colors([color(TOLERANCE)]).with_show_labels(true);
    rec.log_static(SPECTRAL_CHART.path, &words)?;
    rec.log_static(SPECTRAL_K.path, &series("k (zeros)", ZEROS, 2.0))?;
    rec.log_static(SPECTRAL_MARGIN.path, &series("margin [decades]", GREY, 1.5))?;
    let decades: Vec<i32> = (-16..=0).step_by(4).collect();
    let grid = LineStrips2D::new(decades.iter().map(|&d| [[0.0, -d as f32], [RIGHT, -d as f32]]))
        .with_radii([ui(0.5)])
        .with_colors([color(GRID)]);
    let numbered = [0, 3, 7, 11, 15];
    let marks = decades.iter().map(|&d| ([-1.8, -d as f32 - 1.0], format!("1e{d}")));
    let marks = words::words(marks.chain(numbered.map(|i| ([column_x(i), -FLOOR_DECADE], format!("λ{}", i + 1)))));
    rec.log_static(SPECTRAL_CHART_AXIS.path, &[&grid as &dyn AsComponents, &marks])
}

/// λ, τ, k and margin of one revolution.
pub(crate) fn log(rows: &mut Rows, frame: &Frame) {
    let spectrum = &frame.spectrum;
    let stored = &spectrum.eigenvalues[..spectrum.eigenvalues.len().min(STORED.max(spectrum.k + 1))];
    let exact = TensorData::new(vec![stored.len() as u64], TensorBuffer::F64(stored.to_vec().into()));
    rows.log_chart(&SPECTRAL_EIGENVALUES, exact);
    rows.log(&SPECTRAL_TOLERANCE, &Scalars::single(spectrum.tolerance));
    rows.log(&SPECTRAL_K, &Scalars::single(spectrum.k as f64));
    rows.log(&SPECTRAL_MARGIN, &Scalars::new(spectrum.margin_decades));
    log_chart(rows, spectrum);
}

/// U and the embedding of one revolution, the embedding drawn at `scale`.
pub(crate) fn log_embedding(rows: &mut Rows, frame: &Frame, classes: &Classes, scale: f64) {
    let spectrum = &frame.spectrum;
    let (n, k) = (spectrum.u.nrows(), spectrum.u.ncols());
    let exact = f16_matrix(rows_of(&spectrum.u), [n, k], SPECTRAL_U.dims);
    rows.log_tensor(&SPECTRAL_U, exact, &[]);
    let points = (0..n).map(|i| drawn_row(&spectrum.u, i, scale));
    rows.log(&SPECTRAL_EMBEDDING, &Points3D::new(points).with_class_ids(classes.of_rows().iter().take(n).copied()));
}

/// The factor that scales the farthest row of U to length 1 in drawings.
pub(crate) fn embedding_scale(u: &Mat<f64>) -> f64 {
    let norm = |i: usize| (0..u.ncols().min(3)).map(|j| u[(i, j)].powi(2)).sum::<f64>().sqrt();
    let farthest = (0..u.nrows()).map(norm).fold(0.0, f64::max);
    if farthest > 0.0 { farthest.recip() } else { 1.0 }
}

/// The first three columns of row `i`, or 0 for those that do not exist. They are rounded: equal points take less space.
pub(crate) fn drawn_row(rows: &Mat<f64>, i: usize, scale: f64) -> [f32; 3] {
    let drawn = |value: f64| ((value * scale / DRAWN_STEP).round() * DRAWN_STEP) as f32;
    std::array::from_fn(|j| if j < rows.ncols() { drawn(rows[(i, j)]) } else { 0.0 })
}

fn log_axes(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let tips = [[1.2f32, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 0.0, 1.2]];
    let axes = LineStrips3D::new(tips.map(|tip| [[0.0; 3], tip]))
        .with_radii([Radius::new_ui_points(0.75)])
        .with_colors([color(GREY)]);
    let names = Points3D::new(tips)
        .with_radii([Radius::new_ui_points(0.0)])
        .with_colors([color(WORDS)])
        .with_labels(["u1", "u2", "u3"])
        .with_show_labels(true);
    rec.log_static(SPECTRAL_AXES.path, &[&axes as &dyn AsComponents, &names])
}

/// A column for each eigenvalue on a logarithmic scale, the zeros in colour and a line after them, a line at τ, and the
/// inequality that k follows from.
fn log_chart(rows: &mut Rows, spectrum: &Spectrum) {
    let drawn = &spectrum.eigenvalues[..spectrum.eigenvalues.len().min(DRAWN)];
    let top = |value: f64| height(value).min(-FLOOR_DECADE - STUB_DECADES);
    let columns = drawn.iter().enumerate().map(|(i, &l)| {
        let color = color(if i < spectrum.k { ZEROS } else { GREY });
        ([[column_x(i), -FLOOR_DECADE], [column_x(i), top(l)]], color, Radius::new_scene_units(0.3 * COLUMN))
    });
    let (at, after_k) = (height(spectrum.tolerance), column_x(spectrum.k.min(DRAWN)) - 0.5 * COLUMN);
    let tolerance = ([[0.0, at], [RIGHT, at]], color(TOLERANCE), Radius::new_ui_points(1.5));
    let end_of_zeros = ([[after_k, -FLOOR_DECADE], [after_k, -1.0]], color(ZEROS), Radius::new_ui_points(0.75));
    let (lines, (colors, radii)): (Vec<_>, (Vec<_>, Vec<_>)) =
        columns.chain([tolerance, end_of_zeros]).map(|(line, color, radius)| (line, (color, radius))).unzip();
    let lines = LineStrips2D::new(lines).with_colors(colors).with_radii(radii);
    let verdict = format!("{}: k = {}", inequality(spectrum), spectrum.k);
    let words = [([0.5 * RIGHT, -3.4], verdict), ([RIGHT + 2.0, at - 1.0], format!("τ {:.0e}", spectrum.tolerance))];
    rows.log(&SPECTRAL_CHART, &[&lines as &dyn AsComponents, &labels(words)]);
}

fn labels(words: [([f32; 2], String); 2]) -> Points2D {
    let (at, words): (Vec<_>, Vec<_>) = words.into_iter().unzip();
    Points2D::new(at).with_labels(words)
}

fn column_x(i: usize) -> f32 {
    COLUMN * (i as f32 + 0.75)
}

/// Height of a value in the chart; 2D views have y downwards.
fn height(value: f64) -> f32 {
    -(value.abs().log10() as f32).clamp(FLOOR_DECADE, 2.0)
}

/// Left, top, right and bottom of the chart.
pub(crate) fn chart_bounds() -> [f64; 4] {
    [-5.5, -4.5, f64::from(RIGHT) + 5.0, f64::from(-FLOOR_DECADE) + 2.5]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_stand_on_the_floor_of_the_chart() {
        assert_eq!([height(0.0), height(1e-30)], [18.0; 2]);
        assert_eq!(height(-1e-16), 16.0);
        assert!(height(f64::NAN).is_nan());
    }
}
