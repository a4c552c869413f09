//! Colours of walls that stay the same from one revolution to the next.
//!
//! Results number the walls of each revolution from 0. Here each wall takes the colour of the earlier wall that lay in
//! the same directions. Only the recording depends on it, no result does.

use std::cmp::Reverse;
use std::f64::consts::{PI, TAU};

use crosscut_stage::{Dual, Frame, Way};
use nalgebra::Vector3;

use crate::colors::{COLORS, NO_WALL, name_of};

/// Number of directions: half a degree each.
const BINS: usize = 720;

/// The classes of the walls and clusters of one revolution; a class has a colour.
#[derive(Debug, Default)]
pub(crate) struct Classes {
    /// By wall number.
    pub(crate) walls: Vec<u16>,
    /// By return, that of its wall.
    pub(crate) returns: Vec<u16>,
    /// By cluster.
    clusters: Vec<u16>,
    /// By the number of the way on, where rows of W are directions.
    pub(crate) ways: Vec<u16>,
    /// By row of W, where rows are directions.
    directions: Option<Vec<u16>>,
}

impl Classes {
    /// The class of a wall.
    pub(crate) fn of_wall(&self, wall: Option<u32>) -> u16 {
        wall.and_then(|wall| self.walls.get(wall as usize)).copied().unwrap_or(NO_WALL)
    }

    /// The class of a way.
    pub(crate) fn of_way(&self, way: Option<u32>) -> u16 {
        way.and_then(|way| self.ways.get(way as usize)).copied().unwrap_or(NO_WALL)
    }

    /// By row of W: the class of the wall or way that a row is of.
    pub(crate) fn of_rows(&self) -> &[u16] {
        self.directions.as_ref().unwrap_or(&self.returns)
    }

    /// The name of the colour of the wall of this number, or of the way where these are counted.
    pub(crate) fn name(&self, number: u32) -> &'static str {
        name_of(if self.directions.is_some() { self.of_way(Some(number)) } else { self.of_wall(Some(number)) })
    }

    /// The class of the wall or way that most of a cluster's rows belong to.
    pub(crate) fn of_cluster(&self, cluster: Option<u32>) -> u16 {
        cluster.and_then(|cluster| self.clusters.get(cluster as usize)).copied().unwrap_or(NO_WALL)
    }
}

/// The classes of walls and of ways on from revolution to revolution.
#[derive(Clone, Default)]
pub(crate) struct Tracks {
    walls: LastSeen,
    ways: LastSeen,
}

/// The class that was seen last at each place: in each direction, or by each beam.
#[derive(Clone)]
pub(crate) struct LastSeen(pub(crate) Vec<Option<u16>>);

impl Default for LastSeen {
    fn default() -> Self {
        Self(vec![None; BINS])
    }
}

impl Tracks {
    /// The classes of the next revolution's walls. Walls and earlier classes are paired, those that share the most
    /// directions first. A wall without a pair gets a class that was not seen lately. As many walls as there are colours have one each.
    pub(crate) fn classes_of(&mut self, frame: &Frame) -> Classes {
        let walls = self.walls.follow(&by_direction(frame), number_of_walls(frame));
        let wall_of = |i: usize| frame.junction.wall_of_return.get(i).copied().flatten();
        let returns = (0..frame.revolution.len()).map(|i| wall_of(i).map_or(NO_WALL, |wall| walls[wall as usize]));
        let mut classes = Classes { returns: returns.collect(), walls, ..Classes::default() };
        let of_clusters = match (&frame.affinity.dual, &frame.junction.ways) {
            (Some(dual), Some(ways)) => {
                self.add_ways(dual, ways, &mut classes);
                let rows = classes.of_rows().iter().zip(&frame.partition.labels);
                most_of_clusters(rows.map(|(class, label)| (*label, Some(*class))), frame)
            }
            _ => {
                let of_returns = frame.partition.labels.iter().zip(&frame.junction.wall_of_return);
                let class = |wall: Option<u32>| wall.map(|wall| classes.of_wall(Some(wall)));
                most_of_clusters(of_returns.map(|(label, wall)| (*label, class(*wall))), frame)
            }
        };
        classes.clusters = of_clusters;
        classes
    }

    /// The classes of ways, which they keep as walls do, by directions of 10°.
    fn add_ways(&mut self, dual: &Dual, ways: &[Way], classes: &mut Classes) {
        let numbers = dual.numbers_in(ways);
        let rows: Vec<(usize, Option<u32>)> =
            dual.rows().map(|(towards, of)| (place_of(&towards), numbers[of as usize])).collect();
        let mut places = vec![None; BINS];
        rows.iter().for_each(|(place, way)| places[*place] = way.or(places[*place]));
        classes.ways = self.ways.follow(&places, ways.len());
        classes.directions = Some(rows.iter().map(|(_, way)| classes.of_way(*way)).collect());
    }
}

