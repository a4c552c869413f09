//! Which beams two flights put into one wall, and how the two groupings of a scan differ.

use std::collections::BTreeMap;

use crate::colors::{COLORS, name_of};

/// Two walls are the same if they share this part of the beams that either has.
const SAME: f64 = 0.8;
/// A wall is part of another one that has this share of its beams.
const PART: f64 = 0.5;

/// The walls of one scan, as a recording has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Grouping {
    /// The wall of each beam, negative for none: runs of equal ones with their lengths.
    pub(super) labels: Vec<(i32, usize)>,
    pub(super) walls: Vec<Wall>,
    /// By wall its weakest edge in words, and the beams of that edge.
    pub(super) weakest: BTreeMap<i32, (String, [usize; 2])>,
}

/// A wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wall {
    id: i32,
    is_island: bool,
    /// Of its colour.
    class: u16,
}

impl Wall {
    /// Of a row of `/report/walls`.
    pub(super) fn of(row: &[f64]) -> Self {
        Self { id: row[0] as i32, is_island: row[4] > 0.0, class: row[5] as u16 }
    }
}

/// Runs of equal labels.
pub(super) fn runs(labels: &[i32]) -> Vec<(i32, usize)> {
    labels.chunk_by(i32::eq).map(|run| (run[0], run.len())).collect()
}

/// By wall its weakest edge, from the lines "- **3 (blue)**, 2 returns: weakest edge inside 4.4e-3 (beams 341, 342: 1.90 m); ..."
/// of `/report/why`.
pub(super) fn weakest_edges(text: &str) -> BTreeMap<i32, (String, [usize; 2])> {
    let edge = |line: &str| {
        let (wall, rest) = line.strip_prefix("- **")?.split_once(' ')?;
        let (_, edge) = rest.split_once("weakest edge inside ")?;
        let (edge, _) = edge.split_once(';')?;
        let (_, beams) = edge.split_once("beams ")?;
        let (a, b) = beams.split_once(':')?.0.split_once(", ")?;
        Some((wall.parse().ok()?, (edge.to_owned(), [a.parse().ok()?, b.parse().ok()?])))
    };
    text.lines().filter_map(edge).collect()
}

