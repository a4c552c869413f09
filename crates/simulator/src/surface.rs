//! The rough surface of the rock as short segments, and ray casting.

use rand::RngExt;
use rand_distr::{Distribution, Exp1};

use crate::grid::Grid;
use crate::network::{Network, Point, Vector, left_of};
use crate::noise::{Generator, around_closed_chain, generator};
use crate::outline;
pub use crate::segment::Segment;

/// Largest length of a segment, metres.
const STEP_M: f64 = 0.1;

/// Roughness and wetness of the rock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Standard deviation of the bumps along the normal.
    pub bump_sd_m: f64,
    /// Length over which bumps are correlated: exp(-s²/2ℓ²) at distance s along the wall.
    pub bump_length_m: f64,
    /// Share of the surface that is wet, in patches.
    pub wet_share: f64,
    /// Mean length of a wet patch along the wall.
    pub wet_length_m: f64,
}

impl Texture {
    /// Walls without bumps, all dry.
    pub const SMOOTH: Self = Self { bump_sd_m: 0.0, bump_length_m: 1.0, wet_share: 0.0, wet_length_m: 1.0 };
}

/// The surface of all rock.
#[derive(Clone, Debug)]
pub struct Surface {
    segments: Vec<Segment>,
    grid: Grid,
}

/// The place where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the origin of the ray.
    pub range_m: f64,
    /// Index of the segment.
    pub segment: usize,
}

impl Surface {
    /// The surface of a mine, with bumps and wet patches drawn from `seed`.
    pub fn new(network: &Network, texture: &Texture, seed: u64) -> Self {
        let mut rng = generator(seed, "surface");
        let mut segments = Vec::new();
        for contour in outline::rock(network) {
            append(&contour, None, texture, &mut rng, &mut segments);
        }
        for (pillar, disc) in network.pillars.iter().enumerate() {
            // The bumps of a pillar are small relative to its radius.
            let bump_sd_m = texture.bump_sd_m.min(0.1 * disc.radius_m);
            let bump_length_m = texture.bump_length_m.min(0.5 * disc.radius_m);
            let texture = Texture { bump_sd_m, bump_length_m, ..*texture };
            let contour = outline::circle(disc.centre_m, disc.radius_m);
            append(&contour, Some(pillar as u32), &texture, &mut rng, &mut segments);
        }
        let grid = Grid::new(&segments);
        Self { segments, grid }
    }

    /// All segments.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The nearest surface from `origin_m` along the unit vector `direction`, up to `limit_m`.
    pub fn cast(&self, origin_m: Point, direction: Vector, limit_m: f64) -> Option<Hit> {
        self.cast_at(origin_m, direction, limit_m, |_| true)
    }

    /// The nearest surface along a ray, as [`Surface::cast`], that is no pillar.
    pub fn cast_past_pillars(&self, origin_m: Point, direction: Vector, limit_m: f64) -> Option<Hit> {
        self.cast_at(origin_m, direction, limit_m, |segment| segment.pillar.is_none())
    }

    /// Whether no rock stands between two points.
    pub fn sees(&self, from_m: Point, to_m: Point) -> bool {
        let distance_m = (to_m - from_m).norm();
        distance_m == 0.0 || self.cast(from_m, (to_m - from_m) / distance_m, distance_m).is_none()
    }

    /// Distance from a point to the nearest surface, or `limit_m` if that is less.
    pub fn clearance_m(&self, point_m: Point, limit_m: f64) -> f64 {
        self.segments.iter().map(|segment| segment.distance_m(point_m)).fold(limit_m, f64::min)
    }

    /// Whether a disc touches the surface.
    pub fn touches(&self, centre_m: Point, radius_m: f64) -> bool {
        let is_met = |segment: u32| self.segments[segment as usize].distance_m(centre_m) < radius_m;
        self.grid.near(centre_m, radius_m).any(is_met)
    }

