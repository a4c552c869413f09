//! The walls of two scans compared in words: those of a revolution with those of the one before, and those that two flights have of
//! one revolution.

use std::collections::BTreeMap;

use crosscut_stage::{Frame, Wall, counted};

use crate::colors::name_of;
use crate::tracks::{Classes, by_direction, counts};

/// Two walls are the same if they share this part of the places that either has.
const SAME: f64 = 0.8;

/// The walls of one scan by the class of their colour, which a wall keeps.
#[derive(Default)]
pub(crate) struct Walls {
    /// By place, a direction or a beam, the class that is seen there.
    pub(crate) seen: Vec<Option<u16>>,
    by_class: BTreeMap<u16, Wall>,
}

/// A wall that counts in one of two scans alone.
pub(crate) struct Alone {
    /// "wall 4 (lime), 16 returns, is new; before, it was part of wall 2 (green)".
    pub(crate) words: String,
    /// Its class, and the number of the wall that it is part of in the other scan.
    pub(crate) class: u16,
    pub(crate) part_of: Option<u32>,
}

impl Walls {
    /// Of the numbers of the walls that are seen at each place.
    pub(crate) fn new(places: &[Option<u32>], walls: &[Wall], class: impl Fn(u32) -> u16) -> Self {
        let seen = places.iter().map(|wall| wall.map(&class)).collect();
        Self { seen, by_class: walls.iter().map(|wall| (class(wall.id), wall.clone())).collect() }
    }

    fn of(frame: &Frame, classes: &Classes) -> Self {
        Self::new(&by_direction(frame), &frame.junction.walls, |wall| classes.of_wall(Some(wall)))
    }

    fn counted(&self) -> impl Iterator<Item = (u16, &Wall)> {
        self.by_class.iter().filter(|(_, wall)| !wall.island).map(|(class, wall)| (*class, wall))
    }

    /// The share of the places of either wall of this class that both have.
    fn shared(&self, other: &Self, class: u16) -> f64 {
        let both = self.seen.iter().zip(&other.seen).map(|(a, b)| [a, b].map(|of| *of == Some(class)));
        let [all, any] = both.fold([0, 0], |[all, any], [a, b]| [all + u32::from(a && b), any + u32::from(a || b)]);
        f64::from(all) / f64::from(any.max(1))
    }

    /// Whether both have the same walls.
    pub(crate) fn is_as(&self, other: &Self) -> bool {
        self.counted().chain(other.counted()).all(|(class, _)| self.shared(other, class) >= SAME)
    }

    /// The walls that count here and not by `other`, and what it has in their directions.
    pub(crate) fn alone(&self, other: &Self, is: &str) -> Vec<Alone> {
        let alone = self.counted().filter(|(class, _)| other.by_class.get(class).is_none_or(|wall| wall.island));
        let told = |(class, wall): (u16, &Wall)| {
            let there = self.seen.iter().zip(&other.seen).filter(|(own, _)| **own == Some(class));
            let most = counts(there.filter_map(|(_, of)| *of)).into_iter().max_by_key(|(_, times)| *times);
            let most = most.and_then(|(class, _)| Some((class, other.by_class.get(&class)?)));
            let there = match most {
                Some((_, of)) if of.island => "an island".to_owned(),
                Some((class, of)) => format!("part of {}", name(class, of)),
                None => "not seen".to_owned(),
            };
            let words = format!("{}, {}, {is} {there}", name(class, wall), counted(wall.returns as u64, "return"));
            Alone { words, class, part_of: most.map(|(_, of)| of.id) }
        };
        alone.map(told).collect()
    }

    /// "wall 2 (green) has 40 returns by paper and 70 by default", of the wall that both count and that differs the most.
    pub(crate) fn most_other(&self, other: &Self, [own, others]: &[String; 2]) -> Option<String> {
        let both = self.counted().filter_map(|(class, wall)| Some((class, wall, other.by_class.get(&class)?)));
        let (class, a, b) = both.min_by(|a, b| self.shared(other, a.0).total_cmp(&self.shared(other, b.0)))?;
        let returns = counted(a.returns as u64, "return");
        Some(format!("{} has {returns} by {own} and {} by {others}", name(class, a), b.returns))
    }
}

fn name(class: u16, wall: &Wall) -> String {
    crosscut_explain::wall(wall.id, name_of(class))
}

/// The walls of the revolution before, of which this is the number.
#[derive(Default)]
pub(crate) struct Before(Option<(u64, Walls)>);

impl Before {
    /// "Since 227 (4 walls): wall 4 (lime), 16 returns, is new; before, it was an island.", if the count is another one.
    pub(crate) fn what_changed(&mut self, frame: &Frame, classes: &Classes) -> Option<String> {
        let (seq, before) = self.0.replace((frame.revolution.seq, Walls::of(frame, classes)))?;
        let (_, now) = self.0.as_ref()?;
        let walls = before.counted().count();
        let told =
            now.alone(&before, "is new; before, it was").into_iter().chain(before.alone(now, "is gone; now it is"));
        let told = told.map(|of| of.words).collect::<Vec<_>>().join("; ");
        (now.counted().count() != walls).then(|| format!("Since {seq} ({}): {told}.", counted(walls as u64, "wall")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls that lie beside each other, each with its number of places; its number is its class.
    fn walls(of: &[(u32, usize)]) -> Walls {
        let wall =
            |(id, returns): &(u32, usize)| Wall { id: *id, returns: *returns, bearing_rad: [0.0; 2], island: false };
        let places: Vec<_> = of.iter().flat_map(|(id, places)| vec![Some(*id); *places]).collect();
        Walls::new(&places, &of.iter().map(wall).collect::<Vec<_>>(), |id| id as u16)
    }

    #[test]
    fn a_wall_that_one_scan_lacks_is_named_with_what_the_other_has_there() {
        let [a, b] = [walls(&[(0, 70), (2, 20)]), walls(&[(0, 40), (1, 30), (2, 20)])];
        let alone = b.alone(&a, "is counted by default alone; by paper it is");
        assert_eq!(
            alone[0].words,
            "wall 1 (orange), 30 returns, is counted by default alone; by paper it is part of wall 0 (blue)"
        );
        assert_eq!((alone.len(), alone[0].class, alone[0].part_of, a.alone(&b, "").len()), (1, 1, Some(0), 0));
        let gone = &walls(&[(0, 40), (1, 9)]).alone(&walls(&[(0, 40)]), "is gone; now it is")[0].words;
        assert_eq!(gone, "wall 1 (orange), 9 returns, is gone; now it is not seen");
    }

    #[test]
    fn equal_counts_may_be_other_groupings() {
        let a = walls(&[(0, 40), (1, 30), (2, 20)]);
        assert!(a.is_as(&walls(&[(0, 40), (1, 28), (2, 22)])));
        let b = walls(&[(0, 40), (1, 10), (2, 40)]);
        assert!(!a.is_as(&b) && a.alone(&b, "").is_empty());
        let told = a.most_other(&b, &["a", "b"].map(str::to_owned));
        assert_eq!(told.as_deref(), Some("wall 1 (orange) has 30 returns by a and 10 by b"));
    }
}
