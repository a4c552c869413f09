//! A cloud as a vehicle sees it that flies level: a 2D sweep of the nearest returns at its height.

mod fan;
mod usual;

use std::f64::consts::FRAC_PI_2;

use crosscut_stage::{Beam, Frame, Point, Revolution, Sweep, widest_run};

use fan::LevelBeams;
use usual::Usual;

/// The beams of a level view; each is at least half a degree wide.
const MOST_LEVEL_BEAMS: usize = 720;
/// A sector without any return that is wider than this was not looked at: no opening is as wide.
const UNSEEN_RAD: f64 = FRAC_PI_2;

/// Makes of a cloud the revolution that a level vehicle sees: the nearest returns at its height.
///
/// A cloud has no beams. A level vehicle could meet its returns with |z| <= height/2, where z = 0 is the height of the
/// sensor; floor and roof bound no opening. These *level* returns are dealt by bearing to as many beams as there are of
/// them, at most 720, and each beam sees at most one of them. So a cloud of any size becomes a sweep of bounded size,
/// on which everything works that works on sweeps.
///
/// A beam sees the nearest return that has company: together with those up to a vehicle's width behind it, a quarter of
/// the returns that a beam usually has (the median) in the angles |z| / range <= height / (2 range) that are level
/// there. A wall has them all; dust has a few per cent, also where nothing comes back from beyond it.
///
/// The nearest level return is in the middle of its beam, the first one, so the view turns with the cloud and does not
/// depend on the order of its points. An empty sector of more than 90° counts as not looked at, a smaller one as free.
/// A sweep of very many beams is levelled like a cloud, and its own beams tell the two apart.
///
/// ```
/// use crosscut_scan::LevelView;
/// use crosscut_stage::{Point, Revolution};
///
/// let points_m = [[3.0, 0.0, 0.1], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0], [-4.0, 0.0, 0.0], [3.0, 0.0, 1.5]];
/// let mut revolution = Revolution { points_m: points_m.map(Point::from).to_vec(), ..Revolution::default() };
/// let (height_m, width_m) = (0.6, 0.6);
/// LevelView::default().level(&mut revolution, height_m, width_m);
/// assert_eq!(revolution.len(), 4);
/// assert_eq!(revolution.entries, [3, 0, 2, 1, -2], "anticlockwise, and the roof is out of the way");
/// ```
#[derive(Clone, Debug, Default)]
pub struct LevelView {
    /// The points of the cloud.
    points_m: Vec<Point>,
    level: Vec<LevelReturn>,
    /// The level returns in the order of the cloud.
    undealt: Vec<LevelReturn>,
    fan: LevelBeams,
    usual: Usual,
    /// The return that each beam sees; the first beam sees the nearest level return.
    met: Vec<Option<LevelReturn>>,
    /// What each beam saw, if it sees no return.
    blank: Vec<Beam>,
}

/// A return at the height of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct LevelReturn {
    /// Its number in the cloud.
    number: u32,
    /// Its beam, anticlockwise.
    beam: u32,
    /// Its horizontal distance from the sensor.
    range_m: f64,
}

impl LevelView {
    /// Makes `revolution`, which has the points of a cloud or a sweep of very many beams, the one that a level vehicle
    /// sees: its returns at z = 0, in beam order. All level returns of a beam are entries of the return that it sees.
    /// Returns within half the vehicle's width of the sensor are of the vehicle itself. Gives the number of points that
    /// are not level, or of the vehicle.
    pub fn level(&mut self, revolution: &mut Revolution, height_m: f64, width_m: f64) -> usize {
        std::mem::swap(&mut self.points_m, &mut revolution.points_m);
        revolution.points_m.clear();
        let (half_height_m, nearest_m) = (0.5 * height_m, 0.5 * width_m);
        let is_level = |point: &Point| point.z.abs() <= half_height_m && point.coords.xy().norm() > nearest_m;
        let level = self.points_m.iter().filter(|point| is_level(point)).map(|point| point.coords.xy());
        // The first beam looks at the nearest level return.
        let (mut beams, mut nearest) = (0, None);
        for place_m in level {
            let squared = place_m.norm_squared();
            if nearest.is_none_or(|(least, _)| squared < least) {
                nearest = Some((squared, place_m));
            }
            beams = MOST_LEVEL_BEAMS.min(beams + 1);
        }
        self.fan.open(nearest.map_or(0.0, |(_, place_m)| place_m.y.atan2(place_m.x)), beams);
        self.level.clear();
        self.met.clear();
        self.met.resize(beams, None);
        if beams > 0 {
            self.find_level(half_height_m, nearest_m);
            self.deal();
            for returns in self.level.chunk_by(|a, b| a.beam == b.beam) {
                self.met[returns[0].beam as usize] = first_met(returns, &self.usual, width_m);
            }
        }
        self.write(revolution);
        self.points_m.len() - self.level.len()
    }

    /// The points of the cloud that was levelled last, in its order.
    pub fn points_m(&self) -> &[Point] {
        &self.points_m
    }

