//! A picture of what a setting does.

use crosscut_evaluate::chart::{Axis, COLOURS, Chart, page, text};

use super::grid::Grid;
use super::output::{Row, mean, total_ms};

const WIDTH_PX: f64 = 640.0;
const LEFT_PX: f64 = 70.0;
const RIGHT_PX: f64 = WIDTH_PX - 10.0;
const LANE_PX: f64 = 180.0;
/// From the bottom of a lane to the top of the next.
const BETWEEN_PX: f64 = 64.0;
const TOP_PX: f64 = 44.0;
const LEGEND_PX: f64 = 18.0;

/// What is drawn of each combination, from 0 to `top`.
struct Lane {
    name: &'static str,
    top: f64,
    value: fn(&Row<'_>) -> Option<f64>,
}

/// Right answers (or, without truth, sure ones) and time of the stages against the values of a key: a line for each
/// combination of the other keys, each point the mean over the flights.
pub(super) fn svg(grid: &Grid, place: usize, rows: &[Row<'_>]) -> String {
    let mut values: Vec<&String> = Vec::new();
    let mut others: Vec<Vec<&String>> = Vec::new();
    for point in &grid.points {
        let (value, other) = split(point, place);
        if !values.contains(&value) {
            values.push(value);
        }
        if !others.contains(&other) {
            others.push(other);
        }
    }
    let names =
        if others.len() > 1 { others.iter().map(|other| name(grid, place, other)).collect() } else { Vec::new() };
    let lanes = lanes(rows);
    let lanes_px = TOP_PX + lanes.len() as f64 * (LANE_PX + BETWEEN_PX);
    let mut document = page(WIDTH_PX, lanes_px + LEGEND_PX * names.len() as f64, 12.0);
    document = document.add(text(&grid.keys[place], [RIGHT_PX, 16.0], "end"));
    for (nth, lane) in lanes.iter().enumerate() {
        let top_px = TOP_PX + nth as f64 * (LANE_PX + BETWEEN_PX);
        let x = Axis::linear([0.0, values.len() as f64], [LEFT_PX, RIGHT_PX]);
        let mut chart = Chart::new(x, Axis::linear([0.0, lane.top], [top_px + LANE_PX, top_px]));
        values.iter().enumerate().for_each(|(at, value)| chart.x_tick(at as f64 + 0.5, value));
        for quarter in 0..=4 {
            let tick = 0.25 * f64::from(quarter) * lane.top;
            chart.y_tick(tick, &if lane.top >= 10.0 { format!("{tick:.0}") } else { format!("{tick:.2}") });
        }
        chart.add(text(lane.name, [4.0, top_px - 10.0], "start"));
        for (other, colour) in others.iter().zip(COLOURS.iter().cycle()) {
            let at = |(at, value): (usize, &&String)| {
                let is_of = |row: &&Row<'_>| split(row.point, place) == (*value, other.clone());
                mean(rows.iter().filter(is_of).map(lane.value)).map(|mean| [at as f64 + 0.5, mean])
            };
            let points: Vec<[f64; 2]> = values.iter().enumerate().filter_map(at).collect();
            chart.line(points.iter().copied(), colour, 1.5);
            chart.dots(points, colour, 6.0, 1.0);
        }
        document = document.add(chart);
    }
    for (nth, (name, colour)) in names.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let at_px = [LEFT_PX, lanes_px + LEGEND_PX * nth as f64 - 12.0];
        document = document.add(text(name, at_px, "start").set("fill", *colour));
    }
    document.to_string() + "\n"
}

fn lanes(rows: &[Row<'_>]) -> [Lane; 2] {
    let has_truth = rows.iter().any(|row| row.figure("right").is_some());
    let most_ms = rows.iter().filter_map(total_ms).fold(0.1, f64::max);
    let percent = if has_truth {
        Lane { name: "right, %", top: 100.0, value: |row| row.figure("right").map(|share| 100.0 * share) }
    } else {
        Lane { name: "sure, %", top: 100.0, value: |row| row.figure("sure").map(|share| 100.0 * share) }
    };
    [percent, Lane { name: "time of the stages, ms", top: 1.1 * most_ms, value: total_ms }]
}

/// The value of a key, and those of the others.
fn split(point: &[String], place: usize) -> (&String, Vec<&String>) {
    let others = point.iter().enumerate().filter(|(at, _)| *at != place);
    (&point[place], others.map(|(_, value)| value).collect())
}

fn name(grid: &Grid, place: usize, other: &[&String]) -> String {
    let keys = grid.keys.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, key)| key);
    keys.zip(other).map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(", ")
}