    fn cast_at(
        &self,
        origin_m: Point,
        direction: Vector,
        limit_m: f64,
        is_solid: impl Fn(&Segment) -> bool,
    ) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.grid.walk(origin_m, direction, limit_m, |cell, leave_m| {
            for &index in cell {
                let segment = &self.segments[index as usize];
                let reach_m = nearest.map_or(limit_m, |hit| hit.range_m);
                if let Some(range_m) = segment.meets(origin_m, direction)
                    && range_m <= reach_m
                    && is_solid(segment)
                {
                    nearest = Some(Hit { range_m, segment: index as usize });
                }
            }
            // A segment may be met in a later cell. The hit is final once the ray has left its cell.
            nearest.is_none_or(|hit| hit.range_m > leave_m)
        });
        nearest
    }
}

/// Adds one closed contour, cut into segments and displaced along its normal.
fn append(contour: &[Point], pillar: Option<u32>, texture: &Texture, rng: &mut Generator, segments: &mut Vec<Segment>) {
    let (mut chain, step_m) = resampled(contour, STEP_M);
    let n = chain.len();
    if texture.bump_sd_m > 0.0 {
        let bumps = around_closed_chain(n, step_m, texture.bump_length_m, rng);
        let normals: Vec<Vector> = (0..n)
            .map(|i| left_of(chain[(i + 1) % n] - chain[(i + n - 1) % n]))
            .map(|normal| normal.try_normalize(1e-12).unwrap_or_else(Vector::zeros))
            .collect();
        for i in 0..n {
            chain[i] += normals[i] * (texture.bump_sd_m * bumps[i]);
        }
    }
    let wet = wet_patches(n, step_m, texture, rng);
    segments.extend((0..n).map(|i| Segment { from_m: chain[i], to_m: chain[(i + 1) % n], pillar, wet: wet[i] }));
}

/// Returns a closed contour resampled at equal distances of at most `step_m`, and the distance.
fn resampled(contour: &[Point], step_m: f64) -> (Vec<Point>, f64) {
    let edge = |i: usize| (contour[i], contour[(i + 1) % contour.len()]);
    let perimeter_m: f64 = (0..contour.len()).map(|i| (edge(i).1 - edge(i).0).norm()).sum();
    let n = (perimeter_m / step_m).ceil().max(3.0) as usize;
    let step_m = perimeter_m / n as f64;
    let mut points = Vec::with_capacity(n);
    let mut walked_m = 0.0;
    for i in 0..contour.len() {
        let (from, to) = edge(i);
        let length_m = (to - from).norm();
        while points.len() < n && points.len() as f64 * step_m < walked_m + length_m {
            points.push(from + (to - from) * ((points.len() as f64 * step_m - walked_m) / length_m));
        }
        walked_m += length_m;
    }
    (points, step_m)
}