impl Grouping {
    fn counted(&self) -> impl Iterator<Item = i32> + '_ {
        self.walls.iter().filter(|wall| !wall.is_island).map(|wall| wall.id)
    }

    fn beams_of(&self, id: i32) -> usize {
        self.labels.iter().filter(|(label, _)| *label == id).map(|(_, beams)| beams).sum()
    }

    fn label_at(&self, beam: usize) -> Option<i32> {
        let mut end = 0;
        let run = self.labels.iter().find(|(_, beams)| {
            end += beams;
            beam < end
        });
        run.map(|(label, _)| *label)
    }

    /// How many beams each wall shares with each of the other's.
    fn shared(&self, other: &Self) -> BTreeMap<[i32; 2], usize> {
        let mut shared = BTreeMap::new();
        let (mut own, mut others) = (self.labels.iter().copied(), other.labels.iter().copied());
        let (mut a, mut b) = (own.next(), others.next());
        while let (Some((of_a, beams_a)), Some((of_b, beams_b))) = (a, b) {
            let beams = beams_a.min(beams_b);
            *shared.entry([of_a, of_b]).or_default() += beams;
            a = if beams_a > beams { Some((of_a, beams_a - beams)) } else { own.next() };
            b = if beams_b > beams { Some((of_b, beams_b - beams)) } else { others.next() };
        }
        shared.retain(|ids, _| ids.iter().all(|id| *id >= 0));
        shared
    }

    /// Whether every wall that counts has one of the other's that is the same.
    pub(super) fn is_as(&self, other: &Self) -> bool {
        let shared = self.shared(other);
        let is_same = |id: i32| {
            shared.iter().filter(|([a, _], _)| *a == id).any(|([_, b], beams)| {
                let either = self.beams_of(id) + other.beams_of(*b) - beams;
                *beams as f64 >= SAME * either as f64
            })
        };
        self.counted().all(is_same)
    }

    /// What one flight has as one wall and the other as several; else what only one of them counts: "paper has 1 (orange) and 3
    /// (blue) of default as one, 2 (green), held by its weakest edge, 1.5e-7 (beams 12, 301: 3.46 m)". `colors` are the other's
    /// classes as they are drawn.
    pub(super) fn words(&self, other: &Self, [own, others]: [&str; 2]) -> Option<String> {
        self.joins(other, [own, others]).or_else(|| other.joins(self, [others, own])).or_else(|| {
            let alone = self.counts_alone(other, [own, others]);
            alone.or_else(|| other.counts_alone(self, [others, own]))
        })
    }

    fn joins(&self, other: &Self, [own, others]: [&str; 2]) -> Option<String> {
        let shared = self.shared(other);
        self.counted().find_map(|id| {
            let is_part = |part: &i32| {
                let beams = shared.get(&[id, *part]).copied().unwrap_or(0);
                beams > 0 && beams as f64 >= PART * other.beams_of(*part) as f64
            };
            let parts: Vec<i32> = other.counted().filter(is_part).collect();
            let edge = self.weakest.get(&id).filter(|(_, beams)| {
                let [a, b] = beams.map(|beam| other.label_at(beam).filter(|label| parts.contains(label)));
                a.is_some() && b.is_some() && a != b
            });
            let edge = edge.map_or_else(String::new, |(edge, _)| format!(", held by one edge, {edge}"));
            let names = parts.iter().map(|part| other.name(*part)).collect::<Vec<_>>().join(" and ");
            (parts.len() > 1).then(|| format!("{own} has {names} of {others} as one wall, {}{edge}", self.name(id)))
        })
    }

    fn counts_alone(&self, other: &Self, [own, others]: [&str; 2]) -> Option<String> {
        let shared = self.shared(other);
        let is_of_both = |id: &i32| other.counted().any(|of| shared.get(&[*id, of]).is_some_and(|beams| *beams > 0));
        let id = self.counted().find(|id| !is_of_both(id))?;
        Some(format!("{} of {own}, {} beams, is no wall to {others}", self.name(id), self.beams_of(id)))
    }

    fn name(&self, id: i32) -> String {
        let class = self.walls.iter().find(|wall| wall.id == id).map(|wall| name_of(wall.class));
        format!("{id} ({})", class.unwrap_or_default())
    }

    /// Gives the walls the classes of those of the other that share the most beams; a wall that shares none keeps its own, if no
    /// other has that colour. Returns the new class of each old one.
    pub(super) fn color_as(&mut self, other: &Self) -> BTreeMap<u16, u16> {
        let class_in = |walls: &[Wall], id: i32| walls.iter().find(|wall| wall.id == id).map(|wall| wall.class);
        let mut shared: Vec<_> = self.shared(other).into_iter().collect();
        shared.sort_by_key(|(ids, beams)| (std::cmp::Reverse(*beams), *ids));
        let mut classes = BTreeMap::new();
        let mut taken = Vec::new();
        for ([id, of], _) in shared {
            if let (Some(own), Some(class)) = (class_in(&self.walls, id), class_in(&other.walls, of))
                && !classes.contains_key(&own)
                && !taken.contains(&class)
            {
                classes.insert(own, class);
                taken.push(class);
            }
        }
        taken.extend(other.walls.iter().map(|wall| wall.class));
        for Wall { class, .. } in &mut self.walls {
            let free = || [*class].into_iter().chain(0..COLORS).find(|class| !taken.contains(class)).unwrap_or(*class);
            let new = classes.get(&*class).copied().unwrap_or_else(free);
            taken.push(new);
            classes.insert(std::mem::replace(class, new), new);
        }
        classes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grouping(labels: &[(i32, usize)]) -> Grouping {
        let walls = labels.iter().map(|(id, _)| *id).filter(|id| *id >= 0).collect::<std::collections::BTreeSet<_>>();
        let walls = walls.into_iter().map(|id| Wall { id, is_island: false, class: id as u16 }).collect();
        Grouping { labels: labels.to_vec(), walls, ..Grouping::default() }
    }

    #[test]
    fn the_sentence_names_the_walls_that_one_flight_joins_and_the_edge() {
        let mut a = grouping(&[(0, 40), (-1, 5), (0, 30), (1, 20)]);
        let b = grouping(&[(0, 40), (-1, 5), (1, 30), (2, 20)]);
        a.weakest =
            weakest_edges("- **0 (blue)**, 70 returns: weakest edge inside 1.5e-7 (beams 39, 45: 3.30 m); no edge");
        let expected = "paper has 0 (blue) and 1 (orange) of default as one wall, 0 (blue), held by one edge, 1.5e-7 (beams 39, 45: \
                        3.30 m)";
        assert_eq!(a.words(&b, ["paper", "default"]).as_deref(), Some(expected));
        assert_eq!(b.words(&a, ["default", "paper"]).as_deref(), Some(expected));
        let without = grouping(&[(0, 40), (-2, 5), (0, 30), (-2, 20)]);
        let expected = "1 (orange) of a, 20 beams, is no wall to b";
        assert_eq!(a.words(&without, ["a", "b"]).as_deref(), Some(expected));
    }

    #[test]
    fn equal_counts_may_be_other_groupings() {
        let a = grouping(&[(0, 40), (1, 30), (2, 20)]);
        assert!(a.is_as(&grouping(&[(0, 40), (1, 28), (-2, 2), (2, 20)])));
        assert!(!a.is_as(&grouping(&[(0, 40), (1, 15), (2, 15), (0, 20)])));
    }

    #[test]
    fn walls_take_the_colours_of_those_that_share_the_most_beams() {
        let a = grouping(&[(0, 40), (1, 30), (2, 20)]);
        let mut b = grouping(&[(0, 20), (1, 40), (2, 20), (3, 10)]);
        let classes = b.color_as(&a);
        assert_eq!(classes, BTreeMap::from([(0, 0), (1, 1), (2, 2), (3, 3)]));
        let mut c = grouping(&[(2, 40), (0, 30), (1, 20)]);
        assert_eq!(c.color_as(&a), BTreeMap::from([(2, 0), (0, 1), (1, 2)]));
        assert_eq!(c.name(2), "2 (blue)");
    }
}
