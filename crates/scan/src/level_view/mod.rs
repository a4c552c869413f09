//! A cloud as a vehicle sees it that flies level: a 2D sweep of the nearest returns at its height.

mod fan;
mod usual;

use std::f64::consts::FRAC_PI_2;

use crosscut_stage::{Beam, Point, Revolution, Sweep, widest_run};

use fan::Fan;
use usual::Usual;

/// The beams of a level view; each is at least half a degree wide.
const MOST_LEVEL_BEAMS: usize = 720;
/// A sector without any return that is wider than this was not looked at: no opening is as wide.
const UNSEEN_RAD: f64 = FRAC_PI_2;

/// The nearest returns of a cloud at the height of the vehicle.
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
/// A sweep of more than 4096 beams is worked on as a cloud, and its own beams tell the two apart.
///
/// ```
/// use crosscut_scan::LevelView;
/// use crosscut_stage::{Point, Revolution};
///
/// let points_m = [[3.0, 0.0, 0.1], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0], [-4.0, 0.0, 0.0], [3.0, 0.0, 1.5]];
/// let cloud = Revolution { points_m: points_m.map(Point::from).to_vec(), ..Revolution::default() };
/// let mut view = LevelView::default();
/// let (height_m, width_m) = (0.6, 0.6);
/// view.look(&cloud, height_m, width_m);
/// assert_eq!(view.numbers(), [1, 3, 2, 0], "anticlockwise, and the roof is out of the way");
/// ```
#[derive(Clone, Debug, Default)]
pub struct LevelView {
    seen: Revolution,
    numbers: Vec<u32>,
    level: Vec<LevelReturn>,
    /// The level returns in the order of the cloud.
    undealt: Vec<LevelReturn>,
    fan: Fan,
    usual: Usual,
    /// The return that each beam sees; the first beam sees the nearest level return.
    met: Vec<Option<LevelReturn>>,
    /// What each beam saw, if it sees no return.
    blank: Vec<Beam>,
}

/// A return at the height of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelReturn {
    /// Its number in the cloud.
    pub number: u32,
    /// Its beam, anticlockwise.
    pub beam: u32,
    /// Its horizontal distance from the sensor.
    pub range_m: f64,
}

