//! The mine that a mission explores: what is drawn of it once.

use nalgebra::Point2;
use rerun::{Arrows3D, AsComponents, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{EDGE, GREY, LABEL, OPENING, REPORTED, VEHICLE, WORDS, ZEROS, color, series};
use crate::layout::mission::entities;
use crate::scan::step_m;

/// Colour of a way that was not taken.
pub(crate) const NEW: u32 = OPENING;

/// The mine that a mission explores, as the page shows it.
pub(crate) struct Mine {
    /// The true outline.
    lines: Vec<Vec<[f32; 3]>>,
    /// The ends of a rectangle around it, m.
    pub(crate) corners_m: [Point2<f64>; 2],
}

impl Mine {
    /// Of its true outline in segments.
    pub(crate) fn new(outline_m: &[[Point2<f64>; 2]]) -> Self {
        let (mut low, mut high) = (Point2::new(-10.0, -10.0), Point2::new(10.0, 10.0));
        for place_m in outline_m.iter().flatten() {
            (low, high) = (low.inf(place_m), high.sup(place_m));
        }
        Self { lines: chains(outline_m), corners_m: [low, high] }
    }

    /// What never changes: the outline, colours and widths.
    pub(crate) fn log_static(&self, rec: &RecordingStream) -> RecordingStreamResult<()> {
        let outline = LineStrips3D::new(self.lines.iter().cloned()).with_colors([color(EDGE)]);
        rec.log_static(entities::MINE, &outline.with_radii([Radius::new_ui_points(1.0)]))?;
        self.log_scale(rec)?;
        log_looks(rec)
    }

    /// A bar of a round length below the mine, and the length.
    fn log_scale(&self, rec: &RecordingStream) -> RecordingStreamResult<()> {
        let [low, high] = self.corners_m;
        let length_m = step_m(high.x - low.x);
        let at = |x: f64| above(Point2::new(low.x + x, low.y), 0.0);
        let bar = LineStrips3D::new([[at(0.0), at(length_m)]])
            .with_colors([color(WORDS)])
            .with_radii([Radius::new_ui_points(1.5)]);
        let name = Points3D::new([at(0.5 * length_m)])
            .with_labels([format!("{length_m} m")])
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(0.0)])
            .with_colors([color(LABEL)]);
        rec.log_static(entities::SCALE, &[&bar as &dyn AsComponents, &name])
    }
}

/// What never changes: colours and widths.
fn log_looks(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let lines =
        |rgba: u32, width: f32| LineStrips3D::update_fields().with_radii([ui(width)]).with_colors([color(rgba)]);
    let arrows = |rgba: u32, width: f32| Arrows3D::update_fields().with_radii([ui(width)]).with_colors([color(rgba)]);
    let looks: [(&str, &dyn AsComponents); 9] = [
        (entities::VEHICLE, &arrows(VEHICLE, 4.0)),
        (entities::TRAIL, &lines(GREY, 1.0)),
        (entities::SCAN, &Points3D::update_fields().with_radii([ui(2.0)])),
        (entities::OPENINGS, &lines(OPENING, 2.0)),
        (entities::GOAL, &lines(VEHICLE, 1.0)),
        (entities::CHOICE, &arrows(VEHICLE, 2.0)),
        (entities::PASSAGES, &lines(ZEROS, 2.0)),
        (entities::WALLS, &series("walls in view", REPORTED, 1.5)),
        (entities::NEW_WAYS, &series("ways not taken", NEW, 1.5)),
    ];
    for (entity, look) in looks {
        rec.log_static(entity, look)?;
    }
    rec.log_static(entities::WAYS, &LineStrips3D::update_fields().with_radii([ui(3.0)]))
}

/// Segments that continue each other, as lines.
fn chains(segments_m: &[[Point2<f64>; 2]]) -> Vec<Vec<[f32; 3]>> {
    let mut lines: Vec<Vec<[f32; 3]>> = Vec::new();
    let mut last = None;
    for [from_m, to_m] in segments_m {
        match lines.last_mut().filter(|_| last == Some(*from_m)) {
            Some(line) => line.push(above(*to_m, 0.0)),
            None => lines.push(vec![above(*from_m, 0.0), above(*to_m, 0.0)]),
        }
        last = Some(*to_m);
    }
    lines
}

/// A place in the map's frame, and a height over its plane.
pub(crate) fn above(place_m: Point2<f64>, height_m: f32) -> [f32; 3] {
    [place_m.x as f32, place_m.y as f32, height_m]
}
