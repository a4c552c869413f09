//! A picture of what a setting does.

use crosscut_evaluate::Proportion;
use crosscut_evaluate::chart::{Axis, COLOURS, Chart, line, page, text};

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
/// Values of a key that span this ratio at least stand on a logarithmic axis.
const LOGARITHMIC_FROM: f64 = 30.0;
/// Room at both ends of an axis of numbers, as a share of it.
const ROOM: f64 = 0.06;
/// Ticks between the ends of a lane, about.
const TICKS: f64 = 5.0;

/// What is drawn of each combination, from 0 to `top`.
struct Lane {
    name: &'static str,
    top: f64,
    value: fn(&Row<'_>) -> Option<f64>,
    /// Whether the value is a share of revolutions in percent, which has an interval.
    is_share: bool,
}

/// Where the values of a key stand on their axis: numbers by their size, words at equal distances.
struct Places {
    at: Vec<f64>,
    ends: [f64; 2],
}

impl Places {
    fn of(values: &[&String]) -> Self {
        let numbers: Option<Vec<f64>> =
            values.iter().map(|value| value.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let Some(numbers) = numbers.filter(|numbers| numbers.len() > 1) else {
            let at = (0..values.len()).map(|at| at as f64 + 0.5).collect();
            return Self { at, ends: [0.0, values.len() as f64] };
        };
        let ends = |at: &[f64]| {
            [at.iter().copied().fold(f64::INFINITY, f64::min), at.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
        };
        let [least, most] = ends(&numbers);
        let is_logarithmic = least > 0.0 && most / least >= LOGARITHMIC_FROM;
        let at: Vec<f64> = numbers.into_iter().map(|x| if is_logarithmic { x.log10() } else { x }).collect();
        let [from, to] = ends(&at);
        let room = ROOM * (to - from).max(f64::MIN_POSITIVE);
        Self { at, ends: [from - room, to + room] }
    }
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
    let (places, lanes) = (Places::of(&values), lanes(rows));
    let lanes_px = TOP_PX + lanes.len() as f64 * (LANE_PX + BETWEEN_PX);
    let mut document = page(WIDTH_PX, lanes_px + LEGEND_PX * names.len() as f64, 12.0);
    document = document.add(text(&grid.keys[place], [RIGHT_PX, 16.0], "end"));
    for (nth, lane) in lanes.iter().enumerate() {
        let top_px = TOP_PX + nth as f64 * (LANE_PX + BETWEEN_PX);
        let x = Axis::linear(places.ends, [LEFT_PX, RIGHT_PX]);
        let mut chart = Chart::new(x, Axis::linear([0.0, lane.top], [top_px + LANE_PX, top_px]));
        values.iter().zip(&places.at).for_each(|(value, at)| chart.x_tick(*at, value));
        let step = round_step(lane.top);
        for nth in 0..=(lane.top / step + 1e-9) as usize {
            let decimals = (-step.log10().floor()).max(0.0) as usize;
            chart.y_tick(nth as f64 * step, &format!("{:.decimals$}", nth as f64 * step));
        }
        chart.add(text(lane.name, [4.0, top_px - 10.0], "start"));
        for (other, colour) in others.iter().zip(COLOURS.iter().cycle()) {
            let of = |value: &String| {
                let is_of = |row: &&Row<'_>| split(row.point, place) == (value, other.clone());
                rows.iter().filter(is_of).collect::<Vec<_>>()
            };
            let shown = values.iter().zip(&places.at).map(|(value, at)| (of(value), *at));
            let mut points = Vec::new();
            for (rows, at) in shown {
                if lane.is_share
                    && let Some(ends) = interval(&rows, lane.value)
                {
                    let [from_px, to_px] = ends.map(|end| chart.px([at, end]));
                    chart.add(line(from_px, to_px, colour).set("stroke-opacity", 0.5).set("stroke-width", 3));
                }
                points.extend(mean(rows.iter().map(|row| (lane.value)(row))).map(|mean| [at, mean]));
            }
            points.sort_by(|a: &[f64; 2], b| a[0].total_cmp(&b[0]));
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
        Lane {
            name: "right, % (bars: 95 % interval)",
            top: 100.0,
            value: |row| row.figure("right").map(|share| 100.0 * share),
            is_share: true,
        }
    } else {
        Lane {
            name: "sure, % (bars: 95 % interval)",
            top: 100.0,
            value: |row| row.figure("sure").map(|share| 100.0 * share),
            is_share: true,
        }
    };
    [percent, Lane { name: "time of the stages, ms", top: 1.1 * most_ms, value: total_ms, is_share: false }]
}

/// Wilson's interval of a share in percent over the revolutions of several flights.
fn interval(rows: &[&Row<'_>], percent: fn(&Row<'_>) -> Option<f64>) -> Option<[f64; 2]> {
    let mut all = Proportion::default();
    for row in rows {
        let of = row.figure("compared").filter(|of| *of > 0.0).or(row.figure("revolutions"))?;
        all.merge(Proportion { hits: (0.01 * percent(row)? * of).round() as u64, of: of as u64 });
    }
    all.interval95().map(|ends| ends.map(|end| 100.0 * end))
}

/// The distance of about [`TICKS`] ticks from 0 to `top`: 1, 2 or 5 times a power of ten.
fn round_step(top: f64) -> f64 {
    let power = 10f64.powf((top / TICKS).log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|times| times * power).into_iter().find(|step| top / step <= TICKS + 1e-9).unwrap_or(top)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_by_their_size_and_words_apart_equally() {
        let places = |values: &[&str]| {
            let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
            Places::of(&values.iter().collect::<Vec<_>>()).at
        };
        assert_eq!(places(&["1", "2", "10"]), [1.0, 2.0, 10.0]);
        assert_eq!(places(&["0.01", "1", "100"]), [-2.0, 0.0, 2.0], "logarithms");
        assert_eq!(places(&["paper", "default"]), [0.5, 1.5]);
    }

    #[test]
    fn ticks_are_round() {
        let steps = [100.0, 0.38, 20.0, 7.0].map(round_step);
        for (step, expected) in steps.into_iter().zip([20.0, 0.1, 5.0, 2.0]) {
            assert!((step - expected).abs() < 1e-9, "{step} {expected}");
        }
    }
}
