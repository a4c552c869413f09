//! How far one sees in each direction.

use std::ops::Range;

use nalgebra::Vector3;

use super::sphere::Sphere;
use crosscut_stage::Point;

/// Of the returns of a cell, this share may be nearer than what is seen there: dust, and the rim of something beside it.
const NEARER_SHARE: f64 = 0.25;
/// A ring of cells is looked at if a return is in this share of its cells or more; and at the edge, if it has as large a share of
/// the returns of the ring beside it.
const LOOKED_AT_SHARE: f64 = 0.5;

/// What a cell of the sphere shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Seen {
    /// The place of what is seen there.
    Return(Vector3<f64>),
    /// Nothing came back, though the sensor looks there.
    Nothing,
    /// The sensor does not look there, or the vehicle is in its way.
    Unknown,
}

/// What the cells of a sphere show, and the room to see it in.
#[derive(Clone, Debug, Default)]
pub(super) struct Sight {
    pub(super) seen: Vec<Seen>,
    /// Where the returns of each cell begin in `sorted`.
    starts: Vec<u32>,
    cells: Vec<u32>,
    sorted: Vec<(f32, u32)>,
}

impl Sight {
    /// Looks at points around the sensor. Those nearer than `own_m` are of the vehicle itself.
    pub(super) fn look(&mut self, sphere: &Sphere, points_m: &[Point], own_m: f64) {
        let Self { seen, starts, cells, sorted } = self;
        starts.clear();
        starts.resize(sphere.len() + 2, 0);
        cells.clear();
        let mut hidden = vec![0_u32; sphere.len()];
        for point_m in points_m {
            let range_m = point_m.coords.norm();
            let cell = if range_m > 0.0 { sphere.cell(&point_m.coords, range_m) } else { sphere.len() };
            if range_m > own_m {
                starts[cell + 2] += 1;
                cells.push(cell as u32);
            } else {
                hidden.get_mut(cell).into_iter().for_each(|count| *count += 1);
                cells.push(u32::MAX);
            }
        }
        (1..starts.len()).for_each(|at| starts[at] += starts[at - 1]);
        sorted.clear();
        sorted.resize(starts.last().map_or(0, |last| *last as usize), (0.0, 0));
        for ((number, point_m), &cell) in (0..).zip(points_m).zip(&*cells) {
            if cell != u32::MAX {
                let next = &mut starts[cell as usize + 1];
                sorted[*next as usize] = (point_m.coords.norm_squared() as f32, number);
                *next += 1;
            }
        }
        seen.clear();
        for cell in 0..sphere.len() {
            let of_cell = &mut sorted[starts[cell] as usize..starts[cell + 1] as usize];
            let (count, hidden) = (of_cell.len(), hidden[cell] as usize);
            seen.push(if count > hidden {
                let (_, &mut (_, number), _) = of_cell
                    .select_nth_unstable_by((NEARER_SHARE * count as f64) as usize, |a, b| {
                        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
                    });
                Seen::Return(points_m[number as usize].coords)
            } else if hidden > 0 {
                Seen::Unknown
            } else {
                Seen::Nothing
            });
        }
    }

    /// Makes cells unknown that the sensor does not look at: rings with returns in few cells, and one at the edge of the view that
    /// has far fewer returns than the ring beside it, as the view ends in it. Says whether such a ring lies between others.
    pub(super) fn hide_unseen(&mut self, sphere: &Sphere) -> bool {
        let Self { seen, starts, .. } = self;
        let rings = sphere.rings();
        let is_looked_at = |ring: &Range<usize>| {
            let looked_at = seen[ring.clone()].iter().filter(|seen| **seen != Seen::Nothing).count();
            looked_at as f64 >= LOOKED_AT_SHARE * ring.len() as f64
        };
        let looked_at: Vec<bool> = rings.iter().map(is_looked_at).collect();
        let is_between = looked_at.chunk_by(|a, b| a == b).filter(|run| run[0]).count() > 1;
        for (ring, _) in rings.iter().zip(&looked_at).filter(|(_, looked_at)| !**looked_at) {
            seen[ring.clone()].iter_mut().filter(|seen| **seen == Seen::Nothing).for_each(|seen| *seen = Seen::Unknown);
        }
        let returns = |ring: &Range<usize>| f64::from(starts[ring.end] - starts[ring.start]) / ring.len() as f64;
        let ends = [looked_at.iter().position(|is| *is), looked_at.iter().rposition(|is| *is)];
        if let [Some(first), Some(last)] = ends
            && first + 1 < last
        {
            for (edge, inner) in [(first, first + 1), (last, last - 1)] {
                if returns(&rings[edge]) < LOOKED_AT_SHARE * returns(&rings[inner]) {
                    seen[rings[edge].clone()].fill(Seen::Unknown);
                }
            }
        }
        is_between
    }

    /// The lowest and the highest elevation at which something is known, radians; 0 of nothing.
    pub(super) fn view_rad(&self, sphere: &Sphere) -> [f64; 2] {
        let known = (0..)
            .zip(sphere.rings())
            .filter(|(_, ring)| self.seen[(*ring).clone()].iter().any(|seen| *seen != Seen::Unknown));
        let rings: Vec<usize> = known.map(|(ring, _)| ring).collect();
        let (Some(first), Some(last)) = (rings.first(), rings.last()) else { return [0.0; 2] };
        sphere.elevations_rad(*first, *last)
    }
}
