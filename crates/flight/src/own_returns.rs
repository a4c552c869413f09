//! The vehicle in its own scans: what stands at the same bearing and range while most of what is farther away moves. A wall
//! beside which the vehicle flies stands so, too, but goes on beyond.

use crosscut_stage::NoteCode::{self, N102};
use crosscut_stage::{Beam, Point, Sweep, as_setting_rad};

/// Bearings are told apart by sectors of the full turn.
const SECTORS: usize = 360;

/// What is farther from the sensor than this is not the vehicle, metres.
const FARTHEST_M: f64 = 0.5;

/// A range that changes by less than this stays, metres.
const STAYS_M: f64 = 0.05;

/// What stays is the vehicle if this share of what is farther away does not.
const MOVES: f64 = 0.5;

/// So many scans show what may be the vehicle, and so many more that it is; after the last of these numbers the search begins
/// anew, as of a vehicle that stands.
const LEAST_SCANS: u32 = 3;
const SURE_SCANS: u32 = 15;
const MOST_SCANS: u32 = 300;

/// It is the vehicle if what is farther away moves by more than this, metres, in this share of all directions. (The walls of a
/// tunnel hardly do.)
const MOVED_M: f64 = 0.5;
const MOVED_SHARE: f64 = 0.1;

/// The vehicle returns something in at least this share of the scans.
const SEEN_SHARE: f64 = 0.8;

/// Beyond an edge of the vehicle, ranges are larger by this, metres.
const EDGE_M: f64 = 0.15;

/// More sectors than this are not listed: the least range stands for them.
const MOST_LISTED: usize = 4;

/// Looks for the vehicle in its own scans until it is surely found.
#[derive(Clone, Debug, Default)]
pub(crate) struct OwnReturns {
    seen: Vec<Seen>,
    scans: u32,
    /// Of each sector the ranges between which the vehicle stood in it when it was last found there. Empty without any.
    of_vehicle_m: Vec<Option<[f64; 2]>>,
    /// How many scans it took to find any.
    found_in: Option<u32>,
    is_sure: bool,
}

/// The nearest return of a sector, over scans.
#[derive(Clone, Copy, Debug)]
struct Seen {
    scans: u32,
    nearest_m: f64,
    farthest_m: f64,
}

impl Default for Seen {
    fn default() -> Self {
        Self { scans: 0, nearest_m: f64::INFINITY, farthest_m: 0.0 }
    }
}

/// Whole degrees, as those of many lidars, are in the middle of sectors.
fn sector_of(bearing_rad: f64) -> usize {
    let turns = (bearing_rad / std::f64::consts::TAU).rem_euclid(1.0);
    (turns * SECTORS as f64).round() as usize % SECTORS
}

/// The returns of a scan: index, bearing in radians, range in metres.
fn returns(sweep: &Sweep) -> impl Iterator<Item = (usize, f64, f64)> {
    let beams = sweep.beams.iter().zip(&sweep.bearings_rad).zip(&sweep.ranges_m);
    beams.filter_map(|((beam, bearing_rad), range_m)| match beam {
        Beam::Return(at) => Some((*at as usize, *bearing_rad, f64::from(*range_m))),
        Beam::NoReturn | Beam::Unknown => None,
    })
}

