//! Edges of the visible free space that the vehicle can pass.
//!
//! Going around the sensor anticlockwise, every two returns p, q that follow each other (returns of no wall skipped)
//! bound an edge. It is an opening when
//!
//! 1. ‖p - q‖ is at least the vehicle's width,
//! 2. it is not merely a sparse stretch of one wall, whose returns at grazing incidence are metres apart but all on
//!    one line: either the two belong to different walls and beams between them came back with nothing
//!    ([`Evidence::NoReturn`]), or neither wall goes on along its own line across the edge;
//! 3. a strip of the vehicle's width that leaves the edge outward meets no return for [`DEPTH_M`];
//! 4. some beam between them is known: a masked sector is no opening, nor is what lies outside a limited view.
//!
//! Edges that lead into the same branch (a stray return deep inside it splits its edge in two) are one opening.
//!
//! That is [`Rule::FreeSpace`], for walls of any origin. Where walls are known to end at openings and nowhere else,
//! [`Rule::BetweenWalls`] takes every edge between two different walls, so that the two agree. One wall all around has
//! at most one opening then, the widest of those in free space.

use crosscut_stage::{Beam, Evidence, Opening, Point, Revolution, Sweep};
use nalgebra::Vector2;

/// The free space beyond an opening is at least this deep, or not seen to be shallower.
pub const DEPTH_M: f64 = 3.0;

/// An opening's bearing and width are taken at most this far from the sensor.
pub const LOOKOUT_M: f64 = 8.0;

/// The line of a wall behind its end is taken over this stretch.
const LINE_M: f64 = 1.5;

/// Which edges are openings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// Those through which the vehicle fits into free space.
    #[default]
    FreeSpace,
    /// Those between two walls.
    BetweenWalls,
}

/// Finds openings; holds its buffers from one revolution to the next.
#[derive(Clone, Debug, Default)]
pub struct Finder {
    rule: Rule,
    /// Returns that belong to a wall, anticlockwise around the sensor.
    ring: Vec<usize>,
}

/// An opening with the middle of its mouth.
struct Branch {
    opening: Opening,
    middle_m: Point,
}

impl Branch {
    /// Whether both lead into the same branch: their mouths overlap.
    fn is_same_way_as(&self, other: &Self) -> bool {
        let narrower_m = self.opening.width_m.min(other.opening.width_m);
        (self.middle_m - other.middle_m).norm() < narrower_m / 2.0
    }

    /// Takes up the next edge anticlockwise of the same branch. The longer edge says where the mouth is.
    fn join(&mut self, next: Self) {
        let (clockwise, anticlockwise) = (&self.opening, &next.opening);
        let walls = [clockwise.walls[0], anticlockwise.walls[1]];
        let edge_m = [clockwise.edge_m[0], anticlockwise.edge_m[1]];
        let length_m = |opening: &Opening| (opening.edge_m[0] - opening.edge_m[1]).norm();
        if length_m(anticlockwise) > length_m(clockwise) {
            *self = next;
        }
        self.opening.walls = walls;
        self.opening.edge_m = edge_m;
    }
}

/// Two returns that follow each other around the sensor, by their places in the ring.
struct Edge {
    clockwise: usize,
    anticlockwise: usize,
}

impl Finder {
    /// By a rule.
    pub fn new(rule: Rule) -> Self {
        Self { rule, ring: Vec::new() }
    }

