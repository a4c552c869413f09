//! Draws the place of the vehicle in one revolution of a simulated flight: `cargo run -p crosscut-flight --example here > here.svg`.

use std::error::Error;
use std::fmt::Write as _;

use crosscut_detector::{Preset, Settings};
use crosscut_flight::{Flight, FlightAnswer, HereKind, PARAMS};
use crosscut_sensor::Sensor;
use crosscut_simulator::scenarios;
use crosscut_stage::{Frame, Params};

const PIXELS_PER_M: f64 = 14.0;
const RADIUS_M: f64 = 22.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mine = scenarios().iter().find(|scenario| scenario.name == "mine").ok_or("no mine")?;
    let (sensor, mut engine) = (Sensor::default(), Settings::new(Preset::Default).engine()?);
    let mut flight = Flight::new(&Params::defaults(PARAMS), 0.6);
    let mut frame = Frame::default();
    for scene in (mine.fly)(1) {
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        engine.process(&mut frame)?;
        flight.add(&mut frame);
        // From a passage, the openings of the next junction are in view.
        let is_passage = FlightAnswer::of(&frame)
            .here
            .as_ref()
            .is_some_and(|here| here.kind == HereKind::Passage && here.confidence > 0.9);
        if is_passage && frame.junction.openings.len() >= 4 {
            #[allow(clippy::print_stdout)] // the picture is the output
            {
                print!("{}", draw(&frame)?);
            }
            return Ok(());
        }
    }
    Err("no such place on this flight".into())
}

fn draw(frame: &Frame) -> Result<String, Box<dyn Error>> {
    let here = FlightAnswer::of(frame).here.as_ref().ok_or("no place")?;
    let size = 2.0 * RADIUS_M * PIXELS_PER_M;
    let pixel = |x_m: f64, y_m: f64| ((RADIUS_M + x_m) * PIXELS_PER_M, (RADIUS_M - y_m) * PIXELS_PER_M);
    let along = |bearing_rad: f64, range_m: f64| pixel(range_m * bearing_rad.cos(), range_m * bearing_rad.sin());
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {size} {size}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{size}\" height=\"{size}\" fill=\"white\"/>\n"
    );
    for point in &frame.revolution.points_m {
        let (x, y) = pixel(point.x, point.y);
        writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"#555\"/>")?;
    }
    let (x, y) = pixel(0.0, 0.0);
    let look = here.look_m * PIXELS_PER_M;
    writeln!(
        svg,
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{look:.1}\" fill=\"#0072B2\" fill-opacity=\"0.08\" stroke=\"#0072B2\" stroke-dasharray=\"5 4\"/>"
    )?;
    for (index, opening) in frame.junction.openings.iter().enumerate() {
        let is_opening = here.ways.iter().any(|way| way.opening == Some(index));
        let color = if is_opening { "#D55E00" } else { "#999" };
        let [from, to] = opening.edge_m.map(|end| pixel(end.x, end.y));
        let (label_x, label_y) = along(opening.bearing_rad, 16.0);
        writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{color}\" stroke-width=\"4\" stroke-dasharray=\"2 3\"/>\n\
             <path d=\"M{x:.1} {y:.1}L{label_x:.1} {label_y:.1}\" stroke=\"{color}\" stroke-width=\"1.5\"/>\n\
             <text x=\"{label_x:.1}\" y=\"{label_y:.1}\" fill=\"{color}\">opening {index}</text>",
            from.0, from.1, to.0, to.1
        )?;
    }
    for way in &here.ways {
        let half_rad = (way.width_m / here.look_m / 2.0).clamp(-1.0, 1.0).asin();
        let [from, to] = [-half_rad, half_rad].map(|off_rad| along(way.bearing_rad + off_rad, here.look_m));
        writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}A{look:.1} {look:.1} 0 0 0 {:.1} {:.1}\" fill=\"none\" stroke=\"#0072B2\" stroke-width=\"5\"/>",
            from.0, from.1, to.0, to.1
        )?;
    }
    writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>")?;
    let text =
        format!("{}, {} of {} openings are its ways", here.kind.name(), here.ways.len(), frame.junction.openings.len());
    writeln!(svg, "<text x=\"12\" y=\"22\" font-size=\"16\">{text}</text>\n</svg>")?;
    Ok(svg)
}
