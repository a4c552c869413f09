//! The cloud of a lidar of many rings.

use crosscut_messages::Truth;

use crate::lidar::{Echo, Lidar};
use crate::mine::Mine;
use crate::noise::Generator;
use crate::pose::{Motion, Pose};
use crate::reading::Reading;

/// The rings of an upright 3D lidar halfway between floor and roof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rings {
    /// Number of rings, evenly spaced from `lowest_rad` to -`lowest_rad`. If it is odd, the middle ring is level.
    pub rings: usize,
    /// Elevation of the lowest ring, negative.
    pub lowest_rad: f64,
    /// Number of beams of a ring.
    pub beams: usize,
}

/// Points without beams, in the body frame; z = 0 is the height of the lidar.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloud {
    /// The returns, ring by ring.
    pub points_m: Vec<nalgebra::Point3<f64>>,
    /// The truth of the level view by the 2D lidar of the family.
    pub truth: Truth,
}

impl Rings {
    /// The points of all rings, with the errors of `lidar`. Walls are upright, floor and roof are level.
    pub(crate) fn points_m(
        &self,
        lidar: &Lidar,
        mine: &Mine,
        pose: Pose,
        rng: &mut Generator,
    ) -> Vec<nalgebra::Point3<f64>> {
        let lidar = Lidar { beams: self.beams, ..*lidar };
        let half_height_m = 0.5 * mine.network().height_m;
        let level = lidar.view(mine.surface(), mine.network().height_m, &Motion::still(pose));
        let mut points_m = Vec::new();
        for ring in 0..self.rings {
            let share = if self.rings > 1 { ring as f64 / (self.rings - 1) as f64 } else { 0.5 };
            let (sin, cos) = (self.lowest_rad * (1.0 - 2.0 * share)).sin_cos();
            let tilted = |echo: &Echo| tilted(*echo, half_height_m / sin.abs(), cos, lidar.range_max_m);
            let view: Vec<Echo> = level.iter().map(tilted).collect();
            for (beam, reading) in lidar.read(mine.surface(), &view, rng).into_iter().enumerate() {
                let (Reading::Echo(range_m) | Reading::Dust(range_m) | Reading::Mixed(range_m)) = reading else {
                    continue;
                };
                let bearing_rad = lidar.bearing_rad(beam as f64);
                let out_m = range_m * cos;
                points_m.push([out_m * bearing_rad.cos(), out_m * bearing_rad.sin(), range_m * sin].into());
            }
        }
        points_m
    }
}

/// The echo of a beam that goes up or down, derived from the level beam of the same bearing: the wall at the same place,
/// unless floor or roof is nearer.
fn tilted(level: Echo, floor_range_m: f64, cos: f64, range_max_m: f64) -> Echo {
    match level {
        Echo::Rock { range_m, segment, incidence_sine } if range_m / cos < floor_range_m.min(range_max_m) => {
            Echo::Rock { range_m: range_m / cos, segment, incidence_sine: incidence_sine * cos }
        }
        _ if floor_range_m < range_max_m => Echo::Floor { range_m: floor_range_m },
        _ => Echo::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use crate::{Rings, Split, suites};

    #[test]
    fn the_level_ring_of_a_cloud_agrees_with_the_2d_scan() {
        let suite = suites().iter().find(|suite| suite.name == "clean6").expect("there is one");
        let rings = Rings { rings: 9, lowest_rad: -0.4, beams: 360 };
        let clouds = suite.clouds(Split::Dev, rings).expect("places");
        for (cloud, scene) in clouds.zip(suite.scenes(Split::Dev)).take(10) {
            assert_eq!(cloud.truth.walls, scene.truth.walls);
            let z_m = || cloud.points_m.iter().map(|point| point.z);
            assert!(z_m().all(|z_m| z_m.abs() < 2.1), "the tunnel is 4 m high");
            assert!(z_m().filter(|z_m| *z_m > 1.9).count() > 100 && z_m().filter(|z_m| *z_m < -1.9).count() > 100);
            let level: Vec<f64> =
                cloud.points_m.iter().filter(|point| point.z == 0.0).map(|point| point.x.hypot(point.y)).collect();
            let seen: Vec<f64> =
                scene.scan.ranges.iter().filter(|range| range.is_finite()).map(|range| f64::from(*range)).collect();
            assert!(level.len().abs_diff(seen.len()) < 5, "{} and {}", level.len(), seen.len());
            let mean = |ranges: &[f64]| ranges.iter().sum::<f64>() / ranges.len() as f64;
            assert!((mean(&level) - mean(&seen)).abs() < 0.1, "{} m and {} m", mean(&level), mean(&seen));
        }
    }
}