    /// Writes the openings between the walls of `revolution`, by bearing ascending.
    ///
    /// `wall_of_return` has n entries. Without beam geometry (a cloud) there is no free space to see: no openings.
    pub fn find(
        &mut self,
        revolution: &Revolution,
        vehicle_width_m: f64,
        wall_of_return: &[Option<u32>],
        out: &mut Vec<Opening>,
    ) {
        out.clear();
        let Some(sweep) = &revolution.sweep else { return };
        let ring_beams = self.order(sweep, wall_of_return);
        let one_wall = self.ring.windows(2).all(|pair| wall_of_return[pair[0]] == wall_of_return[pair[1]]);
        let between_walls = self.rule == Rule::BetweenWalls && !one_wall;
        let view = View { revolution, sweep, vehicle_width_m, wall_of_return, ring: &self.ring, between_walls };
        let edges = if sweep.full_turn { self.ring.len() } else { self.ring.len().saturating_sub(1) };
        let mut branches: Vec<Branch> = Vec::new();
        for clockwise in 0..edges {
            let edge = Edge { clockwise, anticlockwise: (clockwise + 1) % self.ring.len() };
            let between = beams_between(&ring_beams, &edge, sweep.len());
            let Some(branch) = view.branch(&edge, between) else { continue };
            match branches.last_mut() {
                Some(last) if !between_walls && last.is_same_way_as(&branch) => last.join(branch),
                _ => branches.push(branch),
            }
        }
        if let [first, .., last] = branches.as_slice()
            && !between_walls
            && last.is_same_way_as(first)
        {
            let mut joined = branches.pop().expect("two at least");
            joined.join(branches.swap_remove(0));
            branches.push(joined);
        }
        if self.rule == Rule::BetweenWalls && one_wall {
            let widest = (branches.into_iter()).max_by(|a, b| a.opening.width_m.total_cmp(&b.opening.width_m));
            branches = widest.filter(|_| sweep.full_turn).into_iter().collect();
        }
        out.extend(branches.into_iter().map(|branch| branch.opening));
        out.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
    }

    /// Fills the ring and returns each entry's beam, both anticlockwise.
    fn order(&mut self, sweep: &Sweep, wall_of_return: &[Option<u32>]) -> Vec<BeamIndex> {
        self.ring.clear();
        let mut beams: Vec<BeamIndex> = Vec::with_capacity(wall_of_return.len());
        for (beam, seen) in sweep.beams.iter().enumerate() {
            if let Beam::Return(i) = *seen
                && wall_of_return[i as usize].is_some()
            {
                self.ring.push(i as usize);
                beams.push(BeamIndex { beam, anticlockwise: true });
            }
        }
        if sweep.is_clockwise() {
            self.ring.reverse();
            beams.reverse();
            beams.iter_mut().for_each(|b| b.anticlockwise = false);
        }
        beams
    }
}

#[derive(Clone, Copy)]
struct BeamIndex {
    beam: usize,
    anticlockwise: bool,
}

/// The beams strictly between the two ends of an edge.
fn beams_between<'a>(
    ring_beams: &'a [BeamIndex],
    edge: &Edge,
    beams: usize,
) -> impl Iterator<Item = usize> + Clone + use<'a> {
    let (from, to) = (ring_beams[edge.clockwise], ring_beams[edge.anticlockwise]);
    let step = if from.anticlockwise { 1 } else { beams - 1 };
    let count = if from.anticlockwise { to.beam + beams - from.beam } else { from.beam + beams - to.beam };
    let count = (count - 1) % beams;
    (1..=count).map(move |s| (from.beam + s * step) % beams)
}

/// One revolution seen as a ring of wall returns.
struct View<'a> {
    revolution: &'a Revolution,
    sweep: &'a Sweep,
    vehicle_width_m: f64,
    wall_of_return: &'a [Option<u32>],
    ring: &'a [usize],
    /// Whether an edge between two walls is an opening, and no other is.
    between_walls: bool,
}