    /// Fills `undealt` and `usual`.
    fn find_level(&mut self, half_height_m: f64, nearest_m: f64) {
        let Self { points_m, undealt, fan, usual, .. } = self;
        usual.begin(fan.beams, nearest_m);
        undealt.clear();
        let mut beam = 0;
        for (number, point) in (0..).zip(&*points_m) {
            let (place_m, up_m) = (point.coords.xy(), point.z.abs());
            let range_m = place_m.norm();
            let ranges = usual.ranges_to(half_height_m * range_m / up_m);
            if ranges == 0 {
                continue;
            }
            beam = fan.beam(place_m, beam);
            usual.count(beam, ranges);
            if up_m <= half_height_m && range_m > nearest_m {
                undealt.push(LevelReturn { number, beam: beam as u32, range_m });
            }
        }
        usual.end();
    }

    /// Sorts the level returns by beam, those of a beam by range.
    fn deal(&mut self) {
        let Self { level, undealt, fan, .. } = self;
        let mut next = vec![0; fan.beams + 1];
        undealt.iter().for_each(|level| next[level.beam as usize + 1] += 1);
        (0..fan.beams).for_each(|beam| next[beam + 1] += next[beam]);
        level.resize(undealt.len(), LevelReturn::default());
        for one in undealt {
            let next = &mut next[one.beam as usize];
            level[*next] = *one;
            *next += 1;
        }
        for returns in level.chunk_by_mut(|a, b| a.beam == b.beam) {
            returns.sort_unstable_by(|a, b| a.range_m.total_cmp(&b.range_m).then(a.number.cmp(&b.number)));
        }
    }

    fn write(&mut self, out: &mut Revolution) {
        let Self { points_m, level, fan, met, blank, .. } = self;
        blank.clear();
        let sweep = out.sweep.get_or_insert_default();
        let is_dense = !sweep.is_empty();
        let limited = if is_dense {
            blank.resize(met.len(), Beam::Unknown);
            fan.mark_free(sweep, blank);
            let is_unseen = |beam: usize| met[beam].is_none() && blank[beam] == Beam::Unknown;
            (!sweep.view().full_turn).then(|| widest_run(met.len(), is_unseen))
        } else {
            blank.resize(met.len(), Beam::NoReturn);
            let unseen = widest_run(met.len(), |beam| met[beam].is_none());
            Some(unseen).filter(|(_, beams)| *beams as f64 * fan.step_rad() > UNSEEN_RAD)
        };
        let (begin, unseen) = limited.unwrap_or_default();
        let turn = if unseen == 0 { 0..met.len() } else { begin + unseen..begin + met.len() };
        let Sweep { range_max_m, beams, ranges_m, .. } = std::mem::take(sweep);
        *sweep = Sweep {
            step_rad: fan.step_rad(),
            range_max_m: if is_dense { range_max_m } else { f64::INFINITY },
            full_turn: unseen == 0,
            ..Sweep::default()
        };
        // Of each beam, the entry of its returns.
        let mut entries = vec![Frame::NO_WALL; met.len()];
        for beam in turn {
            sweep.bearings_rad.push(fan.bearing_rad(beam));
            let Some(seen) = met[beam % met.len()] else {
                sweep.ranges_m.push(f32::INFINITY);
                sweep.beams.push(blank[beam % met.len()]);
                continue;
            };
            let number = out.points_m.len() as u32;
            entries[beam % met.len()] = number.cast_signed();
            sweep.ranges_m.push(seen.range_m as f32);
            sweep.beams.push(Beam::Return(number));
            let point = points_m[seen.number as usize];
            out.points_m.push(Point::new(point.x, point.y, 0.0));
        }
        let [first, step] = [sweep.bearings_rad.first().copied().unwrap_or(0.0), sweep.step_rad];
        sweep.wire_geometry = [first, step, 0.0, sweep.range_max_m].map(|value| value as f32);
        let mut of_points = vec![Frame::NO_WALL; points_m.len()];
        level.iter().for_each(|one| of_points[one.number as usize] = entries[one.beam as usize]);
        out.entries.clear();
        if is_dense {
            out.entries.resize(ranges_m.len().max(beams.len()), Frame::NO_RETURN);
            for (entry, beam) in out.entries.iter_mut().zip(&beams) {
                if let Beam::Return(i) = beam {
                    *entry = of_points[*i as usize];
                }
            }
        } else {
            out.entries = of_points;
        }
    }
}

