//! A flight over time: count, margin and confidence, and the revolutions whose count differs from their neighbours.

mod page;
mod picture;
mod reason;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::{AROUND, Flip, flips};
use crosscut_report::confidence::Grounds;
use crosscut_stage::Frame;

use crate::outputs;
use reason::WallArc;

/// The picture and the list of a flight, as files.
pub(crate) struct OverTime {
    title: String,
    picture: Box<dyn Write + Send>,
    list: Box<dyn Write + Send>,
    course: Course,
}

/// The values that are kept of every revolution of a flight.
pub(crate) struct Course {
    vehicle_width_m: f64,
    /// Time of the first revolution in seconds after the first scan of the flight.
    starts_at_s: f64,
    moments: Vec<Moment>,
}

/// The values of one revolution.
struct Moment {
    seq: u64,
    stamp_ns: u64,
    junctions: usize,
    margin: Option<f64>,
    confidence: Option<f64>,
    /// `None` without walls or without beams.
    grounds: Option<Grounds>,
    walls: Vec<WallArc>,
    limited_view: bool,
}

impl OverTime {
    /// Opens both files. Neither may be one of those `read`.
    pub(crate) fn create(svg: &Path, read: &[PathBuf], vehicle_width_m: f64) -> anyhow::Result<Self> {
        let title = svg.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let [picture, list] = [svg, &list_beside(svg)].map(|path| outputs::create(path, read));
        Ok(Self { title, picture: picture?, list: list?, course: Course::new(vehicle_width_m) })
    }

    /// Adds the next revolution of the flight.
    pub(crate) fn take(&mut self, frame: &Frame) {
        self.course.take(frame);
    }

    /// Writes the picture and the list of flips; nothing if there are no revolutions. The first revolution was recorded
    /// `starts_at_s` after the first scan of the flight.
    pub(crate) fn write(&mut self, starts_at_s: f64) -> anyhow::Result<()> {
        self.course.start(starts_at_s);
        if self.course.moments.is_empty() {
            return Ok(());
        }
        let flips = self.course.flips();
        let (picture, list) = (picture::svg(&self.course, &flips), page::markdown(&self.title, &self.course, &flips));
        self.picture.write_all(picture.as_bytes()).context("the picture of the flight over time")?;
        self.list.write_all(list.as_bytes()).context("the list of the flight over time")
    }
}

impl Course {
    pub(crate) fn new(vehicle_width_m: f64) -> Self {
        Self { vehicle_width_m, starts_at_s: 0.0, moments: Vec::new() }
    }

    /// Adds the next revolution of the flight.
    pub(crate) fn take(&mut self, frame: &Frame) {
        self.moments.push(Moment {
            seq: frame.revolution.seq,
            stamp_ns: frame.revolution.stamp_ns,
            junctions: frame.junction.junctions,
            margin: frame.spectrum.margin_decades,
            confidence: frame.junction.confidence,
            grounds: Grounds::of(
                &frame.revolution,
                &frame.affinity.verdicts,
                self.vehicle_width_m,
                frame.spectrum.margin_decades,
                &frame.junction,
            ),
            walls: reason::arcs(&frame.junction),
            limited_view: frame.revolution.as_sweep().is_some_and(|sweep| !sweep.view().full_turn),
        });
    }

    /// The first revolution was recorded this long after the first scan of the flight.
    pub(crate) fn start(&mut self, starts_at_s: f64) {
        self.starts_at_s = starts_at_s;
    }

    /// From the first revolution to the last, s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.moments.last().map_or(0.0, |last| self.seconds(last) - self.starts_at_s)
    }

    /// The picture, and how many revolutions have another count than most of their neighbours.
    pub(crate) fn picture(&self) -> (String, usize) {
        let flips = self.flips();
        (picture::svg(self, &flips), flips.len())
    }

    fn flips(&self) -> Vec<Flip> {
        flips(&self.moments.iter().map(|moment| moment.junctions).collect::<Vec<_>>())
    }

    /// Time of a revolution in seconds after the first scan of the flight.
    fn seconds(&self, moment: &Moment) -> f64 {
        self.starts_at_s + (moment.stamp_ns as f64 - self.moments[0].stamp_ns as f64) / 1e9
    }

    /// How the walls of a flip differ from those of the nearest revolution with the count around it.
    fn reason(&self, flip: &Flip) -> String {
        let near = (1..=AROUND).flat_map(|apart| [flip.at.checked_sub(apart), Some(flip.at + apart)]);
        let moments = near.flatten().filter_map(|at| self.moments.get(at));
        let typical = moments.into_iter().find(|moment| moment.junctions == flip.around);
        let own = &self.moments[flip.at];
        typical.map_or_else(String::new, |other| reason::of_flip(&own.walls, &other.walls, own.limited_view))
    }
}

/// The path of the list that belongs to the picture at `svg`.
pub(crate) fn list_beside(svg: &Path) -> PathBuf {
    svg.with_extension("md")
}
