//! Time against number of points, both on logarithmic axes.

use crosscut_evaluate::chart::{Axis, COLOURS, Chart, page, text};

/// One curve: its name, and number of points and milliseconds of each measurement.
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) points: Vec<[f64; 2]>,
}

/// Powers of ten on the axes: of points, and of milliseconds.
const POINTS: [i32; 2] = [2, 5];
const MS: [i32; 2] = [-1, 3];

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

    /// The curve through its first and last measurement only.
    pub(crate) fn ends(&self) -> Self {
        let ends = self.points.first().into_iter().chain(self.points.last());
        Self { name: self.name, points: ends.copied().collect() }
    }
}

/// The figure, as SVG.
pub(crate) fn svg(curves: &[Curve]) -> String {
    let (x, y) = (Axis::powers_of_ten(POINTS, [60.0, 420.0]), Axis::powers_of_ten(MS, [540.0, 60.0]));
    let mut chart = Chart::new(x, y);
    for exponent in POINTS[0]..=POINTS[1] {
        let points = 10f64.powi(exponent);
        chart.x_tick(points, &points.to_string());
    }
    for exponent in MS[0]..=MS[1] {
        let ms = 10f64.powi(exponent);
        chart.y_tick(ms, &ms.to_string());
    }
    chart.add(text("points", [240.0, 582.0], "middle"));
    chart.add(text("ms of processor time a revolution, preset default", [52.0, 42.0], "start"));
    for (curve, colour) in curves.iter().zip(COLOURS) {
        chart.line(curve.points.iter().copied(), colour, 2.0);
        chart.dots(curve.points.iter().copied(), colour, 7.0, 1.0);
        if let Some(&last) = curve.points.last() {
            let [x_px, y_px] = chart.px(last);
            let name = format!("{} n^{:.2}", curve.name, curve.exponent());
            chart.add(text(&name, [x_px + 10.0, y_px + 5.0], "start").set("fill", colour));
        }
    }
    page(600.0, 600.0, 14.0).add(chart).to_string() + "\n"
}
