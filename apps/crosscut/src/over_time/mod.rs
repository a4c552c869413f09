//! A flight over time: how many walls, how sure, and where the count is not that of the revolutions around it.

mod page;
mod picture;
mod reason;

use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_evaluate::{AROUND, Flip, flips};
use crosscut_report::confidence::Grounds;
use crosscut_stage::Frame;

use reason::WallArc;

/// What is kept of every revolution.
pub(crate) struct OverTime {
    vehicle_width_m: f64,
    moments: Vec<Moment>,
}

/// One revolution.
struct Moment {
    seq: u64,
    stamp_ns: u64,
    junctions: usize,
    margin: Option<f64>,
    confidence: f64,
    /// None without walls, or without beams.
    grounds: Option<Grounds>,
    walls: Vec<WallArc>,
    limited_view: bool,
}

impl OverTime {
    pub(crate) fn new(vehicle_width_m: f64) -> Self {
        Self { vehicle_width_m, moments: Vec::new() }
    }

    /// Takes in the next revolution of the flight.
    pub(crate) fn take(&mut self, frame: &Frame) {
        self.moments.push(Moment {
            seq: frame.revolution.seq,
            stamp_ns: frame.revolution.stamp_ns,
            junctions: frame.junction.junctions,
            margin: frame.spectrum.margin_decades,
            confidence: frame.junction.confidence,
            grounds: Grounds::of(
                &frame.revolution,
                self.vehicle_width_m,
                frame.spectrum.margin_decades,
                &frame.junction,
            ),
            walls: reason::arcs(&frame.junction),
            limited_view: frame.revolution.as_sweep().is_some_and(|sweep| !sweep.view().full_turn),
        });
    }

    /// The picture at `svg`, the list of flips beside it.
    pub(crate) fn write(&self, svg: &Path) -> anyhow::Result<()> {
        let junctions: Vec<usize> = self.moments.iter().map(|moment| moment.junctions).collect();
        let flips = flips(&junctions);
        let title = svg.file_stem().unwrap_or_default().to_string_lossy();
        let list = page::markdown(&title, self, &flips);
        for (file, text) in [(svg.to_owned(), picture::svg(self, &flips)), (list_beside(svg), list)] {
            std::fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
        }
        Ok(())
    }

    /// Seconds since the first revolution.
    fn seconds(&self, moment: &Moment) -> f64 {
        (moment.stamp_ns as f64 - self.moments[0].stamp_ns as f64) / 1e9
    }

    /// What a flip has that the nearest revolution with the count around it has not, or the other way round.
    fn reason(&self, flip: &Flip) -> String {
        let near = (1..=AROUND).flat_map(|apart| [flip.at.checked_sub(apart), Some(flip.at + apart)]);
        let moments = near.flatten().filter_map(|at| self.moments.get(at));
        let typical = moments.into_iter().find(|moment| moment.junctions == flip.around);
        let own = &self.moments[flip.at];
        typical.map_or_else(String::new, |other| reason::of_flip(&own.walls, &other.walls, own.limited_view))
    }
}

/// Where the list goes whose picture is at `svg`.
pub(crate) fn list_beside(svg: &Path) -> PathBuf {
    svg.with_extension("md")
}