impl LastSeen {
    /// The class of each of `walls` walls, of which one or none is seen at each place; those are what is seen last from now on.
    fn follow(&mut self, places: &[Option<u32>], walls: usize) -> Vec<u16> {
        let classes = self.match_walls(places, walls);
        for (seen, wall) in self.0.iter_mut().zip(places) {
            *seen = wall.map(|wall| classes[wall as usize]).or(*seen);
        }
        classes
    }

    /// The class of each of `walls` walls, of which one or none is seen at each place.
    pub(crate) fn match_walls(&self, places: &[Option<u32>], walls: usize) -> Vec<u16> {
        let mut classes: Vec<Option<u16>> = vec![None; walls];
        let mut taken = Taken::by(walls);
        for (_, wall, class) in self.overlaps(places) {
            if classes[wall].is_none() && taken.allows(class) {
                classes[wall] = Some(taken.take(class));
            }
        }
        for wall in 0..walls {
            if classes[wall].is_none() {
                let beside = [(wall + walls - 1) % walls, (wall + 1) % walls].map(|beside| classes[beside]);
                classes[wall] = Some(taken.take(self.new_class(&taken, beside)));
            }
        }
        classes.into_iter().flatten().collect()
    }

    /// Number of shared places, wall and class of each pair, the most places first.
    fn overlaps(&self, places: &[Option<u32>]) -> Vec<(Reverse<usize>, usize, u16)> {
        let shared = places.iter().zip(&self.0).filter_map(|(wall, class)| Some(((*wall)? as usize, (*class)?)));
        let mut overlaps: Vec<_> =
            counts(shared).into_iter().map(|((wall, class), count)| (Reverse(count), wall, class)).collect();
        overlaps.sort_unstable();
        overlaps
    }

    /// The first class that may be taken: if possible one with its own colour that was not seen lately, else one whose
    /// colour differs from those of the walls `beside`, as walls are numbered by bearing.
    fn new_class(&self, taken: &Taken, beside: [Option<u16>; 2]) -> u16 {
        let allowed = || (0..NO_WALL).filter(|class| taken.allows(*class));
        let differs = |class: &u16| beside.iter().flatten().all(|other| other % COLORS != class % COLORS);
        let is_fresh = |class: &u16| *class < COLORS / 2 && !self.0.contains(&Some(*class));
        allowed().find(is_fresh).or_else(|| allowed().find(differs)).or_else(|| allowed().next()).unwrap_or(NO_WALL)
    }
}

/// The classes of walls that have one already. No colour is taken more often than it has to be.
struct Taken {
    classes: Vec<bool>,
    of_color: [usize; COLORS as usize],
    most_of_color: usize,
}

impl Taken {
    /// By none of this many walls yet.
    fn by(walls: usize) -> Self {
        let colors = usize::from(COLORS);
        let classes = vec![false; usize::from(NO_WALL) + 1];
        Self { classes, of_color: [0; COLORS as usize], most_of_color: walls.div_ceil(colors) }
    }

    fn allows(&self, class: u16) -> bool {
        !self.classes[usize::from(class)] && self.of_color[usize::from(class % COLORS)] < self.most_of_color
    }

    fn take(&mut self, class: u16) -> u16 {
        self.classes[usize::from(class)] = true;
        self.of_color[usize::from(class % COLORS)] += 1;
        class
    }
}

/// Each item with the number of its occurrences, in order.
pub(crate) fn counts<T: Ord + Copy>(items: impl Iterator<Item = T>) -> Vec<(T, usize)> {
    let mut items: Vec<T> = items.collect();
    items.sort_unstable();
    items.chunk_by(T::eq).map(|same| (same[0], same.len())).collect()
}

/// The wall that is seen in each direction.
pub(crate) fn by_direction(frame: &Frame) -> Vec<Option<u32>> {
    let mut places = vec![None; BINS];
    for (i, wall) in frame.junction.wall_of_return.iter().enumerate().take(frame.revolution.len()) {
        let turn = frame.revolution.bearing_rad(i).rem_euclid(TAU) / TAU;
        let place = &mut places[((turn * BINS as f64) as usize).min(BINS - 1)];
        *place = wall.or(*place);
    }
    places
}

fn number_of_walls(frame: &Frame) -> usize {
    let last = frame.junction.wall_of_return.iter().flatten().max();
    last.map_or(0, |&last| last as usize + 1).max(frame.junction.walls.len())
}

/// The place of a direction among those of 10° a side.
fn place_of(towards: &Vector3<f64>) -> usize {
    const COLUMNS: f64 = 36.0;
    let turn = (towards.y.atan2(towards.x) / TAU).rem_euclid(1.0);
    let height = towards.z.clamp(-1.0, 1.0).asin() / PI + 0.5;
    let [row, column] = [0.5 * COLUMNS * height, COLUMNS * turn].map(f64::floor);
    (row.min(0.5 * COLUMNS - 1.0) * COLUMNS + column.min(COLUMNS - 1.0)) as usize
}

