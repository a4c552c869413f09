//! Time against number of points, both logarithmic.

use svg::Document;
use svg::node::element::{Circle, Group, Line, Polyline, Rectangle, Text};

/// One curve: its name, and number of points and milliseconds of each measurement.
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) points: Vec<[f64; 2]>,
}

const COLOURS: [&str; 3] = ["#0072b2", "#e69f00", "#009e73"];
const INK: &str = "#333333";
/// Decades shown: of points, and of milliseconds.
const POINTS: [i32; 2] = [2, 5];
const MS: [i32; 2] = [-1, 3];
const DECADE: f64 = 120.0;
const MARGIN: f64 = 60.0;

impl Curve {
    /// a of the least-squares fit log ms = a·log n + c.
    pub(crate) fn exponent(&self) -> f64 {
        let n = self.points.len() as f64;
        let logs: Vec<[f64; 2]> = self.points.iter().map(|point| point.map(f64::ln)).collect();
        let mean = |axis: usize| logs.iter().map(|log| log[axis]).sum::<f64>() / n;
        let (x, y) = (mean(0), mean(1));
        let across: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
        across / logs.iter().map(|log| (log[0] - x).powi(2)).sum::<f64>()
    }

    /// Its first and last measurement alone.
    pub(crate) fn ends(&self) -> Self {
        let ends = self.points.first().into_iter().chain(self.points.last());
        Self { name: self.name, points: ends.copied().collect() }
    }
}

/// The figure.
pub(crate) fn svg(curves: &[Curve]) -> String {
    let width = DECADE * f64::from(POINTS[1] - POINTS[0]) + 4.0 * MARGIN;
    let height = DECADE * f64::from(MS[1] - MS[0]) + 2.0 * MARGIN;
    let mut document = Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "sans-serif")
        .set("font-size", 14)
        .set("fill", INK)
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", "white"))
        .add(axes());
    for (curve, colour) in curves.iter().zip(COLOURS) {
        document = document.add(drawn(curve, colour));
    }
    document.to_string() + "\n"
}

fn place([points, ms]: [f64; 2]) -> [f64; 2] {
    let x = MARGIN + DECADE * (points.log10() - f64::from(POINTS[0]));
    let y = MARGIN + DECADE * (f64::from(MS[1]) - ms.log10());
    [x, y]
}

fn axes() -> Group {
    let [left, bottom] = place([10f64.powi(POINTS[0]), 10f64.powi(MS[0])]);
    let [right, top] = place([10f64.powi(POINTS[1]), 10f64.powi(MS[1])]);
    let line = |from: [f64; 2], to: [f64; 2]| {
        let line = Line::new().set("x1", from[0]).set("y1", from[1]).set("x2", to[0]).set("y2", to[1]);
        line.set("stroke", "#dddddd")
    };
    let text = |x: f64, y: f64, anchor: &str, words: String| {
        Text::new(words).set("x", x).set("y", y).set("text-anchor", anchor)
    };
    let mut axes = Group::new();
    for decade in POINTS[0]..=POINTS[1] {
        let x = place([10f64.powi(decade), 1.0])[0];
        axes = axes.add(line([x, bottom], [x, top]));
        axes = axes.add(text(x, bottom + 20.0, "middle", 10f64.powi(decade).to_string()));
    }
    for decade in MS[0]..=MS[1] {
        let y = place([1.0, 10f64.powi(decade)])[1];
        axes = axes.add(line([left, y], [right, y]));
        axes = axes.add(text(left - 8.0, y + 5.0, "end", 10f64.powi(decade).to_string()));
    }
    let middle = 0.5 * (left + right);
    axes.add(text(middle, bottom + 42.0, "middle", "points".to_owned())).add(text(
        left - 8.0,
        top - 18.0,
        "start",
        "ms of processor time a revolution, preset default".to_owned(),
    ))
}

fn drawn(curve: &Curve, colour: &str) -> Group {
    let places: Vec<[f64; 2]> = curve.points.iter().map(|&point| place(point)).collect();
    let corners: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let line = Polyline::new().set("points", corners.join(" ")).set("fill", "none").set("stroke-width", 2);
    let mut group = Group::new().set("stroke", colour).add(line);
    for [x, y] in &places {
        group = group.add(Circle::new().set("cx", *x).set("cy", *y).set("r", 3.5).set("fill", colour));
    }
    let Some([x, y]) = places.last() else { return group };
    let name = Text::new(format!("{} n^{:.2}", curve.name, curve.exponent()));
    group.add(name.set("x", x + 10.0).set("y", y + 5.0).set("fill", colour).set("stroke", "none"))
}
