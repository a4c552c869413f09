//! Triangles, what a ray meets of them, and their files.

use std::path::Path;

use anyhow::Context;
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::ray::Ray;
use nalgebra::{Point3, Vector3};

type Corner = Point3<f64>;

/// Three corners, metres.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub corners_m: [Corner; 3],
    node: usize,
}

impl Bounded<f64, 3> for Triangle {
    fn aabb(&self) -> Aabb<f64, 3> {
        let [a, b, c] = self.corners_m;
        Aabb::with_bounds(a.inf(&b).inf(&c), a.sup(&b).sup(&c))
    }
}

impl BHShape<f64, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// Triangles that rays are cast at; z up.
pub struct Mesh {
    pub triangles: Vec<Triangle>,
    tree: Bvh<f64, 3>,
}

impl Mesh {
    pub fn new(corners_m: impl IntoIterator<Item = [Corner; 3]>) -> Self {
        let mut triangles: Vec<_> = corners_m.into_iter().map(|corners_m| Triangle { corners_m, node: 0 }).collect();
        let tree = Bvh::build(&mut triangles);
        Self { triangles, tree }
    }

    /// A binary STL with z up, or an OBJ with y up, of this many metres a unit.
    pub fn read(path: &Path, metres: f64) -> anyhow::Result<Self> {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        let mesh = if path.extension().is_some_and(|ending| ending == "stl") { stl(&bytes) } else { obj(&bytes) };
        let mesh = mesh.with_context(|| format!("{} is no mesh", path.display()))?;
        Ok(Self::new(mesh.into_iter().map(|corners| corners.map(|corner| corner * metres))))
    }

    /// The lowest and the highest corner of its box.
    pub fn bounds_m(&self) -> [Corner; 2] {
        let corners = || self.triangles.iter().flat_map(|triangle| triangle.corners_m);
        let far = f64::INFINITY;
        [
            corners().fold(Corner::new(far, far, far), |low, corner| low.inf(&corner)),
            corners().fold(Corner::new(-far, -far, -far), |high, corner| high.sup(&corner)),
        ]
    }

    /// How far the first triangle in a direction is, metres; infinite if there is none.
    pub fn range_m(&self, from_m: &Corner, towards: &Vector3<f64>) -> f64 {
        let ray = Ray::new(*from_m, *towards);
        let met =
            self.tree.traverse_iterator(&ray, &self.triangles).map(|Triangle { corners_m: [a, b, c], .. }| {
                // The crate sees front sides alone; a mesh need not agree which side that is.
                ray.intersects_triangle(a, b, c).distance.min(ray.intersects_triangle(a, c, b).distance)
            });
        met.fold(f64::INFINITY, f64::min)
    }
}

fn stl(bytes: &[u8]) -> Option<Vec<[Corner; 3]>> {
    let number = |bytes: &[u8]| Some(f64::from(f32::from_le_bytes(bytes.try_into().ok()?)));
    let corner = |bytes: &[u8]| Some(Corner::new(number(&bytes[..4])?, number(&bytes[4..8])?, number(&bytes[8..])?));
    let triangle = |of: &[u8]| Some([corner(&of[12..24])?, corner(&of[24..36])?, corner(&of[36..48])?]);
    bytes.get(84..)?.chunks_exact(50).map(triangle).collect()
}

fn obj(bytes: &[u8]) -> Option<Vec<[Corner; 3]>> {
    let text = String::from_utf8_lossy(bytes);
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next()?.parse().ok();
                let [x, y, z] = [number()?, number()?, number()?];
                corners.push(Corner::new(x, -z, y));
            }
            Some("f") => {
                let at = |word: &str| {
                    let at: isize = word.split('/').next()?.parse().ok()?;
                    corners.get(if at < 0 { corners.len().checked_add_signed(at)? } else { at as usize - 1 }).copied()
                };
                let face: Vec<Corner> = words.map(at).collect::<Option<_>>()?;
                triangles.extend(face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Some(triangles)
}
