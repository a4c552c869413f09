//! Draws the doubt of the pose along a smooth tunnel: `cargo run --release -p crosscut-flight --example doubt > doubt.svg`.
//!
//! A tunnel 120 m long and 4 m wide with two side ways, flown once with odometry that is 2 % too long, and once without. Where no
//! side way is in view, nothing that the walls show tells how far along the tunnel the vehicle is.

use std::error::Error;
use std::fmt::Write as _;

use crosscut_detector::{Preset, Settings};
use crosscut_flight::{Flight, FlightAnswer, PARAMS};
use crosscut_sensor::Sensor;
use crosscut_simulator::Plan;
use crosscut_stage::{Frame, Params};
use nalgebra::Isometry2;

const PLAN: &str = r#"{"nodes":[{"id":0,"x_m":0,"y_m":0},{"id":1,"x_m":40,"y_m":0},{"id":2,"x_m":80,"y_m":0},{"id":3,"x_m":120,"y_m":0},
    {"id":4,"x_m":40,"y_m":15},{"id":5,"x_m":80,"y_m":15}],
    "edges":[{"from":0,"to":1,"width_m":4},{"from":1,"to":2,"width_m":4},{"from":2,"to":3,"width_m":4},
    {"from":1,"to":4,"width_m":4},{"from":2,"to":5,"width_m":4}],"roughness_m":0}"#;

/// How much too long the odometry is.
const TOO_LONG: f64 = 1.02;

/// The side ways, metres from the beginning.
const SIDE_WAYS_M: [f64; 2] = [40.0, 80.0];
const LENGTH_M: f64 = 120.0;

const PIXELS_PER_M: f64 = 7.0;
const PIXELS_PER_DOUBT_M: f64 = 70.0;
const MOST_DOUBT_M: f64 = 3.0;
const LEFT: f64 = 60.0;
const TUNNEL_Y: f64 = 60.0;
const ZERO_Y: f64 = 320.0;

/// At a place along the tunnel: the doubt that the pose has, and how far it is off, metres.
struct At {
    x_m: f64,
    sd_m: Option<f64>,
    off_m: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let flights = [("with odometry", "#0072B2", fly(true)?), ("by scans alone", "#D55E00", fly(false)?)];
    #[allow(clippy::print_stdout)] // the picture is the output
    {
        print!("{}", draw(&flights)?);
    }
    Ok(())
}

/// The first pass of the tunnel, from end to end.
fn fly(has_odometry: bool) -> Result<Vec<At>, Box<dyn Error>> {
    let (sensor, mut engine) = (Sensor::default(), Settings::new(Preset::Default).engine()?);
    let mut flight = Flight::new(&Params::defaults(PARAMS), 0.6);
    let (mut frame, mut along, mut first) = (Frame::default(), Vec::new(), None);
    for scene in Plan::from_json(PLAN)?.fly(1)? {
        let pose = scene.pose.ok_or("a flight has poses")?;
        let pose = Isometry2::new(pose.position_m.coords, pose.heading_rad);
        let first = *first.get_or_insert(pose);
        let moved = first.inv_mul(&pose);
        let odometry = Isometry2::new(moved.translation.vector * TOO_LONG, moved.rotation.angle());
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        frame.revolution.odometry = has_odometry.then_some(odometry);
        engine.process(&mut frame)?;
        flight.add(&mut frame);
        let of = FlightAnswer::of(&frame);
        let found = of.pose.ok_or("scans have poses")?.translation.vector;
        let sd_m = of.doubt.and_then(|doubt| doubt.from_start_sd_m(found.into()));
        let farthest_m = along.iter().map(|at: &At| at.x_m).fold(0.0, f64::max);
        let is_back = pose.translation.x < farthest_m - 0.3;
        if is_back || pose.translation.y.abs() > 3.0 {
            break;
        }
        along.push(At { x_m: pose.translation.x, sd_m, off_m: (found - moved.translation.vector).norm() });
    }
    Ok(along)
}

fn draw(flights: &[(&str, &str, Vec<At>)]) -> Result<String, Box<dyn Error>> {
    let x = |x_m: f64| LEFT + x_m * PIXELS_PER_M;
    let y = |doubt_m: f64| ZERO_Y - doubt_m.min(MOST_DOUBT_M) * PIXELS_PER_DOUBT_M;
    let (width, height) = (x(LENGTH_M) + 30.0, ZERO_Y + 80.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"14\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let (half, side) = (2.0 * PIXELS_PER_M, 5.0 * PIXELS_PER_M);
    writeln!(svg, "<g stroke=\"#555\" stroke-width=\"2\" fill=\"none\">")?;
    let mut upper = format!("M{:.1} {:.1}V{:.1}", x(0.0), TUNNEL_Y + half, TUNNEL_Y - half);
    for side_m in SIDE_WAYS_M {
        let [from, to] = [side_m - 2.0, side_m + 2.0].map(x);
        write!(upper, "H{from:.1}V{:.1}M{to:.1} {:.1}V{:.1}", TUNNEL_Y - side, TUNNEL_Y - side, TUNNEL_Y - half)?;
    }
    writeln!(svg, "<path d=\"{upper}H{:.1}V{:.1}H{:.1}\"/></g>", x(LENGTH_M), TUNNEL_Y + half, x(0.0))?;
    for doubt_m in [0.0, 1.0, 2.0, 3.0] {
        writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}H{:.1}\" stroke=\"#ccc\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{doubt_m} m</text>",
            x(0.0),
            y(doubt_m),
            x(LENGTH_M),
            x(0.0) - 8.0,
            y(doubt_m) + 5.0
        )?;
    }
    for place_m in [0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0] {
        writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{place_m} m</text>",
            x(place_m),
            ZERO_Y + 20.0
        )?;
    }
    for (row, (name, color, along)) in flights.iter().enumerate() {
        let line = |value_m: &dyn Fn(&At) -> Option<f64>| {
            let mut is_down = false;
            let mut path = String::new();
            for at in along {
                let Some(value_m) = value_m(at) else {
                    is_down = false;
                    continue;
                };
                let pen = if std::mem::replace(&mut is_down, true) { 'L' } else { 'M' };
                path.push_str(&format!("{pen}{:.1} {:.1}", x(at.x_m), y(value_m)));
            }
            path
        };
        writeln!(svg, "<path d=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"3\"/>", line(&|at| at.sd_m))?;
        let off = line(&|at| Some(at.off_m));
        writeln!(
            svg,
            "<path d=\"{off}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\" stroke-dasharray=\"2 4\"/>"
        )?;
        if let Some(unknown) = along.iter().find(|at| at.sd_m.is_none()) {
            let (at_x, at_y) = (x(unknown.x_m), y(2.0) - 12.0);
            writeln!(svg, "<text x=\"{at_x:.1}\" y=\"{at_y:.1}\" fill=\"{color}\">null from here on</text>")?;
        }
        let legend_y = ZERO_Y + 45.0 + 20.0 * row as f64;
        writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{legend_y:.1}\" fill=\"{color}\">{name}: sd_m; dotted: how far the pose is off (3 m and more: at the top)</text>",
            x(0.0)
        )?;
    }
    writeln!(svg, "</svg>")?;
    Ok(svg)
}
