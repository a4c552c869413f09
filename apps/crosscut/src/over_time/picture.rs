//! The flight as a picture: a lane for the count, one for the margin, one for the confidence.

use crosscut_evaluate::Flip;
use svg::Document;
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Text, Title};

use super::{Moment, OverTime};

const INK: &str = "#333333";
const FAINT: &str = "#dddddd";
const FLIP: &str = "#d55e00";

/// Pixels. More revolutions than there are columns share them.
const COLUMNS: usize = 1000;
const LEFT: f64 = 80.0;
const TOP: f64 = 20.0;
const LANE: f64 = 90.0;
const BETWEEN: f64 = 14.0;
const BELOW: f64 = 24.0;
const RIGHT: f64 = 20.0;
/// Margins are drawn up to so many decades.
const MARGIN_DECADES: f64 = 5.0;
/// The revolutions at which there is a tick are so many times a power of ten apart.
const TICK_STEPS: [usize; 3] = [1, 2, 5];
const MOST_TICKS: usize = 12;

/// What one lane shows, from 0 to `top`.
struct Lane {
    name: &'static str,
    top: f64,
    colour: &'static str,
    values: Vec<f64>,
}

pub(super) fn svg(flight: &OverTime, flips: &[Flip]) -> String {
    let lanes = lanes(&flight.moments);
    let bottom = TOP + lanes.len() as f64 * (LANE + BETWEEN) - BETWEEN;
    let (width, height) = (LEFT + COLUMNS as f64 + RIGHT, bottom + BELOW);
    let mut document = Document::new()
        .set("viewBox", (0, 0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "sans-serif")
        .set("font-size", 12)
        .set("fill", INK)
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", "white"));
    let n = flight.moments.len();
    for at in ticks(n) {
        let x = x_of(at, n);
        let line = Line::new().set("x1", x).set("x2", x).set("y1", TOP).set("y2", bottom).set("stroke", FAINT);
        let seq = flight.moments[at].seq;
        document = document
            .add(line)
            .add(Text::new(seq.to_string()).set("x", x).set("y", bottom + 16.0).set("text-anchor", "middle"));
    }
    document = document.add(Text::new("revolution").set("x", 4).set("y", bottom + 16.0));
    for (place, lane) in lanes.iter().enumerate() {
        let y = TOP + place as f64 * (LANE + BETWEEN);
        document = document.add(drawn(lane).set("transform", format!("translate(0 {y})")));
    }
    for flip in flips {
        document = document.add(dot(flight, flip, &lanes[0]));
    }
    document.to_string() + "\n"
}

fn lanes(moments: &[Moment]) -> [Lane; 3] {
    let values = |of: fn(&Moment) -> f64| moments.iter().map(of).collect::<Vec<f64>>();
    let walls = values(|moment| moment.junctions as f64);
    let most = walls.iter().copied().fold(1.0, f64::max);
    let margins = values(|moment| moment.margin.unwrap_or(0.0).clamp(0.0, MARGIN_DECADES));
    [
        Lane { name: "walls", top: most + 0.5, colour: INK, values: walls },
        Lane { name: "margin", top: MARGIN_DECADES, colour: "#0072b2", values: margins },
        Lane { name: "confidence", top: 1.0, colour: "#009e73", values: values(|moment| moment.confidence) },
    ]
}

/// Where a revolution begins.
fn x_of(at: usize, n: usize) -> f64 {
    LEFT + (at as f64 / n.max(1) as f64) * COLUMNS as f64
}

fn y_of(lane: &Lane, value: f64) -> f64 {
    LANE * (1.0 - value / lane.top)
}

/// Steps; where revolutions share a column, from the least of them to the most.
fn drawn(lane: &Lane) -> Group {
    let n = lane.values.len();
    let mut path = String::new();
    let together = n.div_ceil(COLUMNS).max(1);
    for (column, values) in lane.values.chunks(together).enumerate() {
        let first = column * together;
        let least = y_of(lane, values.iter().copied().fold(f64::INFINITY, f64::min));
        let most = y_of(lane, values.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        let from = if path.is_empty() { 'M' } else { 'L' };
        path += &format!("{from}{:.1} {least:.1}V{most:.1}H{:.1}", x_of(first, n), x_of(first + values.len(), n));
    }
    let frame = Rectangle::new()
        .set("x", LEFT)
        .set("width", COLUMNS)
        .set("height", LANE)
        .set("fill", "none")
        .set("stroke", FAINT);
    let mut group = Group::new().add(frame).add(Text::new(lane.name).set("x", 4).set("y", 0.5 * LANE + 4.0));
    for value in (0..=lane.top as usize).map(|value| value as f64) {
        let label = Text::new(value.to_string())
            .set("x", LEFT - 6.0)
            .set("y", y_of(lane, value) + 4.0)
            .set("text-anchor", "end");
        group = group.add(label);
    }
    group.add(Path::new().set("d", path).set("fill", "none").set("stroke", lane.colour))
}

/// On the count of a flip, with the reason for those who point at it.
fn dot(flight: &OverTime, flip: &Flip, walls: &Lane) -> Circle {
    let moment = &flight.moments[flip.at];
    let n = flight.moments.len();
    let why = format!("{}: {} walls, {} around it; {}", moment.seq, flip.junctions, flip.around, flight.reason(flip));
    Circle::new()
        .set("cx", format!("{:.1}", 0.5 * (x_of(flip.at, n) + x_of(flip.at + 1, n))))
        .set("cy", format!("{:.1}", TOP + y_of(walls, flip.junctions as f64)))
        .set("r", 3)
        .set("fill", FLIP)
        .add(Title::new(why))
}

/// Revolutions at round distances from the first.
fn ticks(n: usize) -> impl Iterator<Item = usize> {
    let steps = (0..).flat_map(|power| TICK_STEPS.map(|step| step * 10usize.pow(power)));
    let step = steps.take_while(|step| *step <= n.max(1)).find(|step| n / step <= MOST_TICKS).unwrap_or(n.max(1));
    (0..n).step_by(step)
}