/// Draws which of `n` segments along a wall are wet: dry and wet stretches alternate, with exponential lengths.
fn wet_patches(n: usize, step_m: f64, texture: &Texture, rng: &mut Generator) -> Vec<bool> {
    if texture.wet_share <= 0.0 {
        return vec![false; n];
    }
    let dry_length_m = texture.wet_length_m * (1.0 - texture.wet_share) / texture.wet_share;
    let mut wet = Vec::with_capacity(n);
    let mut is_wet = rng.random_bool(texture.wet_share.min(1.0));
    while wet.len() < n {
        let mean_m = if is_wet { texture.wet_length_m } else { dry_length_m };
        let draw: f64 = Exp1.sample(rng);
        let steps = (draw * mean_m / step_m).round() as usize;
        wet.extend(std::iter::repeat_n(is_wet, steps.min(n - wet.len())));
        is_wet = !is_wet;
    }
    wet
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::{bent, half_widths};
    use crosscut_stage::unit;

    use crate::network::Disc;

    fn winding() -> Network {
        let mut rng = generator(5, "winding");
        let mut network = Network::new(4.0);
        let node = network.add_node(Point::new(3.0, -2.0));
        for heading_rad in [0.3, 2.0, 4.4] {
            let line = bent(Point::new(3.0, -2.0), heading_rad, 18.0, 0.02);
            let widths = half_widths(line.len(), 1.7, 0.1, &mut rng);
            network.add_branch(node, line, widths);
        }
        network.pillars.push(Disc { centre_m: Point::new(6.0, -1.0), radius_m: 0.4 });
        network
    }

    #[test]
    fn casting_with_and_without_the_grid_agrees() {
        let surface = Surface::new(&winding(), &Texture { bump_sd_m: 0.2, bump_length_m: 0.7, ..Texture::SMOOTH }, 1);
        let mut rng = generator(9, "rays");
        for _ in 0..3000 {
            let origin_m = Point::new(rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0));
            let direction = unit(rng.random_range(0.0..std::f64::consts::TAU));
            let limit_m = rng.random_range(0.5..40.0);
            let all = surface.segments.iter().filter_map(|segment| segment.meets(origin_m, direction));
            let wanted_m = all.filter(|&range_m| range_m <= limit_m).min_by(f64::total_cmp);
            let found_m = surface.cast(origin_m, direction, limit_m).map(|hit| hit.range_m);
            assert_eq!(found_m, wanted_m, "from {origin_m} towards {direction}");
        }
    }

    #[test]
    fn touching_with_and_without_the_grid_agrees() {
        let surface = Surface::new(&winding(), &Texture { bump_sd_m: 0.2, bump_length_m: 0.7, ..Texture::SMOOTH }, 1);
        let mut rng = generator(9, "discs");
        for _ in 0..3000 {
            let centre_m = Point::new(rng.random_range(-30.0..30.0), rng.random_range(-30.0..30.0));
            let radius_m = rng.random_range(0.1..3.0);
            let is_met = surface.clearance_m(centre_m, 100.0) < radius_m;
            assert_eq!(surface.touches(centre_m, radius_m), is_met, "a disc of {radius_m} m at {centre_m}");
        }
    }

    #[test]
    fn rays_along_the_grid_lines_hit_the_walls() {
        let mut network = Network::new(4.0);
        let start = network.add_node(Point::origin());
        network.add_branch(start, vec![Point::origin(), Point::new(10.0, 0.0)], vec![2.0; 2]);
        let surface = Surface::new(&network, &Texture::SMOOTH, 0);
        for (direction, wanted_m) in [((1.0, 0.0), 6.0), ((-1.0, 0.0), 4.0), ((0.0, 1.0), 2.0), ((0.0, -1.0), 2.0)] {
            let hit = surface.cast(Point::new(4.0, 0.0), Vector::new(direction.0, direction.1), 20.0).expect("a wall");
            assert!((hit.range_m - wanted_m).abs() < 1e-9, "{direction:?}: {}", hit.range_m);
        }
        assert!(!surface.sees(Point::new(4.0, 0.0), Point::new(4.0, 2.5)));
        assert!(surface.sees(Point::new(4.0, 0.0), Point::new(9.5, 1.5)));
    }

    #[test]
    fn the_outline_is_closed_and_segments_are_short() {
        let surface = Surface::new(&winding(), &Texture::SMOOTH, 1);
        let mut starts: Vec<(u64, u64)> = surface.segments.iter().map(|s| bits(s.from_m)).collect();
        let mut ends: Vec<(u64, u64)> = surface.segments.iter().map(|s| bits(s.to_m)).collect();
        starts.sort_unstable();
        ends.sort_unstable();
        assert_eq!(starts, ends, "every segment begins where another ends");
        assert!(surface.segments.iter().all(|s| (s.to_m - s.from_m).norm() <= STEP_M + 1e-9));
    }

    fn bits(point: Point) -> (u64, u64) {
        (point.x.to_bits(), point.y.to_bits())
    }

    #[test]
    fn bumps_and_wet_patches_have_the_stated_amounts() {
        let mut network = Network::new(4.0);
        let start = network.add_node(Point::origin());
        network.add_branch(start, vec![Point::origin(), Point::new(4000.0, 0.0)], vec![2.0; 2]);
        let texture = Texture { bump_sd_m: 0.3, bump_length_m: 1.0, wet_share: 0.25, wet_length_m: 1.5 };
        let surface = Surface::new(&network, &texture, 2);
        let wall: Vec<&Segment> = surface.segments.iter().filter(|s| (5.0..3995.0).contains(&s.from_m.x)).collect();
        let n = wall.len() as f64;
        let sd_m = (wall.iter().map(|s| (s.from_m.y.abs() - 2.0).powi(2)).sum::<f64>() / n).sqrt();
        assert!((sd_m - 0.3).abs() < 0.015, "bumps of {sd_m} m");
        let wet = wall.iter().filter(|s| s.wet).count() as f64 / n;
        assert!((wet - 0.25).abs() < 0.03, "{wet} is wet");
    }
}
