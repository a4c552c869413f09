//! How steep ways are, wherever in the place the sensor is.

use crosscut_stage::DisjointSets;
use nalgebra::Vector3;

use super::sight::{Seen, Sight};
use super::sphere::Sphere;
use super::ways::{Found, ON, components, within};

/// The slope of a way is that of the line from its middle at the first of these distances, in multiples of the room at the sensor, to
/// that at the second, or where the vehicle gets less far, at the third. The first two are those of the truth in a mesh.
const MIDDLES: [f64; 3] = [2.0, 3.0, ON];

/// What is seen of a way at a distance, as places about the sensor, in the frame of the sphere.
#[derive(Clone, Copy)]
struct Section {
    middle_m: Vector3<f64>,
    /// Height of its lower and its upper edge.
    edges_m: [f64; 2],
    /// The sensor does not look below, above.
    is_cut: [bool; 2],
}

/// The slope of each way, radians, where `up` is the vertical axis; `None` where it has no section that far.
pub(super) fn slopes_rad(
    sphere: &Sphere,
    sight: &Sight,
    reach_m: &[f64],
    room_m: f64,
    up: &Vector3<f64>,
    ways: &[Found],
) -> Vec<Option<f64>> {
    let mut sets = DisjointSets::default();
    let mut sections = |radius: f64| sections(sphere, sight, reach_m, radius * room_m, ways, &mut sets);
    let (near, mut far) = (sections(MIDDLES[0]), sections(MIDDLES[1]));
    if far.iter().any(Option::is_none) {
        far.iter_mut().zip(sections(MIDDLES[2])).for_each(|(far, less_far)| *far = far.or(less_far));
    }
    let slope_rad = |way: usize| {
        let (near, far) = near[way].zip(far[way])?;
        let line = match [0, 1].map(|edge| near.is_cut[edge] || far.is_cut[edge]) {
            [false, true] => far.edge_m(1) - near.edge_m(1),
            [true, false] => far.edge_m(0) - near.edge_m(0),
            _ => far.middle_m - near.middle_m,
        };
        line.try_normalize(0.0).map(|line| line.dot(up).clamp(-1.0, 1.0).asin())
    };
    (0..ways.len()).map(slope_rad).collect()
}

impl Section {
    /// Of a section whose upper (1) or lower (0) edge is that of the view, the other edge: as far from the middle as that one.
    fn edge_m(&self, of_view: usize) -> Vector3<f64> {
        self.middle_m + Vector3::z() * (self.middle_m.z - self.edges_m[of_view])
    }
}

/// The section of each way at a distance: of the components there that its cells lie in, those cells to which no other way of the
/// component is nearer.
fn sections(
    sphere: &Sphere,
    sight: &Sight,
    reach_m: &[f64],
    at_m: f64,
    ways: &[Found],
    sets: &mut DisjointSets,
) -> Vec<Option<Section>> {
    let mut of_cell = Vec::new();
    components(sphere, reach_m, at_m, sets, &mut of_cell);
    let of_way: Vec<Vec<usize>> = ways.iter().map(|way| within(&way.cells, &of_cell)).collect();
    let direction = |cell: u32| sphere.directions[cell as usize].into_inner();
    let towards: Vec<Vector3<f64>> = ways
        .iter()
        .map(|way| way.cells.iter().map(|cell| direction(*cell)).sum::<Vector3<f64>>().normalize())
        .collect();
    let mut cells = vec![Vec::new(); ways.len()];
    for (cell, part) in (0..).zip(&of_cell).filter_map(|(cell, part)| part.map(|part| (cell, part))) {
        let dot = |way: &usize| towards[*way].dot(&direction(cell));
        let of_part = (0..ways.len()).filter(|way| of_way[*way].contains(&part));
        if let Some(way) = of_part.max_by(|a, b| dot(a).total_cmp(&dot(b))) {
            cells[way].push(cell);
        }
    }
    let section = |cells: Vec<u32>| {
        let sum: Vector3<f64> = cells.iter().map(|cell| direction(*cell)).sum();
        let heights = cells.iter().map(|cell| direction(*cell).z);
        let [low, high] = heights.fold([1.0_f64, -1.0], |[low, high], z| [low.min(z), high.max(z)]);
        let half_rad = 0.5 * sphere.step_rad();
        let beside = |cell: u32| sphere.neighbours[cell as usize].iter().map(move |other| (cell, *other));
        let unknown = cells
            .iter()
            .flat_map(|cell| beside(*cell))
            .filter(|(_, other)| sight.seen[*other as usize] == Seen::Unknown);
        let rises: Vec<f64> = unknown.map(|(cell, other)| direction(other).z - direction(cell).z).collect();
        (!cells.is_empty()).then(|| Section {
            middle_m: sum * (at_m / cells.len() as f64),
            edges_m: [low.asin() - half_rad, high.asin() + half_rad].map(|rad| at_m * rad.sin()),
            is_cut: [rises.iter().any(|rise| *rise < -1e-9), rises.iter().any(|rise| *rise > 1e-9)],
        })
    };
    cells.into_iter().map(section).collect()
}
