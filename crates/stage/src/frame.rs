//! The frame: every intermediate value of one revolution, with one owner at a time.

use std::fmt;

use crate::{Affinity, Beam, Extra, Junction, Notes, Partition, Revolution, Spectrum};

/// All that is known of one revolution. It passes from stage to stage, each filling its part, then back to a pool.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The returns, from ingest.
    pub revolution: Revolution,
    /// W and D, from the affinity stage.
    pub affinity: Affinity,
    /// λ, k and U, from the spectral stage.
    pub spectrum: Spectrum,
    /// Clusters, from the kmeans stage.
    pub partition: Partition,
    /// Walls and openings, from the report stage.
    pub junction: Junction,
    /// What later work adds, which sees more than this revolution.
    pub extra: Extra,
    /// What was dropped, repaired or fallen back to on the way.
    pub notes: Notes,
    /// The time of each step, measured by the worker around it.
    pub timings: Timings,
    /// Set when a step failed; the parts after it are then not of this revolution.
    pub failure: Option<Failure>,
}

impl Frame {
    /// Label of a beam that has no return.
    pub const NO_RETURN: i32 = -1;
    /// Label of a return that belongs to no wall.
    pub const NO_WALL: i32 = -2;

    /// One a beam of the message, in its order, or one a point of a cloud: the id of its wall, [`Frame::NO_RETURN`] or
    /// [`Frame::NO_WALL`].
    pub fn labels(&self) -> Vec<i32> {
        let wall = |i: usize| self.junction.wall_of_return.get(i).copied().flatten();
        let label = |i: usize| wall(i).map_or(Self::NO_WALL, u32::cast_signed);
        let entries = &self.revolution.entries;
        if !entries.is_empty() {
            return entries.iter().map(|&of| usize::try_from(of).map_or(of, label)).collect();
        }
        let Some(sweep) = self.revolution.beams() else { return (0..self.revolution.len()).map(label).collect() };
        let label_of_beam = |beam: &Beam| match beam {
            Beam::Return(i) => label(*i as usize),
            Beam::NoReturn | Beam::Unknown => Self::NO_RETURN,
        };
        let beyond_turn = sweep.ranges_m.len().saturating_sub(sweep.len());
        sweep.beams.iter().map(label_of_beam).chain(std::iter::repeat_n(Self::NO_RETURN, beyond_turn)).collect()
    }
}

/// One step of the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names suffice
pub enum Step {
    Ingest,
    Affinity,
    Spectral,
    Kmeans,
    Report,
}

impl Step {
    /// All steps, in the order in which they run.
    pub const ALL: [Self; 5] = [Self::Ingest, Self::Affinity, Self::Spectral, Self::Kmeans, Self::Report];

    /// Its name in results, configuration and recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ingest => "ingest",
            Self::Affinity => "affinity",
            Self::Spectral => "spectral",
            Self::Kmeans => "kmeans",
            Self::Report => "report",
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Times of one revolution, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    /// Of each step, in the order of [`Step::ALL`].
    steps_ns: [u64; Step::ALL.len()],
    /// Of the flight; `None` without one.
    pub flight_ns: Option<u64>,
    /// From the arrival of the scan to its written results; `None` before that.
    pub latency_ns: Option<u64>,
}

impl Timings {
    /// Sets the time of a step.
    pub fn set_ns(&mut self, step: Step, ns: u64) {
        self.steps_ns[step as usize] = ns;
    }

    /// The time of a step.
    pub fn ns(&self, step: Step) -> u64 {
        self.steps_ns[step as usize]
    }
}

/// A step that could not do its work on a revolution. It travels in the frame.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{step} failed on revolution {seq}: {cause}")]
pub struct Failure {
    /// Which step.
    pub step: Step,
    /// On which revolution.
    pub seq: u64,
    /// Why.
    pub cause: FailureCause,
}

/// Why a step failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FailureCause {
    /// The stage returned an error.
    #[error("{0}")]
    Error(String),
    /// The stage panicked: a defect in the stage. The panic was caught.
    #[error("it panicked: {0}")]
    Panic(String),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Point, Sweep};

    #[test]
    fn labels_are_per_beam_and_tell_no_return_from_no_wall() {
        let mut frame = Frame::default();
        frame.revolution.points_m = vec![Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        frame.junction.wall_of_return = vec![Some(3), None];
        assert_eq!(frame.labels(), [3, -2], "without beams, per return");
        let beams = vec![Beam::Unknown, Beam::Return(0), Beam::NoReturn, Beam::Return(1)];
        frame.revolution.sweep = Some(Sweep { beams, ..Default::default() });
        assert_eq!(frame.labels(), [-1, 3, -1, -2]);
        frame.revolution.sweep.as_mut().expect("it has just been set").ranges_m = vec![1.0; 6];
        assert_eq!(frame.labels(), [-1, 3, -1, -2, -1, -1], "the message goes on beyond a full turn");
        frame.revolution.clear();
        frame.revolution.points_m = vec![Point::origin(); 2];
        assert_eq!(frame.labels(), [3, -2], "without beams in a frame that held a sweep");
        frame.revolution.entries = vec![1, -1, 0, 0, -2];
        assert_eq!(frame.labels(), [-2, -1, 3, 3, -2], "of a cloud, per point");
    }
}
