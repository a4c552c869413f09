//! Charts as SVG: lines, dots and ticks over two axes.

use svg::Document;
use svg::node::Node;
use svg::node::element::{Group, Line, Path, Polyline, Rectangle, Text};

/// Lines and words.
pub const INK: &str = "#333333";
/// Lines of a grid.
pub const FAINT: &str = "#dddddd";
/// Colours that people with any colour vision can tell apart (Okabe and Ito).
pub const COLOURS: [&str; 6] = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"];

const GRID_TO_LABEL_PX: f64 = 6.0;

/// Maps values to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// The first and the last value that is shown; decimal logarithms of them on a logarithmic axis.
    ends: [f64; 2],
    ends_px: [f64; 2],
    is_logarithmic: bool,
}

impl Axis {
    /// An axis from one value to another, drawn from one pixel to another.
    pub fn linear(ends: [f64; 2], ends_px: [f64; 2]) -> Self {
        Self { ends, ends_px, is_logarithmic: false }
    }

    /// A logarithmic axis from one power of ten to another.
    pub fn powers_of_ten(exponents: [i32; 2], ends_px: [f64; 2]) -> Self {
        Self { ends: exponents.map(f64::from), ends_px, is_logarithmic: true }
    }

    /// The pixel of a value, to 0.1; values beyond the ends are drawn at the ends.
    pub fn px(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.log10() } else { value };
        let [from, to] = self.ends;
        let [from_px, to_px] = self.ends_px;
        let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
        (10.0 * (from_px + share * (to_px - from_px))).round() / 10.0
    }
}

/// What is drawn over two axes.
#[derive(Clone, Debug)]
pub struct Chart {
    x: Axis,
    y: Axis,
    drawn: Group,
}

impl Chart {
    /// Axes without anything.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self { x, y, drawn: Group::new() }
    }

    /// Pixels of a pair of values.
    pub fn px(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x.px(x), self.y.px(y)]
    }

    /// A line of the grid upwards from a value of the x axis, and its label.
    pub fn x_tick(&mut self, value: f64, label: &str) {
        let (x_px, [bottom_px, top_px]) = (self.x.px(value), self.y.ends_px);
        self.add(line([x_px, bottom_px], [x_px, top_px], FAINT));
        self.add(text(label, [x_px, bottom_px + 18.0], "middle"));
    }

    /// A line of the grid across from a value of the y axis, and its label.
    pub fn y_tick(&mut self, value: f64, label: &str) {
        let (y_px, [left_px, right_px]) = (self.y.px(value), self.x.ends_px);
        self.add(line([left_px, y_px], [right_px, y_px], FAINT));
        self.add(text(label, [left_px - GRID_TO_LABEL_PX, y_px + 4.0], "end"));
    }

    /// A line through points, in this order.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: &str, width_px: f64) {
        let corners = points.into_iter().map(|point| self.px(point)).map(|[x_px, y_px]| format!("{x_px},{y_px}"));
        let corners = corners.collect::<Vec<_>>().join(" ");
        let line = Polyline::new().set("points", corners).set("fill", "none");
        self.add(line.set("stroke", colour).set("stroke-width", width_px));
    }

    /// A dot at each point.
    pub fn dots(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: &str, width_px: f64, opacity: f64) {
        let places = points.into_iter().map(|point| self.px(point));
        // A line of no length with a round cap is a dot.
        let dots: String = places.map(|[x_px, y_px]| format!("M{x_px} {y_px}h0")).collect();
        let path = Path::new().set("d", dots).set("stroke", colour).set("stroke-width", width_px);
        self.add(path.set("stroke-linecap", "round").set("stroke-opacity", opacity));
    }

    /// Anything else, placed in pixels.
    pub fn add(&mut self, node: impl Into<Box<dyn Node>>) {
        self.drawn.append(node);
    }
}

impl From<Chart> for Box<dyn Node> {
    fn from(chart: Chart) -> Self {
        chart.drawn.into()
    }
}

/// A straight line.
pub fn line(from_px: [f64; 2], to_px: [f64; 2], colour: &str) -> Line {
    let line = Line::new().set("x1", from_px[0]).set("y1", from_px[1]).set("x2", to_px[0]).set("y2", to_px[1]);
    line.set("stroke", colour)
}

/// Words at a place, which is their `start`, `middle` or `end`.
pub fn text(words: &str, [x_px, y_px]: [f64; 2], anchor: &str) -> Text {
    Text::new(words).set("x", x_px).set("y", y_px).set("text-anchor", anchor).set("fill", INK)
}

/// A white page of this width and height in pixels, to add charts to.
pub fn page(width_px: f64, height_px: f64, font_size_px: f64) -> Document {
    Document::new()
        .set("viewBox", (0, 0, width_px, height_px))
        .set("width", width_px)
        .set("height", height_px)
        .set("font-family", "sans-serif")
        .set("font-size", font_size_px)
        .add(Rectangle::new().set("width", width_px).set("height", height_px).set("fill", "white"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_placed_by_their_logarithm_and_within_the_axis() {
        let axis = Axis::powers_of_ten([-18, 0], [218.0, 38.0]);
        assert_eq!([1e-9, 1.0, 1e-18].map(|value| axis.px(value)), [128.0, 38.0, 218.0]);
        assert_eq!([0.0, 1e3].map(|value| axis.px(value)), [218.0, 38.0], "beyond the ends");
        assert_eq!(Axis::linear([0.0, 3.0], [0.0, 100.0]).px(1.0), 33.3);
    }
}
