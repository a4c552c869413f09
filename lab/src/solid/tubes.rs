//! Networks of tubes in rock: level galleries, ramps, raises and winzes, and tubes that cross above each other.

use std::f64::consts::{PI, TAU};

use fast_surface_nets::ndshape::{RuntimeShape, Shape as _};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use nalgebra::{Point3, Rotation3, Vector3};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64;

use super::mesh::Mesh;

struct Tube {
    from_m: Point3<f64>,
    to_m: Point3<f64>,
    radius_m: f64,
    /// A level tube has a floor this far below its axis.
    floor_m: Option<f64>,
}

impl Tube {
    /// Negative inside.
    fn distance_m(&self, at_m: &Point3<f64>) -> f64 {
        let axis = self.to_m - self.from_m;
        let share = ((at_m - self.from_m).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
        let middle_m = self.from_m + axis * share;
        let wall_m = (at_m - middle_m).norm() - self.radius_m;
        self.floor_m.map_or(wall_m, |floor_m| wall_m.max(middle_m.z - floor_m - at_m.z))
    }
}

/// A network, as its tubes and the roughness of its rock.
pub struct Network {
    tubes: Vec<Tube>,
    waves: Vec<(Vector3<f64>, f64, f64)>,
    grid_m: f64,
}

const KINDS: [&str; 3] = ["level", "ramp", "shaft"];

fn sign(random: &mut Pcg64) -> f64 {
    if random.random() { 1.0 } else { -1.0 }
}

impl Network {
    /// The network of a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut tubes = Vec::new();
        let usual_m = random.random_range(1.0..2.5);
        let mut nodes = vec![(Point3::origin(), 0)];
        let mut done = 0;
        while let Some(&(node_m, depth)) = nodes.get(done) {
            done += 1;
            let arms = if depth == 0 { 2 + random.random_range(0..4) } else { 1 + random.random_range(0..3) };
            let mut taken: Vec<Vector3<f64>> = tubes
                .iter()
                .filter(|tube: &&Tube| tube.to_m == node_m)
                .map(|tube| (tube.from_m - tube.to_m).normalize())
                .collect();
            for _ in 0..arms {
                let kind = KINDS[[0, 0, 0, 1, 1, 2][random.random_range(0..6)]];
                let towards = loop {
                    let elevation_rad = match kind {
                        "level" => random.random_range(-0.08..0.08),
                        "ramp" => sign(&mut random) * random.random_range(0.2..0.55),
                        _ => sign(&mut random) * random.random_range(1.25..1.57),
                    };
                    let (up, out) = f64::sin_cos(elevation_rad);
                    let bearing_rad = random.random_range(-PI..PI);
                    let towards = Vector3::new(out * bearing_rad.cos(), out * bearing_rad.sin(), up);
                    let apart = taken.iter().all(|other| other.dot(&towards) < f64::cos(0.9));
                    if apart || random.random_range(0..30) == 0 {
                        break apart.then_some(towards);
                    }
                };
                let Some(towards) = towards else { continue };
                taken.push(towards);
                let radius_m = usual_m * random.random_range(0.7..1.25);
                let to_m = node_m + towards * usual_m * random.random_range(4.5..7.0);
                let floor_m = (kind != "shaft").then(|| radius_m * random.random_range(0.6..1.0));
                tubes.push(Tube { from_m: node_m, to_m, radius_m, floor_m });
                if depth < 1 && random.random_range(0..3) > 0 {
                    nodes.push((to_m, depth + 1));
                }
            }
        }
        // A gallery above or below the first place, with rock between.
        if random.random_range(0..3) == 0 {
            let height_m = sign(&mut random) * usual_m * random.random_range(3.0..4.5);
            let bearing_rad = random.random_range(-PI..PI);
            let half = Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0) * 12.0;
            let middle = Point3::new(0.0, 0.0, height_m);
            tubes.push(Tube {
                from_m: middle - half,
                to_m: middle + half,
                radius_m: usual_m,
                floor_m: Some(0.8 * usual_m),
            });
        }
        let rough_m = usual_m * random.random_range(0.03..0.12);
        let waves = (0..24).map(|i| {
            let length_m = 0.7 * 1.15_f64.powi(i);
            let turned =
                Rotation3::from_euler_angles(random.random_range(0.0..TAU), random.random_range(0.0..TAU), 0.0);
            (
                turned * Vector3::x() * (TAU / length_m),
                random.random_range(0.0..TAU),
                rough_m * (length_m / 4.0).min(1.0),
            )
        });
        Self { waves: waves.collect(), tubes, grid_m: 0.2 }
    }

    fn distance_m(&self, at_m: &Point3<f64>) -> f64 {
        let clear_m = self.tubes.iter().map(|tube| tube.distance_m(at_m)).fold(f64::INFINITY, f64::min);
        if clear_m.abs() > 1.5 {
            return clear_m;
        }
        clear_m
            + self
                .waves
                .iter()
                .map(|(wave, phase, high_m)| high_m * f64::sin(wave.dot(&at_m.coords) + phase))
                .sum::<f64>()
    }

    /// Its rock.
    pub fn mesh(&self) -> Mesh {
        let ends = || self.tubes.iter().flat_map(|tube| [tube.from_m, tube.to_m]);
        let margin = Vector3::repeat(5.0);
        let low_m = ends().fold(Point3::origin(), |low, end| low.inf(&end)) - margin;
        let high_m = ends().fold(Point3::origin(), |high, end| high.sup(&end)) + margin;
        let size = [0, 1, 2].map(|axis| ((high_m[axis] - low_m[axis]) / self.grid_m) as u32 + 1);
        let shape = RuntimeShape::<u32, 3>::new(size);
        let place_m = |at: [f64; 3]| low_m + Vector3::from(at) * self.grid_m;
        let distances: Vec<f32> = (0..shape.usize() as u32)
            .map(|at| self.distance_m(&place_m(shape.delinearize(at).map(f64::from))) as f32)
            .collect();
        let mut out = SurfaceNetsBuffer::default();
        surface_nets(&distances, &shape, [0; 3], size.map(|count| count - 1), &mut out);
        let corner = |at: &u32| place_m(out.positions[*at as usize].map(f64::from));
        Mesh::new(out.indices.chunks_exact(3).map(|of| [corner(&of[0]), corner(&of[1]), corner(&of[2])]))
    }
}
