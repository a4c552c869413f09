//! Clouds of 3D lidars in a mesh.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Rotation3, Vector3};
use rand::RngExt as _;
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use super::mesh::Mesh;

/// A pattern of beams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lidar {
    /// The whole sphere, 128 x 512.
    Full,
    /// 64 x 512 beams from -22.5 to 22.5 degrees.
    Rings64,
    /// 16 x 1800 beams from -15 to 15 degrees.
    Vlp16,
    /// 20,000 beams from -7 to 52 degrees in a pattern that is no grid.
    Sparse,
}

impl Lidar {
    pub const ALL: [Self; 4] = [Self::Full, Self::Rings64, Self::Vlp16, Self::Sparse];

    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full sphere, 128 x 512",
            Self::Rings64 => "64 x 512, ±22.5°",
            Self::Vlp16 => "16 x 1800, ±15°",
            Self::Sparse => "20,000 in no grid, -7° to 52°",
        }
    }

    /// The lowest and the highest elevation that it looks at, degrees.
    pub fn view_deg(self) -> [f64; 2] {
        match self {
            Self::Full => [-90.0, 90.0],
            Self::Rings64 => [-22.5, 22.5],
            Self::Vlp16 => [-15.0, 15.0],
            Self::Sparse => [-7.0, 52.0],
        }
    }

    /// Its view, and before and after it that less and more by so much at both edges, where it has edges.
    pub fn views_deg(self, edge_deg: f64) -> Vec<[f64; 2]> {
        let [low, high] = self.view_deg();
        let less: &[f64] = if self == Self::Full { &[0.0] } else { &[edge_deg, 0.0, -edge_deg] };
        less.iter().map(|less| [low + less, high - less]).collect()
    }

    /// Unit vectors of its beams.
    fn beams(self) -> Vec<Vector3<f64>> {
        let [low, high] = self.view_deg().map(f64::to_radians);
        let towards = |bearing_rad: f64, elevation_rad: f64| {
            let (up, out) = elevation_rad.sin_cos();
            Vector3::new(out * bearing_rad.cos(), out * bearing_rad.sin(), up)
        };
        let grid = |rings: usize, columns: usize, inset: f64| {
            let ring =
                move |ring: usize| low + (high - low) * (ring as f64 + inset) / (rings as f64 - 1.0 + 2.0 * inset);
            (0..rings * columns)
                .map(|at| towards((at % columns) as f64 / columns as f64 * TAU - PI, ring(at / columns)))
                .collect()
        };
        match self {
            Self::Full => grid(128, 512, 0.5),
            Self::Rings64 => grid(64, 512, 0.0),
            Self::Vlp16 => grid(16, 1800, 0.0),
            Self::Sparse => {
                let share = |at: usize, step: f64| (at as f64 * step).fract();
                (0..20_000)
                    .map(|at| {
                        towards(share(at, 0.754_877_666) * TAU - PI, low + (high - low) * share(at, 0.569_840_29))
                    })
                    .collect()
            }
        }
    }

    /// What it sees from a place: points in its own frame, turned by `turned` from the mesh's, with all that lidars do.
    /// Also the share of beams that leave the mesh.
    pub fn cloud_m(
        self,
        mesh: &Mesh,
        place_m: &Point3<f64>,
        turned: &Rotation3<f64>,
        random: &mut Pcg64,
    ) -> Vec<Point3<f64>> {
        let mut points_m = Vec::new();
        let own = towards_own(random);
        for beam in self.beams() {
            let mut range_m = mesh.range_m(place_m, &(turned * beam));
            if !range_m.is_finite() || range_m > 60.0 || random.random_bool(0.02) {
                continue;
            }
            range_m += 0.02 * random.sample::<f64, _>(StandardNormal);
            if random.random_bool(0.005) {
                range_m *= random.random_range(0.1..0.9);
            }
            if own.iter().any(|(part, cos)| part.dot(&beam) > *cos) {
                range_m = random.random_range(0.15..0.28);
            }
            points_m.push(Point3::from(beam * range_m.max(0.05)));
        }
        points_m
    }
}

/// Parts of the vehicle: posts below the sensor.
fn towards_own(random: &mut Pcg64) -> Vec<(Vector3<f64>, f64)> {
    let posts = random.random_range(0..3);
    let post = |_| {
        let bearing_rad = random.random_range(-PI..PI);
        (Vector3::new(bearing_rad.cos(), bearing_rad.sin(), -0.7).normalize(), f64::cos(0.06))
    };
    (0..posts).map(post).collect()
}