/// The class that most rows of each cluster have, of those that have one; none if most have none.
fn most_of_clusters(rows: impl Iterator<Item = (Option<u32>, Option<u16>)>, frame: &Frame) -> Vec<u16> {
    let mut most = vec![(0, NO_WALL); frame.partition.clusters];
    for ((cluster, class), count) in counts(rows.filter_map(|(label, class)| Some((label?, class.unwrap_or(NO_WALL)))))
    {
        // Of two classes with equally many rows, the first counts.
        if let Some(most) = most.get_mut(cluster as usize).filter(|(least, _)| count > *least) {
            *most = (count, class);
        }
    }
    most.into_iter().map(|(_, class)| class).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    /// A revolution whose walls span these directions, in degrees.
    fn frame(walls: &[(u32, std::ops::Range<i32>)]) -> Frame {
        let mut frame = Frame::default();
        for (wall, span) in walls {
            for degree in span.clone() {
                let (sin, cos) = f64::from(degree).to_radians().sin_cos();
                frame.revolution.points_m.push(Point::new(3.0 * cos, 3.0 * sin, 0.0));
                frame.junction.wall_of_return.push(Some(*wall));
            }
        }
        frame
    }

    #[test]
    fn a_renumbered_wall_keeps_its_class() {
        let mut tracks = Tracks::default();
        assert_eq!(tracks.classes_of(&frame(&[(0, 0..100), (1, 120..300)])).walls, [0, 1]);
        assert_eq!(tracks.classes_of(&frame(&[(0, 125..305), (1, 5..105)])).walls, [1, 0]);
    }

    #[test]
    fn the_larger_part_of_a_broken_wall_keeps_the_class() {
        let mut tracks = Tracks::default();
        tracks.classes_of(&frame(&[(0, 0..180), (1, 190..350)]));
        assert_eq!(tracks.classes_of(&frame(&[(0, 0..60), (1, 70..180), (2, 190..350)])).walls, [2, 0, 1]);
        assert_eq!(tracks.classes_of(&frame(&[(0, 0..180), (1, 190..350)])).walls, [0, 1], "joined again");
    }

    #[test]
    fn a_hidden_wall_comes_back_with_its_class() {
        let mut tracks = Tracks::default();
        tracks.classes_of(&frame(&[(0, 0..100), (1, 120..300)]));
        for _ in 0..5 {
            tracks.classes_of(&frame(&[(0, 120..300)]));
        }
        assert_eq!(tracks.classes_of(&frame(&[(0, 0..100), (1, 120..300)])).walls, [0, 1]);
        assert!(tracks.classes_of(&frame(&[])).walls.is_empty());
    }

    #[test]
    fn more_walls_than_colours_have_a_class_each() {
        let spans: Vec<_> =
            (0..20u32).map(|wall| (wall, 18 * wall.cast_signed()..18 * wall.cast_signed() + 9)).collect();
        let mut walls = Tracks::default().classes_of(&frame(&spans)).walls;
        let beside = walls.iter().zip(walls.iter().cycle().skip(1));
        assert!(beside.clone().all(|(a, b)| a % COLORS != b % COLORS), "neighbours differ: {walls:?}");
        walls.sort_unstable();
        walls.dedup();
        assert_eq!(walls.len(), 20);
    }

    #[test]
    fn no_two_of_few_walls_share_a_colour_after_many() {
        let mut tracks = Tracks::default();
        let of = |walls: i32| -> Vec<_> {
            let span_deg = 360 / walls;
            (0..walls).map(|wall| (wall.cast_unsigned(), wall * span_deg..wall * span_deg + span_deg / 2)).collect()
        };
        for walls in [9, 3, 7, 5, 4, 8, 5] {
            let classes = tracks.classes_of(&frame(&of(walls))).walls;
            let colors: std::collections::BTreeSet<_> = classes.iter().map(|class| class % COLORS).collect();
            assert!(walls > i32::from(COLORS) || colors.len() == classes.len(), "{classes:?}");
        }
    }

    #[test]
    fn a_cluster_has_the_class_of_most_of_its_returns() {
        let mut frame = frame(&[(0, 0..10), (1, 20..30)]);
        frame.junction.wall_of_return[12..].fill(None);
        frame.partition.labels = (0..20).map(|i| Some(u32::from(i >= 8))).collect();
        frame.partition.clusters = 2;
        let classes = Tracks::default().classes_of(&frame);
        assert_eq!([classes.of_cluster(Some(0)), classes.of_cluster(Some(1))], [0, NO_WALL]);
        assert_eq!([classes.of_cluster(None), classes.of_wall(None), classes.of_wall(Some(9))], [NO_WALL; 3]);
    }
}
