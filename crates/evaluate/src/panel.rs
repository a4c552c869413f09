//! Figures as SVG: scans seen from above, with a colour for each wall, the openings, and a title.

use std::collections::BTreeSet;

use crosscut_messages::Truth;
use crosscut_report::openings::LOOKOUT_M;
use crosscut_stage::{Beam, Frame, Revolution};
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Text};

use crate::chart::{INK, page};

/// Colours of walls (Okabe and Ito, the yellow darker than theirs), in the order of recordings for the viewer; repeated when
/// there are more walls.
const WALLS_RGB: [[u8; 3]; 5] =
    [[0x56, 0xb4, 0xe9], [0xe6, 0x9f, 0x00], [0x00, 0x9e, 0x73], [0xd5, 0x5e, 0x00], [0xd6, 0xc7, 0x13]];
/// Colour of the returns of no wall.
const NO_WALL: &str = "#8c8c8c";

/// Half the side of a panel, in units of the figure. A unit is a metre unless the returns lie farther away or nearer.
const HALF_M: f64 = 16.0;
const MARGIN_M: f64 = 1.0;
/// At least this share of the returns is drawn; outliers beyond may be outside the panel.
const SHOWN_SHARE: f64 = 0.98;
/// The most units that a metre takes: the marks of openings, 8 m away, stay inside.
const MOST_UNITS_PER_M: f64 = 1.8;
/// Length of the scale.
const BAR_M: f64 = 5.0;
const TITLE_M: f64 = 3.0;
/// Size of a panel with its title and the space between panels.
const WIDTH_M: f64 = 2.0 * HALF_M + 1.0;
const HEIGHT_M: f64 = 2.0 * HALF_M + TITLE_M + 1.0;
const PIXELS_PER_M: f64 = 6.0;

/// One scan in a square. The vehicle is in the middle and faces up.
pub struct Panel {
    title: String,
    /// Positions of the returns, forward and left of the vehicle.
    returns_m: Vec<[f64; 2]>,
    wall_of_return: Vec<Option<u32>>,
    /// Bearing (rad) and width (m) of each opening.
    openings: Vec<[f64; 2]>,
}

impl Panel {
    /// Shows the true walls and openings.
    pub fn of_truth(title: String, revolution: &Revolution, truth: &Truth) -> Self {
        let mut wall_of_return = vec![None; revolution.len()];
        let beams = revolution.sweep.iter().flat_map(|sweep| &sweep.beams);
        for (beam, &label) in beams.zip(&truth.labels) {
            if let Beam::Return(i) = *beam {
                wall_of_return[i as usize] = u32::try_from(label).ok();
            }
        }
        let openings = truth.openings.iter().map(|opening| [opening.bearing_rad, opening.width_m]).collect();
        Self { title, returns_m: positions(revolution), wall_of_return, openings }
    }

    /// Shows the walls and openings of a result.
    pub fn of_answer(title: String, frame: &Frame) -> Self {
        let openings = frame.junction.openings.iter().map(|opening| [opening.bearing_rad, opening.width_m]).collect();
        let wall_of_return = frame.junction.wall_of_return.clone();
        Self { title, returns_m: positions(&frame.revolution), wall_of_return, openings }
    }

    /// Draws the panel with its vehicle at the origin.
    fn drawn(&self) -> Group {
        let frame = Rectangle::new()
            .set("x", -HALF_M)
            .set("y", -HALF_M)
            .set("width", 2.0 * HALF_M)
            .set("height", 2.0 * HALF_M)
            .set("fill", "white")
            .set("stroke", "#cccccc")
            .set("stroke-width", 0.1);
        let title = Text::new(self.title.as_str())
            .set("x", 0)
            .set("y", -HALF_M - 0.25 * TITLE_M)
            .set("text-anchor", "middle")
            .set("fill", INK);
        let units_per_m = self.units_per_m();
        let scaled = Group::new().set("transform", format!("scale({units_per_m:.3})"));
        let scene = self.scene(scaled, HALF_M / units_per_m);
        Group::new().add(frame).add(title).add(scene).add(scale(units_per_m))
    }

    /// Adds openings, walls and the vehicle to a group, up to `half_m` to each side.
    fn scene(&self, mut group: Group, half_m: f64) -> Group {
        for opening in &self.openings {
            group = group.add(opening_mark(*opening));
        }
        for path in self.walls(half_m) {
            group = group.add(path);
        }
        let vehicle = Circle::new().set("r", 0.35).set("fill", INK);
        let nose = Line::new().set("y2", -1.2).set("stroke", INK).set("stroke-width", 0.2);
        group.add(vehicle).add(nose)
    }

