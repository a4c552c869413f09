//! The flight as a picture: a lane for the count, one for the margin, one for the confidence.

use crosscut_evaluate::Flip;
use crosscut_evaluate::chart::{Axis, COLOURS, Chart, INK, page, text};
use svg::node::element::{Circle, Title};

use super::{Course, Moment};

/// Colour of the dots at flips.
const FLIP: &str = COLOURS[3];

const LEFT_PX: f64 = 150.0;
/// Width of a lane. Where there are more revolutions than pixels, several share a column.
const LANE_COLUMNS: usize = 1000;
const RIGHT_PX: f64 = LEFT_PX + LANE_COLUMNS as f64;
const TOP_PX: f64 = 20.0;
const LANE_PX: f64 = 90.0;
const BETWEEN_PX: f64 = 14.0;
/// Space for the ticks and at the right end.
const MARGIN_PX: f64 = 24.0;
/// Margins above this many decades are drawn at the top.
const MARGIN_DECADES: f64 = 5.0;
/// The distance between ticks is one of these times a power of ten.
const TICK_STEPS: [usize; 3] = [1, 2, 5];
const MOST_TICKS: usize = 12;

/// A value of each revolution, drawn from 0 to `top`.
struct Lane {
    name: &'static str,
    top: f64,
    colour: &'static str,
    values: Vec<f64>,
}

pub(super) fn svg(flight: &Course, flips: &[Flip]) -> String {
    let lanes = lanes(&flight.moments);
    let height_px = TOP_PX + lanes.len() as f64 * (LANE_PX + BETWEEN_PX) - BETWEEN_PX + MARGIN_PX;
    let mut picture = page(RIGHT_PX + MARGIN_PX, height_px, 12.0);
    for (place, lane) in lanes.iter().enumerate() {
        let mut chart = chart(lane, TOP_PX + place as f64 * (LANE_PX + BETWEEN_PX));
        for at in ticks(flight.moments.len()) {
            let label = flight.moments[at].seq.to_string();
            chart.x_tick(at as f64, if place + 1 == lanes.len() { &label } else { "" });
        }
        chart.line(steps(&lane.values), lane.colour, 1.0);
        if place == 0 {
            flips.iter().for_each(|flip| mark(&mut chart, flight, flip));
        }
        picture = picture.add(chart);
    }
    picture.add(text("revolution", [4.0, height_px - 6.0], "start")).to_string() + "\n"
}

fn lanes(moments: &[Moment]) -> [Lane; 3] {
    let values = |of: fn(&Moment) -> f64| moments.iter().map(of).collect::<Vec<f64>>();
    let walls = values(|moment| moment.junctions as f64);
    let most = walls.iter().copied().fold(1.0, f64::max);
    let margins = values(|moment| moment.margin.unwrap_or(0.0));
    [
        Lane { name: "walls", top: most + 0.5, colour: INK, values: walls },
        Lane { name: "margin, decades", top: MARGIN_DECADES, colour: COLOURS[0], values: margins },
        Lane {
            name: "confidence",
            top: 1.0,
            colour: COLOURS[2],
            values: values(|moment| moment.confidence.unwrap_or(0.0)),
        },
    ]
}

/// The axes of a lane, with its name and a tick at every whole number.
fn chart(lane: &Lane, top_px: f64) -> Chart {
    let bottom_px = top_px + LANE_PX;
    let x = Axis::linear([0.0, lane.values.len() as f64], [LEFT_PX, RIGHT_PX]);
    let mut chart = Chart::new(x, Axis::linear([0.0, lane.top], [bottom_px, top_px]));
    chart.add(text(lane.name, [4.0, 0.5 * (top_px + bottom_px) + 4.0], "start"));
    for value in 0..=lane.top as usize {
        chart.y_tick(value as f64, &value.to_string());
    }
    chart
}

/// The corners of a line that is level over each revolution. Where revolutions share a column, it spans their values.
fn steps(values: &[f64]) -> impl Iterator<Item = [f64; 2]> {
    let together = values.len().div_ceil(LANE_COLUMNS).max(1);
    values.chunks(together).enumerate().flat_map(move |(column, values)| {
        let (from, to) = (column * together, column * together + values.len());
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [[from as f64, least], [from as f64, most], [to as f64, most]]
    })
}

/// A dot on the count of a flip. Its reason appears when one points at it.
fn mark(walls: &mut Chart, flight: &Course, flip: &Flip) {
    let seq = flight.moments[flip.at].seq;
    let reason = format!("{seq}: {} walls, {} around it; {}", flip.junctions, flip.around, flight.reason(flip));
    let [x_px, y_px] = walls.px([flip.at as f64 + 0.5, flip.junctions as f64]);
    walls.add(Circle::new().set("cx", x_px).set("cy", y_px).set("r", 3).set("fill", FLIP).add(Title::new(reason)));
}

/// Revolutions at round distances from the first.
fn ticks(n: usize) -> impl Iterator<Item = usize> {
    let steps = (0..).flat_map(|power| TICK_STEPS.map(|step| step * 10usize.pow(power)));
    let step = steps.take_while(|step| *step <= n.max(1)).find(|step| n / step <= MOST_TICKS).unwrap_or(n.max(1));
    (0..n).step_by(step)
}