impl View<'_> {
    fn point(&self, place: usize) -> Point {
        self.revolution.points_m[self.ring[place]]
    }

    fn wall(&self, place: usize) -> u32 {
        self.wall_of_return[self.ring[place]].expect("the ring holds returns of walls")
    }

    fn range_m(&self, place: usize) -> f64 {
        self.revolution.range_m(self.ring[place])
    }

    fn branch(&self, edge: &Edge, between: impl Iterator<Item = usize> + Clone) -> Option<Branch> {
        let (p, q) = (self.point(edge.clockwise), self.point(edge.anticlockwise));
        let walls = [self.wall(edge.clockwise), self.wall(edge.anticlockwise)];
        if self.between_walls {
            if walls[0] == walls[1] {
                return None;
            }
        } else if (p - q).norm() < self.vehicle_width_m {
            return None;
        }
        let beams = between.clone().count();
        let unknown = between.clone().filter(|&beam| self.sweep.beams[beam] == Beam::Unknown).count();
        if beams > 0 && unknown == beams {
            return None;
        }
        let dark = between.clone().any(|beam| self.sweep.beams[beam] == Beam::NoReturn);
        let in_free_space = || ((dark && walls[0] != walls[1]) || self.leaves_the_line(edge)) && self.deep(p, q);
        if !self.between_walls && !in_free_space() {
            return None;
        }
        let [a, b] = self.mouth(edge);
        let middle_m = nalgebra::center(&a, &b);
        let opening = Opening {
            bearing_rad: middle_m.y.atan2(middle_m.x),
            width_m: (a - b).norm(),
            walls,
            evidence: if dark { Evidence::NoReturn } else { Evidence::SeenThrough },
            edge_m: [p, q],
        };
        Some(Branch { opening, middle_m })
    }

    /// Whether neither wall goes on along its own line across the edge, so that the vehicle can pass between them:
    /// the nearer end clears the line of the farther wall by the vehicle's width, and the farther end leaves the line
    /// of the nearer wall by half of it.
    fn leaves_the_line(&self, edge: &Edge) -> bool {
        let ends = [(edge.clockwise, true), (edge.anticlockwise, false)];
        let (near, far) = if self.range_m(edge.clockwise) <= self.range_m(edge.anticlockwise) {
            (ends[0], ends[1])
        } else {
            (ends[1], ends[0])
        };
        self.distance_from_line_m(far, self.point(near.0)) >= self.vehicle_width_m
            && self.distance_from_line_m(near, self.point(far.0)) >= self.vehicle_width_m / 2.0
    }

    /// Distance of a point from the line of the wall that ends at `place`; 0 where the wall has no direction.
    fn distance_from_line_m(&self, (place, backwards): (usize, bool), point: Point) -> f64 {
        let end = self.point(place);
        let along = (end - self.stretch_start(place, backwards)).xy();
        let across = along.perp(&(point - end).xy()).abs() / along.norm();
        if across.is_nan() { 0.0 } else { across }
    }

    /// The return of the same wall about [`LINE_M`] before its end at `place`.
    fn stretch_start(&self, place: usize, backwards: bool) -> Point {
        let end = self.point(place);
        self.along_wall(place, backwards)
            .map(|at| self.point(at))
            .find(|p| (p - end).norm() >= LINE_M)
            .unwrap_or_else(|| self.along_wall(place, backwards).last().map_or(end, |at| self.point(at)))
    }

    /// The places of one wall from its end at `place` onward, away from the edge, half way round the ring at most.
    fn along_wall(&self, place: usize, backwards: bool) -> impl Iterator<Item = usize> {
        let (n, wall) = (self.ring.len(), self.wall(place));
        let step = if backwards { n - 1 } else { 1 };
        (0..n.div_ceil(2)).map(move |s| (place + s * step) % n).take_while(move |&at| self.wall(at) == wall)
    }

    /// Whether a strip of the vehicle's width that leaves the edge outward meets no return for [`DEPTH_M`].
    fn deep(&self, p: Point, q: Point) -> bool {
        let middle = nalgebra::center(&p, &q).xy();
        let edge = (q - p).xy();
        let normal = Vector2::new(edge.y, -edge.x).normalize();
        // The edge runs anticlockwise around the sensor, so its right-hand normal points outward.
        !self.revolution.points_m.iter().any(|point| {
            let ahead = point.xy() - middle;
            let depth_m = ahead.dot(&normal);
            let aside_m = ahead.dot(&edge) / edge.norm();
            depth_m > 0.0 && depth_m < DEPTH_M && aside_m.abs() < self.vehicle_width_m / 2.0
        })
    }

    /// The two ends of the shortest line across the branch, at most [`LOOKOUT_M`] from the sensor.
    ///
    /// From the last return of each side within that distance to the nearest return of the other side; the shorter of
    /// the two.
    fn mouth(&self, edge: &Edge) -> [Point; 2] {
        let crossing = |place: usize, backwards: bool, other: usize| {
            let within = self.along_wall(place, backwards).find(|&at| self.range_m(at) <= LOOKOUT_M);
            let anchor = self.point(within.unwrap_or(place));
            let distance = |at: &usize| (self.point(*at) - anchor).norm();
            let opposite = self.along_wall(other, !backwards).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            [anchor, self.point(opposite.unwrap_or(other))]
        };
        let from_clockwise = crossing(edge.clockwise, true, edge.anticlockwise);
        let from_anticlockwise = crossing(edge.anticlockwise, false, edge.clockwise);
        let length_m = |[a, b]: [Point; 2]| (a - b).norm();
        if length_m(from_clockwise) <= length_m(from_anticlockwise) { from_clockwise } else { from_anticlockwise }
    }
}
