//! What changed since the revolution before, where the count is another one.

use std::collections::BTreeMap;

use crosscut_stage::{Frame, Wall, counted};

use crate::colors::name_of;
use crate::tracks::{BINS, Classes, bin, counts};

/// The walls of the revolution before.
#[derive(Default)]
pub(crate) struct Before(Option<Walls>);

/// The walls of one revolution by the class of their colour, which a wall keeps.
struct Walls {
    seq: u64,
    count: usize,
    /// By direction the class that was seen there.
    seen: Vec<Option<u16>>,
    by_class: BTreeMap<u16, Wall>,
}

impl Walls {
    fn of(frame: &Frame, classes: &Classes) -> Self {
        let (junction, class) = (&frame.junction, |wall: u32| classes.of_wall(Some(wall)));
        let mut seen = vec![None; BINS];
        for (i, wall) in junction.wall_of_return.iter().enumerate().take(frame.revolution.len()) {
            seen[bin(frame, i)] = wall.map(class);
        }
        let by_class = junction.walls.iter().map(|wall| (class(wall.id), wall.clone())).collect();
        Self { seq: frame.revolution.seq, count: junction.junctions, seen, by_class }
    }

    /// The walls that count here and not by `other`, and what `other` saw in their directions: "4 (lime), 16 returns, is new:
    /// before, part of 2 (green)".
    fn alone(&self, other: &Self, is: &str) -> Vec<String> {
        let name = |class: &u16, wall: &Wall| format!("{} ({})", wall.id, name_of(*class));
        let counted_here = self.by_class.iter().filter(|(_, wall)| !wall.island);
        let alone = counted_here.filter(|(class, _)| other.by_class.get(class).is_none_or(|wall| wall.island));
        let told = |(class, wall): (&u16, &Wall)| {
            let there = self.seen.iter().zip(&other.seen).filter(|(own, _)| **own == Some(*class));
            let most = counts(there.filter_map(|(_, of)| *of)).into_iter().max_by_key(|(_, times)| *times);
            let there = match most.and_then(|(class, _)| Some((class, other.by_class.get(&class)?))) {
                Some((_, of)) if of.island => "an island".to_owned(),
                Some((class, of)) => format!("part of {}", name(&class, of)),
                None => "not seen".to_owned(),
            };
            format!("{}, {}, {is}, {there}", name(class, wall), counted(wall.returns as u64, "return"))
        };
        alone.map(told).collect()
    }
}

impl Before {
    /// "Since 227 (4 walls): 4 (lime), 16 returns, is new: before, an island.", if the count is another one.
    pub(crate) fn what_changed(&mut self, frame: &Frame, classes: &Classes) -> Option<String> {
        let before = self.0.replace(Walls::of(frame, classes))?;
        let now = self.0.as_ref().filter(|now| now.count != before.count)?;
        let told = [now.alone(&before, "is new: before"), before.alone(now, "is gone: now")].concat().join("; ");
        Some(format!("Since {} ({}): {told}.", before.seq, counted(before.count as u64, "wall")))
    }
}
