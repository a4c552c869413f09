//! Largest zero and next eigenvalue of many scenes, on a logarithmic axis.

use crosscut_evaluate::chart::{Axis, COLOURS, Chart, INK, line, page, text};
use svg::node::element::Group;

/// The smallest exponent of ten on the axis; smaller eigenvalues, also 0, are drawn at the bottom.
const LEAST_EXPONENT: i32 = -18;
const COLUMN_PX: f64 = 56.0;
const LEFT_PX: f64 = 48.0;
const RIGHT_PX: f64 = 30.0;
const TOP_PX: f64 = 34.0;
const BOTTOM_PX: f64 = 322.0;
/// Zeros lie this far left of the middle of their column, next eigenvalues as far right; in columns.
const ASIDE: f64 = 0.2;
/// Dots are spread this far to either side, so that those of equal height can be told apart; in columns.
const SPREAD: f64 = 0.12;

/// The scenes of one kind.
pub(crate) struct Column {
    pub(crate) label: String,
    pub(crate) zeros: Vec<f64>,
    pub(crate) next: Vec<f64>,
}

/// Columns side by side, with the zero tolerance τ.
pub(crate) struct Panel {
    pub(crate) title: &'static str,
    pub(crate) columns: Vec<Column>,
    pub(crate) tolerance: f64,
}

impl Panel {
    fn right_px(&self) -> f64 {
        LEFT_PX + COLUMN_PX * self.columns.len() as f64
    }

    fn chart(&self) -> Chart {
        let (columns, right_px) = (self.columns.len() as f64, self.right_px());
        let x = Axis::linear([0.0, columns], [LEFT_PX, right_px]);
        let mut chart = Chart::new(x, Axis::powers_of_ten([LEAST_EXPONENT, 0], [BOTTOM_PX, TOP_PX]));
        chart.add(text(self.title, [0.5 * (LEFT_PX + right_px), 16.0], "middle"));
        for exponent in (LEAST_EXPONENT..=0).step_by(3) {
            let label = if exponent > LEAST_EXPONENT { format!("1e{exponent}") } else { "0".to_owned() };
            chart.y_tick(10f64.powi(exponent), &label);
        }
        let [from_px, to_px] = [[0.0, self.tolerance], [columns, self.tolerance]].map(|point| chart.px(point));
        chart.add(line(from_px, to_px, INK).set("stroke-dasharray", "5 3"));
        chart.add(text("τ", [right_px + 6.0, to_px[1] + 4.0], "start"));
        for (place, column) in self.columns.iter().enumerate() {
            let middle = place as f64 + 0.5;
            let [middle_px, _] = chart.px([middle, 1.0]);
            chart.add(text(&column.label, [middle_px, BOTTOM_PX + 18.0], "middle"));
            strip(&mut chart, &column.zeros, middle - ASIDE, COLOURS[0]);
            strip(&mut chart, &column.next, middle + ASIDE, COLOURS[1]);
        }
        chart
    }
}

/// A dot for each value, and a bar at the median.
fn strip(chart: &mut Chart, values: &[f64], at: f64, colour: &str) {
    let spread = |place: usize| SPREAD * (2.0 * (place as f64 * 0.618_034).fract() - 1.0);
    let dots = values.iter().enumerate().map(|(place, value)| [at + spread(place), value.abs()]);
    chart.dots(dots, colour, 3.0, 0.5);
    let mut sorted: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    if let Some(&median) = sorted.get(sorted.len() / 2) {
        chart.line([[at - SPREAD, median], [at + SPREAD, median]], INK, 1.5);
    }
}

/// Panels side by side, as SVG.
pub(crate) fn figure(panels: &[Panel]) -> String {
    let width_px = panels.iter().map(|panel| panel.right_px() + RIGHT_PX).sum();
    let (mut figure, mut x_px) = (page(width_px, BOTTOM_PX + 30.0, 12.0), 0.0);
    for panel in panels {
        figure = figure.add(Group::new().set("transform", format!("translate({x_px} 0)")).add(panel.chart()));
        x_px += panel.right_px() + RIGHT_PX;
    }
    figure.to_string() + "\n"
}