/// The return that a beam sees, of its returns, which ascend by range.
fn first_met(returns: &[LevelReturn], usual: &Usual, width_m: f64) -> Option<LevelReturn> {
    let is_met = |&(at, one): &(usize, &LevelReturn)| {
        let last = returns.get(at + usual.enough(one.range_m) - 1);
        last.is_some_and(|last| last.range_m <= one.range_m + width_m)
    };
    returns.iter().enumerate().find(is_met).map(|(_, one)| *one)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// The revolution, and how many points are not level.
    fn level(points_m: Vec<Point>) -> (Revolution, usize) {
        let mut revolution = Revolution { points_m, ..Revolution::default() };
        let aside = LevelView::default().level(&mut revolution, 0.6, 0.6);
        (revolution, aside)
    }

    /// A ring of this many returns at one range and height.
    fn ring(returns: usize, range_m: f64, z_m: f64) -> impl Iterator<Item = Point> {
        (0..returns).map(move |i| {
            let (sin, cos) = (TAU * i as f64 / returns as f64).sin_cos();
            Point::new(range_m * cos, range_m * sin, z_m)
        })
    }

    #[test]
    fn a_large_cloud_sees_its_nearest_level_returns() {
        let wall = ring(50_000, 3.0, 0.1).chain(ring(50_000, 4.0, -0.2));
        let (seen, aside) = level(wall.chain(ring(1000, 1.0, 0.5)).chain(ring(20, 0.2, 0.0)).collect());
        assert_eq!((aside, seen.len()), (1020, 720), "the roof and the vehicle are no wall");
        assert!((0..720).all(|i| (seen.range_m(i) - 3.0).abs() < 1e-9 && seen.points_m[i].z == 0.0));
        let sweep = seen.sweep.as_ref().expect("made");
        assert!(sweep.full_turn && sweep.beams.len() == 720 && !sweep.view().clockwise);
        let (walls, others) = seen.entries.split_at(100_000);
        assert!(others.iter().all(|entry| *entry == Frame::NO_WALL));
        assert_eq!(walls[..50_000], walls[50_000..], "what is behind a return is an entry of the same beam");
        assert!((0..720).all(|i| walls.contains(&i)));
    }

    #[test]
    fn a_beam_of_many_returns_sees_no_dust() {
        // Where nothing comes back from beyond the dust, nothing is seen.
        for (dark, least) in [(0, 720), (900, 620)] {
            let (seen, _) = level(ring(7200, 5.0, 0.0).skip(dark).chain(ring(360, 2.0, 0.0)).collect());
            assert!(
                seen.len() >= least && (0..seen.len()).all(|i| (seen.range_m(i) - 5.0).abs() < 1e-9),
                "{dark} dark"
            );
        }
    }

    #[test]
    fn only_a_wide_empty_sector_is_out_of_view() {
        let part = |share: f64| {
            let (seen, _) = level(ring(3600, 4.0, 0.0).take((3600.0 * share) as usize).collect());
            seen.sweep.expect("made")
        };
        let (three_quarters, most) = (part(0.7), part(0.8));
        assert!(!three_quarters.full_turn && most.full_turn);
        let is_return = |beam: &Beam| matches!(beam, Beam::Return(_));
        assert!(three_quarters.beams.iter().all(is_return), "it begins where the view begins");
        assert!(most.beams.contains(&Beam::NoReturn) && most.len() == 720);
    }

    #[test]
    fn masks_and_range_of_a_dense_sweep_are_kept() {
        let points_m: Vec<Point> = ring(9000, 4.0, 0.0).skip(2000).collect();
        let beam = |i: usize| match i {
            0..1000 => Beam::Unknown,
            1000..2000 => Beam::NoReturn,
            i => Beam::Return(i as u32 - 2000),
        };
        let bearing_rad = |i: usize| crosscut_stage::wrap_angle_rad(TAU * i as f64 / 9000.0);
        let sweep = Sweep {
            ranges_m: vec![4.0; 9001],
            beams: (0..9000).map(beam).collect(),
            bearings_rad: (0..9000).map(bearing_rad).collect(),
            step_rad: TAU / 9000.0,
            range_max_m: 6.0,
            full_turn: true,
            ..Sweep::default()
        };
        let mut seen = Revolution { points_m, sweep: Some(sweep), ..Revolution::default() };
        LevelView::default().level(&mut seen, 0.6, 0.6);
        let sweep = seen.sweep.as_ref().expect("made");
        let count = |kind: Beam| sweep.beams.iter().filter(|beam| **beam == kind).count();
        assert_eq!((sweep.range_max_m, sweep.full_turn, count(Beam::Unknown)), (6.0, false, 0));
        assert!(sweep.len().abs_diff(640) <= 1 && count(Beam::NoReturn).abs_diff(80) <= 1, "{} beams", sweep.len());
        assert_eq!((seen.entries.len(), seen.entries[9000]), (9001, Frame::NO_RETURN), "one a beam of the message");
        assert!(seen.entries[..2000].iter().all(|entry| *entry == Frame::NO_RETURN));
        let lost = seen.entries[2000..9000].iter().filter(|entry| **entry < 0).count();
        assert!(lost < 20, "{lost}: where the walls end, a beam has too few returns");
    }

    #[test]
    fn a_used_view_holds_nothing_of_an_earlier_cloud() {
        let (mut view, mut used) = (LevelView::default(), Revolution::default());
        used.points_m = ring(500, 4.0, 0.0).collect();
        view.level(&mut used, 0.6, 0.6);
        used.clear();
        used.points_m = ring(9, 4.0, 2.0).collect();
        assert_eq!(view.level(&mut used, 0.6, 0.6), 9);
        assert_eq!((used.len(), used.sweep.map(|sweep| sweep.len()), used.entries), (0, Some(0), vec![-2; 9]));
    }
}