impl OwnReturns {
    /// Takes the next scan. The note, with a setting, in the scan that surely shows the vehicle.
    pub(crate) fn add(&mut self, sweep: &Sweep) -> Option<(NoteCode, String)> {
        // Nothing near in view is the usual case.
        if self.is_sure || (self.scans == 0 && !returns(sweep).any(|(_, _, range_m)| range_m < FARTHEST_M)) {
            return None;
        }
        let mut ranges_m = vec![f64::INFINITY; SECTORS];
        for (_, bearing_rad, range_m) in returns(sweep) {
            let nearest_m = &mut ranges_m[sector_of(bearing_rad)];
            *nearest_m = nearest_m.min(range_m);
        }
        if self.scans == 0 || self.scans == MOST_SCANS {
            (self.seen, self.scans) = (vec![Seen::default(); SECTORS], 0);
        }
        self.scans += 1;
        for (seen, range_m) in self.seen.iter_mut().zip(ranges_m).filter(|(_, range_m)| range_m.is_finite()) {
            seen.scans += 1;
            (seen.nearest_m, seen.farthest_m) = (seen.nearest_m.min(range_m), seen.farthest_m.max(range_m));
        }
        if self.scans < LEAST_SCANS || self.moved_share(STAYS_M) < MOVES {
            return None;
        }
        let parts = self.parts();
        if !parts.is_empty() && self.found_in.is_none() {
            self.of_vehicle_m.resize(SECTORS, None);
            self.found_in = Some(self.scans);
        }
        for sector in parts.iter().flat_map(within) {
            let Seen { scans, nearest_m, farthest_m } = self.seen[sector];
            self.of_vehicle_m[sector] = (scans > 0).then_some([nearest_m, farthest_m]);
        }
        if self.scans < SURE_SCANS || self.moved_share(2.0 * STAYS_M) < MOVES || self.moved_share(MOVED_M) < MOVED_SHARE
        {
            return None;
        }
        self.is_sure = !parts.is_empty();
        if !self.is_sure {
            self.scans = 0;
        }
        self.is_sure.then(|| (N102, self.described(&parts)))
    }

    /// How many scans it took to find returns that may be the vehicle's.
    pub(crate) fn found_in(&self) -> Option<u32> {
        self.found_in
    }

    /// Adds all returns of a scan but the vehicle's own.
    pub(crate) fn others(&self, sweep: &Sweep, points_m: &[Point], others_m: &mut Vec<Point>) {
        // A beam at the edge of two sectors is now in one, now in the other.
        let stays = |sector: usize, range_m: f64| {
            let of_vehicle_m = self.of_vehicle_m[sector % SECTORS];
            of_vehicle_m.is_some_and(|[from_m, to_m]| (from_m - STAYS_M..=to_m + STAYS_M).contains(&range_m))
        };
        let is_own = |sector: usize, range_m| [0, 1, SECTORS - 1].into_iter().any(|by| stays(sector + by, range_m));
        let others = returns(sweep).filter(|&(_, bearing_rad, range_m)| !is_own(sector_of(bearing_rad), range_m));
        others_m.extend(others.map(|(at, _, _)| points_m[at]));
    }

    /// The share of what is farther away than the vehicle that has moved by more than a length.
    fn moved_share(&self, by_m: f64) -> f64 {
        let far = || self.seen.iter().filter(|seen| seen.nearest_m >= FARTHEST_M && self.is_often(seen));
        let moved = far().filter(|seen| seen.farthest_m - seen.nearest_m > by_m).count();
        moved as f64 / far().count().max(1) as f64
    }

    fn is_often(&self, seen: &Seen) -> bool {
        f64::from(seen.scans) >= SEEN_SHARE * f64::from(self.scans)
    }

    /// The first and the last sector of each part of the vehicle.
    fn parts(&self) -> Vec<[usize; 2]> {
        let stays = |seen: &Seen| seen.farthest_m < FARTHEST_M && seen.farthest_m - seen.nearest_m < STAYS_M;
        // A lidar with few beams leaves sectors out.
        let seen: Vec<usize> = (0..SECTORS).filter(|sector| self.seen[*sector].scans > 0).collect();
        let is_own = |at: usize| {
            let of = &self.seen[seen[at % seen.len()]];
            stays(of) && self.is_often(of)
        };
        let Some(start) = (0..seen.len()).find(|at| !is_own(*at)) else { return Vec::new() };
        let mut parts: Vec<[usize; 2]> = Vec::new();
        for at in start + 1..start + seen.len() {
            match parts.last_mut().filter(|[_, last]| last + 1 == at) {
                _ if !is_own(at) => {}
                Some([_, last]) => *last = at,
                None => parts.push([at, at]),
            }
        }
        let of = |at: usize| &self.seen[seen[at % seen.len()]];
        let is_edge = |inside: usize, beyond: usize| {
            let beyond = of(beyond);
            beyond.nearest_m > of(inside).farthest_m + EDGE_M || beyond.farthest_m - beyond.nearest_m > MOVED_M
        };
        parts.retain(|[first, last]| is_edge(*first, first + seen.len() - 1) && is_edge(*last, last + 1));
        parts.into_iter().map(|part| part.map(|at| seen[at % seen.len()])).collect()
    }

