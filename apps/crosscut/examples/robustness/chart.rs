//! Eigenvalues on a logarithmic scale, as SVG.

use svg::Document;
use svg::node::element::{Group, Line, Path, Rectangle, Text};

/// Decades from top to bottom; what is smaller, 0 too, is drawn at the bottom.
const DECADES: f64 = 18.0;
const DECADE_PX: f64 = 16.0;
const COLUMN_PX: f64 = 56.0;
const LEFT_PX: f64 = 48.0;
const TOP_PX: f64 = 34.0;
const BOTTOM_PX: f64 = 30.0;
const GAP_PX: f64 = 30.0;
/// Zeros and next eigenvalues stand side by side.
const ASIDE_PX: f64 = 11.0;
/// Dots are strewn so that those of equal height can be told apart.
const STREWN_PX: f64 = 7.0;
/// Okabe and Ito's blue and orange.
const ZEROS: &str = "#0072b2";
const NEXT: &str = "#e69f00";
const INK: &str = "#333333";

/// Scenes of one kind.
pub(crate) struct Column {
    pub(crate) label: String,
    pub(crate) zeros: Vec<f64>,
    pub(crate) next: Vec<f64>,
}

pub(crate) struct Chart {
    pub(crate) title: &'static str,
    pub(crate) columns: Vec<Column>,
    pub(crate) tolerance: f64,
}

impl Chart {
    fn width_px(&self) -> f64 {
        LEFT_PX + COLUMN_PX * self.columns.len() as f64 + GAP_PX
    }

    fn drawn(&self) -> Group {
        let (right_px, bottom_px) = (LEFT_PX + COLUMN_PX * self.columns.len() as f64, TOP_PX + DECADES * DECADE_PX);
        let mut group = Group::new().add(text(self.title, 0.5 * (LEFT_PX + right_px), 16.0, "middle"));
        for exponent in (0..=DECADES as i32).step_by(3) {
            let y_px = TOP_PX + f64::from(exponent) * DECADE_PX;
            let label = if f64::from(exponent) < DECADES { format!("1e-{exponent}") } else { "0".to_owned() };
            group = group.add(line([LEFT_PX, y_px], [right_px, y_px]).set("stroke", "#dddddd"));
            group = group.add(text(&label, LEFT_PX - 6.0, y_px + 4.0, "end"));
        }
        let tau_px = y_px(self.tolerance);
        let tau = line([LEFT_PX, tau_px], [right_px, tau_px]).set("stroke", INK).set("stroke-dasharray", "5 3");
        group = group.add(tau).add(text("τ", right_px + 6.0, tau_px + 4.0, "start"));
        for (place, column) in self.columns.iter().enumerate() {
            let x_px = LEFT_PX + (place as f64 + 0.5) * COLUMN_PX;
            group = group
                .add(text(&column.label, x_px, bottom_px + 18.0, "middle"))
                .add(dots(&column.zeros, x_px - ASIDE_PX, ZEROS))
                .add(dots(&column.next, x_px + ASIDE_PX, NEXT));
        }
        group
    }
}

/// A dot for each value, and a bar at the median.
fn dots(values: &[f64], x_px: f64, colour: &str) -> Group {
    let strewn = |at: usize| STREWN_PX * (2.0 * (at as f64 * 0.618_034).fract() - 1.0);
    // A line of no length with a round cap is a dot.
    let dot = |(at, &value): (usize, &f64)| format!("M{:.1} {:.1}h0", x_px + strewn(at), y_px(value));
    let dots: String = values.iter().enumerate().map(dot).collect();
    let path = Path::new().set("d", dots).set("stroke", colour).set("stroke-width", 3).set("stroke-opacity", 0.5);
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let group = Group::new().set("stroke-linecap", "round").set("fill", "none").add(path);
    let Some(&median) = sorted.get(sorted.len() / 2) else { return group };
    let (from_px, to_px) = ([x_px - STREWN_PX, y_px(median)], [x_px + STREWN_PX, y_px(median)]);
    group.add(line(from_px, to_px).set("stroke", INK).set("stroke-width", 1.5))
}

fn y_px(value: f64) -> f64 {
    TOP_PX - DECADE_PX * value.abs().log10().clamp(-DECADES, 0.0)
}

fn line(from_px: [f64; 2], to_px: [f64; 2]) -> Line {
    Line::new().set("x1", from_px[0]).set("y1", from_px[1]).set("x2", to_px[0]).set("y2", to_px[1])
}

fn text(words: &str, x_px: f64, y_px: f64, anchor: &str) -> Text {
    Text::new(words).set("x", x_px).set("y", y_px).set("text-anchor", anchor).set("fill", INK)
}

/// Charts side by side.
pub(crate) fn figure(charts: &[Chart]) -> String {
    let width_px: f64 = charts.iter().map(Chart::width_px).sum();
    let height_px = TOP_PX + DECADES * DECADE_PX + BOTTOM_PX;
    let mut document = Document::new()
        .set("viewBox", (0, 0, width_px, height_px))
        .set("width", width_px)
        .set("height", height_px)
        .set("font-family", "sans-serif")
        .set("font-size", 12)
        .add(Rectangle::new().set("width", width_px).set("height", height_px).set("fill", "white"));
    let mut x_px = 0.0;
    for chart in charts {
        document = document.add(chart.drawn().set("transform", format!("translate({x_px} 0)")));
        x_px += chart.width_px();
    }
    document.to_string() + "\n"
}