impl LevelView {
    /// Looks at `cloud`; nothing of an earlier cloud is left. Returns within half the vehicle's width of the sensor are
    /// of the vehicle itself.
    pub fn look(&mut self, cloud: &Revolution, height_m: f64, width_m: f64) {
        let (half_height_m, nearest_m) = (0.5 * height_m, 0.5 * width_m);
        let is_level = |point: &Point| point.z.abs() <= half_height_m && point.coords.xy().norm() > nearest_m;
        let level = cloud.points_m.iter().filter(|point| is_level(point)).map(|point| point.coords.xy());
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
            self.find_level(cloud, half_height_m, nearest_m);
            self.deal();
            for returns in self.level.chunk_by(|a, b| a.beam == b.beam) {
                self.met[returns[0].beam as usize] = first_met(returns, &self.usual, width_m);
            }
        }
        self.write_sweep(cloud);
    }

    /// The returns that are seen, in beam order with the beams behind them, at z = 0.
    pub fn seen(&self) -> &Revolution {
        &self.seen
    }

    /// The number in the cloud of each return that is seen.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// All level returns, those that are not seen too: sorted by beam, from the first of the view on, those of a beam
    /// by range.
    pub fn level(&self) -> &[LevelReturn] {
        &self.level
    }

    /// Number of beams all around, those outside the view among them.
    pub fn beams(&self) -> usize {
        self.fan.beams
    }

    /// Fills `undealt` and `usual`.
    fn find_level(&mut self, cloud: &Revolution, half_height_m: f64, nearest_m: f64) {
        let Self { undealt, fan, usual, .. } = self;
        usual.begin(fan.beams, nearest_m);
        undealt.clear();
        let mut beam = 0;
        for (number, point) in (0..).zip(&cloud.points_m) {
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

    fn write_sweep(&mut self, cloud: &Revolution) {
        let Self { seen, numbers, level, fan, met, blank, .. } = self;
        seen.clear();
        (seen.seq, seen.stamp_ns) = (cloud.seq, cloud.stamp_ns);
        numbers.clear();
        let sweep = seen.sweep.get_or_insert_with(Sweep::default);
        sweep.step_rad = fan.step_rad();
        blank.clear();
        let limited = if let Some(dense) = cloud.beams() {
            sweep.range_max_m = dense.range_max_m;
            blank.resize(met.len(), Beam::Unknown);
            fan.mark_free(dense, blank);
            let is_unseen = |beam: usize| met[beam].is_none() && blank[beam] == Beam::Unknown;
            (!dense.view().full_turn).then(|| widest_run(met.len(), is_unseen))
        } else {
            sweep.range_max_m = f64::INFINITY;
            blank.resize(met.len(), Beam::NoReturn);
            let unseen = widest_run(met.len(), |beam| met[beam].is_none());
            Some(unseen).filter(|(_, beams)| *beams as f64 * sweep.step_rad > UNSEEN_RAD)
        };
        let (begin, unseen) = limited.unwrap_or_default();
        sweep.full_turn = unseen == 0;
        let turn = if sweep.full_turn { 0..met.len() } else { begin + unseen..begin + met.len() };
        if !sweep.full_turn {
            start_at(turn.start, fan.beams, level);
        }
        for beam in turn {
            sweep.bearings_rad.push(fan.bearing_rad(beam));
            let Some(met) = met[beam % met.len()] else {
                sweep.ranges_m.push(f32::INFINITY);
                sweep.beams.push(blank[beam % met.len()]);
                continue;
            };
            sweep.ranges_m.push(met.range_m as f32);
            sweep.beams.push(Beam::Return(numbers.len() as u32));
            let point = cloud.points_m[met.number as usize];
            seen.points_m.push(Point::new(point.x, point.y, 0.0));
            numbers.push(met.number);
        }
    }
}

/// Numbers the beams of returns, which are sorted by them, from another one on, and sorts the returns by that.
fn start_at(first: usize, beams: usize, level: &mut [LevelReturn]) {
    let (first, beams) = (first as u32, beams as u32);
    let before = level.partition_point(|one| one.beam < first % beams);
    level.rotate_left(before);
    level.iter_mut().for_each(|one| one.beam = (one.beam + 2 * beams - first) % beams);
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

    fn look(points_m: Vec<Point>) -> LevelView {
        let mut view = LevelView::default();
        view.look(&Revolution { points_m, ..Revolution::default() }, 0.6, 0.6);
        view
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
        let view = look(wall.chain(ring(1000, 1.0, 0.5)).chain(ring(20, 0.2, 0.0)).collect());
        assert_eq!((view.level().len(), view.numbers().len()), (100_000, 720), "the roof and the vehicle are no wall");
        let seen = view.seen();
        assert!((0..720).all(|i| (seen.range_m(i) - 3.0).abs() < 1e-9 && seen.points_m[i].z == 0.0));
        let sweep = seen.sweep.as_ref().expect("made");
        assert!(sweep.full_turn && sweep.beams.len() == 720 && !sweep.view().clockwise);
    }

    #[test]
    fn a_beam_of_many_returns_sees_no_dust() {
        // Where nothing comes back from beyond the dust, nothing is seen.
        for (dark, least) in [(0, 720), (900, 620)] {
            let view = look(ring(7200, 5.0, 0.0).skip(dark).chain(ring(360, 2.0, 0.0)).collect());
            let seen = view.seen();
            assert!(
                seen.len() >= least && (0..seen.len()).all(|i| (seen.range_m(i) - 5.0).abs() < 1e-9),
                "{dark} dark"
            );
        }
    }

    #[test]
    fn only_a_wide_empty_sector_is_out_of_view() {
        let part = |share: f64| look(ring(3600, 4.0, 0.0).take((3600.0 * share) as usize).collect());
        let sweep_of = |view: &LevelView| view.seen().sweep.clone().expect("made");
        let (three_quarters, most) = (sweep_of(&part(0.7)), sweep_of(&part(0.8)));
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
            beams: (0..9000).map(beam).collect(),
            bearings_rad: (0..9000).map(bearing_rad).collect(),
            step_rad: TAU / 9000.0,
            range_max_m: 6.0,
            full_turn: true,
            ..Sweep::default()
        };
        let mut view = LevelView::default();
        view.look(&Revolution { points_m, sweep: Some(sweep), ..Revolution::default() }, 0.6, 0.6);
        let seen = view.seen().sweep.as_ref().expect("made");
        let count = |kind: Beam| seen.beams.iter().filter(|beam| **beam == kind).count();
        assert_eq!((seen.range_max_m, seen.full_turn, count(Beam::Unknown)), (6.0, false, 0));
        assert!(seen.len().abs_diff(640) <= 1 && count(Beam::NoReturn).abs_diff(80) <= 1, "{} beams", seen.len());
    }

    #[test]
    fn a_used_view_holds_nothing_of_an_earlier_cloud() {
        let mut view = look(ring(500, 4.0, 0.0).collect());
        view.look(&Revolution { points_m: ring(9, 4.0, 2.0).collect(), ..Revolution::default() }, 0.6, 0.6);
        assert_eq!(
            (view.level().len(), view.seen().len(), view.seen().sweep.as_ref().map(Sweep::len)),
            (0, 0, Some(0))
        );
    }
}