    fn described(&self, parts: &[[usize; 2]]) -> String {
        let of_parts = || parts.iter().flat_map(within).map(|sector| &self.seen[sector]);
        let seen = || of_parts().filter(|seen| seen.scans > 0);
        let nearest_m = seen().fold(f64::INFINITY, |nearest_m, seen| nearest_m.min(seen.nearest_m));
        let farthest_m = seen().fold(0.0, |farthest_m: f64, seen| farthest_m.max(seen.farthest_m));
        let beginning_rad =
            |sector: usize| as_setting_rad((sector as f64 - 0.5) / SECTORS as f64 * std::f64::consts::TAU);
        let listed =
            |[first, last]: &[usize; 2]| format!("[{:.3}, {:.3}]", beginning_rad(*first), beginning_rad(last + 1));
        let setting = if parts.len() > MOST_LISTED {
            format!("ingest.min_range_m = {:.2}", farthest_m + STAYS_M)
        } else {
            format!("ingest.masked_sectors_rad = [{}]", parts.iter().map(listed).collect::<Vec<_>>().join(", "))
        };
        let sectors = of_parts().count();
        format!(
            "the vehicle itself is in view, at {nearest_m:.2} to {farthest_m:.2} m in {sectors}° of the scan: what stands \
             there stayed while the rest moved; {setting} leaves it out"
        )
    }
}

/// The sectors from the first to the last of a part.
fn within([first, last]: &[usize; 2]) -> impl Iterator<Item = usize> + use<> {
    let (first, others) = (*first, (last + SECTORS - first) % SECTORS);
    (first..=first + others).map(|sector| sector % SECTORS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The note of 60 scans at 0.1 m from each other, of beams a degree apart, where `range_m` gives range by bearing, in
    /// degrees, and way.
    fn note(range_m: impl Fn(f64, f64) -> f64) -> Option<String> {
        let mut own = OwnReturns::default();
        (0..60).find_map(|scan| {
            let mut sweep = Sweep::default();
            for deg in -180..180 {
                let deg = f64::from(deg);
                sweep.bearings_rad.push(deg.to_radians());
                sweep.ranges_m.push(range_m(deg, 0.1 * f64::from(scan)) as f32);
                sweep.beams.push(Beam::Return(0));
            }
            own.add(&sweep).map(|(_, note)| note)
        })
    }

    #[test]
    fn a_post_of_the_vehicle_is_named_and_a_wall_beside_it_is_none() {
        let wall = |deg: f64, at_m: f64| (at_m / deg.to_radians().sin()).abs().min(9.0);
        let rough = |deg: f64, way_m: f64| 0.2 * (3.0 * way_m + 0.1 * deg).sin();
        let far = |deg: f64, way_m: f64| wall(deg, 2.0) + rough(deg, way_m) + if deg < 0.0 { way_m } else { 0.0 };
        let post = note(|deg, way_m| if (20.0..30.0).contains(&deg) { 0.3 } else { far(deg, way_m) });
        let post = post.expect("a post");
        assert!(post.contains("at 0.30 to 0.30 m in 10°") && post.contains("= [[0.340, 0.515]] leaves"), "{post}");
        assert_eq!(note(far), None, "nothing near");
        assert_eq!(note(|deg, way_m| if deg > 0.0 { wall(deg, 0.4) } else { far(deg, way_m) }), None, "a smooth wall");
        assert_eq!(note(|deg, _| if (20.0..30.0).contains(&deg) { 0.3 } else { far(deg, 0.0) }), None, "it stands");
    }
}