    /// As many as leave [`SHOWN_SHARE`] of the returns inside the panel.
    fn units_per_m(&self) -> f64 {
        let mut reach_m: Vec<f64> = self.returns_m.iter().map(|[x_m, y_m]| x_m.abs().max(y_m.abs())).collect();
        reach_m.sort_by(f64::total_cmp);
        let last_shown = (SHOWN_SHARE * reach_m.len() as f64) as usize;
        reach_m.get(last_shown).map_or(1.0, |reach_m| ((HALF_M - MARGIN_M) / reach_m).min(MOST_UNITS_PER_M))
    }

    /// A path of dots for each wall and for the returns of no wall, up to `half_m` to each side.
    fn walls(&self, half_m: f64) -> impl Iterator<Item = Path> {
        let numbers: BTreeSet<Option<u32>> = self.wall_of_return.iter().copied().collect();
        let is_shown = move |[x_m, y_m]: &[f64; 2]| x_m.abs() < half_m && y_m.abs() < half_m;
        numbers.into_iter().filter_map(move |number| {
            let shown = self.returns_m.iter().zip(&self.wall_of_return).filter(move |(at_m, _)| is_shown(at_m));
            let of_wall = shown.filter(|(_, wall)| **wall == number);
            // A line of no length with a round cap is a dot.
            let dots: String = of_wall.map(|([x_m, y_m], _)| format!("M{:.2} {:.2}h0", -y_m, -x_m)).collect();
            let colour = number.map_or(NO_WALL.to_owned(), |number| {
                let [red, green, blue] = wall_rgb(number);
                format!("#{red:02x}{green:02x}{blue:02x}")
            });
            (!dots.is_empty()).then(|| Path::new().set("d", dots).set("stroke", colour))
        })
    }
}

/// A bar in the lower left corner, and its length.
fn scale(units_per_m: f64) -> Group {
    let [x, y] = [MARGIN_M - HALF_M, HALF_M - MARGIN_M];
    let end = x + BAR_M * units_per_m;
    let bar = Line::new().set("x1", x).set("x2", format!("{end:.2}")).set("y1", y).set("y2", y);
    let length = Text::new(format!("{BAR_M} m")).set("x", x).set("y", y - 0.6).set("fill", INK);
    Group::new().add(bar.set("stroke", INK).set("stroke-width", 0.2)).add(length.set("font-size", 0.5 * TITLE_M))
}

/// The colour of a wall.
pub fn wall_rgb(number: u32) -> [u8; 3] {
    WALLS_RGB[number as usize % WALLS_RGB.len()]
}

fn positions(revolution: &Revolution) -> Vec<[f64; 2]> {
    revolution.points_m.iter().map(|point| [point.x, point.y]).collect()
}

/// A line along the bearing of an opening, and a bar across it, as wide as the opening, where the width is measured.
fn opening_mark([bearing_rad, width_m]: [f64; 2]) -> Group {
    let dashed = Line::new().set("y1", -1.5).set("y2", -LOOKOUT_M).set("stroke-dasharray", "0.3 0.3");
    let across = Line::new()
        .set("x1", format!("{:.2}", -0.5 * width_m))
        .set("x2", format!("{:.2}", 0.5 * width_m))
        .set("y1", -LOOKOUT_M)
        .set("y2", -LOOKOUT_M);
    Group::new()
        .set("transform", format!("rotate({:.1})", -bearing_rad.to_degrees()))
        .set("stroke", INK)
        .set("stroke-width", 0.15)
        .add(dashed)
        .add(across)
}

/// Arranges panels in rows of `columns`.
pub fn sheet(panels: &[Panel], columns: usize) -> String {
    let (width_m, height_m) = (columns as f64 * WIDTH_M, panels.len().div_ceil(columns) as f64 * HEIGHT_M);
    let mut document = page(width_m, height_m, 0.7 * TITLE_M)
        .set("width", width_m * PIXELS_PER_M)
        .set("height", height_m * PIXELS_PER_M)
        .set("fill", "none")
        .set("stroke-linecap", "round")
        .set("stroke-width", 0.5);
    for (place, panel) in panels.iter().enumerate() {
        let (row, column) = (place / columns, place % columns);
        let (x_m, y_m) = ((column as f64 + 0.5) * WIDTH_M, row as f64 * HEIGHT_M + TITLE_M + HALF_M);
        document = document.add(panel.drawn().set("transform", format!("translate({x_m} {y_m})")));
    }
    document.to_string() + "\n"
}
