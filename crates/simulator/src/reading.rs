//! The readings of a lidar: echoes with noise, lost beams, dust and mixed returns.

use rand::RngExt;

use crate::lidar::{Echo, Lidar};
use crate::noise::{Generator, normal};
use crate::surface::Surface;

/// At an edge the range changes by more than this from one beam to the next.
const JUMP_M: f64 = 0.3;
/// At an edge the range changes by more than this many times the change on either side.
const JUMP_FACTOR: f64 = 2.5;

/// The reading of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// No return.
    Nothing,
    /// The range to the echo.
    Echo(f64),
    /// The range to dust in front of the echo.
    Dust(f64),
    /// A range between the two sides of an edge.
    Mixed(f64),
}

impl Lidar {
    /// The readings of a view, with errors drawn from `rng`.
    pub(crate) fn read(&self, surface: &Surface, view: &[Echo], rng: &mut Generator) -> Vec<Reading> {
        let mut readings: Vec<Reading> = view.iter().map(|echo| self.read_one(surface, echo, rng)).collect();
        // Nothing is drawn if both are 0, so that scenes without these errors do not depend on them.
        if self.mixed_at_edges > 0.0 || self.loss_at_edges > 0.0 {
            self.blur_edges(view, &mut readings, rng);
        }
        self.lose_patches(&mut readings, rng);
        readings
    }

    fn read_one(&self, surface: &Surface, echo: &Echo, rng: &mut Generator) -> Reading {
        let (range_m, kept) = match *echo {
            Echo::Nothing => (f64::INFINITY, 0.0),
            Echo::Floor { range_m } => (range_m, self.kept_at(range_m)),
            Echo::Rock { range_m, segment, incidence_sine } => {
                let grazing = (1.0 - incidence_sine / 20_f64.to_radians().sin()).max(0.0);
                let wet = if surface.segments()[segment].wet { self.loss_on_wet } else { 0.0 };
                (range_m, self.kept_at(range_m) * (1.0 - self.loss_at_grazing * grazing) * (1.0 - wet))
            }
        };
        let nearest_dust_m = self.range_min_m.max(0.3);
        let farthest_dust_m = self.dust_range_m.min(range_m - 0.1);
        if farthest_dust_m > nearest_dust_m && rng.random_bool(self.dust) {
            return Reading::Dust(self.quantised(rng.random_range(nearest_dust_m..farthest_dust_m)));
        }
        if !rng.random_bool(kept) {
            return Reading::Nothing;
        }
        let range_m = self.quantised(range_m + self.noise_sd_m * normal(rng));
        if range_m < self.range_min_m || range_m > self.range_max_m { Reading::Nothing } else { Reading::Echo(range_m) }
    }

    fn kept_at(&self, range_m: f64) -> f64 {
        (1.0 - self.loss) * (1.0 - self.loss_at_range_max * (range_m / self.range_max_m).min(1.0).powi(2))
    }

    fn quantised(&self, range_m: f64) -> f64 {
        if self.quantum_m > 0.0 { (range_m / self.quantum_m).round() * self.quantum_m } else { range_m }
    }

    /// Mixes or loses one of the two beams at each edge.
    fn blur_edges(&self, view: &[Echo], readings: &mut [Reading], rng: &mut Generator) {
        for beam in self.edges(view) {
            let next = (beam + 1) % view.len();
            let (from_m, to_m) = (view[beam].range_m(), view[next].range_m());
            let either = if rng.random_bool(0.5) { beam } else { next };
            if rng.random_bool(self.mixed_at_edges) {
                readings[either] = Reading::Mixed(self.quantised(from_m + (to_m - from_m) * rng.random::<f64>()));
            } else if rng.random_bool(self.loss_at_edges) {
                readings[either] = Reading::Nothing;
            }
        }
    }

    /// The beams whose next beam meets something far behind or in front.
    fn edges(&self, view: &[Echo]) -> Vec<usize> {
        let n = view.len();
        let step_m = |beam: usize| {
            let next = if self.full_turn() { (beam + 1) % n } else { (beam + 1).min(n - 1) };
            (view[next].range_m() - view[beam].range_m()).abs()
        };
        let is_edge = |&beam: &usize| {
            let beside_m = [(beam + n - 1) % n, (beam + 1) % n].map(step_m);
            // Beams without an echo are no side of an edge and give no change to compare with.
            let known = beside_m.into_iter().filter(|step_m| step_m.is_finite()).fold(0.0, f64::max);
            step_m(beam).is_finite() && step_m(beam) > JUMP_M.max(JUMP_FACTOR * known)
        };
        (0..n).filter(is_edge).collect()
    }

    /// Loses runs of neighbouring beams until the given share is lost in patches.
    fn lose_patches(&self, readings: &mut [Reading], rng: &mut Generator) {
        let n = readings.len();
        let wanted = (self.patch_share.clamp(0.0, 1.0) * n as f64).round() as usize;
        let mut lost = vec![false; n];
        let mut count = 0;
        while count < wanted {
            let start = rng.random_range(0..n);
            let length = rng.random_range(self.patch_beams[0]..=self.patch_beams[1]).max(1);
            // A patch continues at the first beam if that is the neighbour of the last one.
            let end = if self.full_turn() { start + length } else { (start + length).min(n) };
            for beam in (start..end).map(|beam| beam % n) {
                count += usize::from(!std::mem::replace(&mut lost[beam], true));
                readings[beam] = Reading::Nothing;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Network, Point};
    use crate::noise::generator;
    use crate::pose::{Motion, Pose};
    use crate::surface::Texture;

    /// A tunnel 4 m wide.
    fn tunnel(wet_share: f64) -> Surface {
        let mut network = Network::new(4.0);
        let start = network.add_node(Point::new(-30.0, 0.0));
        network.add_branch(start, vec![Point::new(-30.0, 0.0), Point::new(30.0, 0.0)], vec![2.0; 2]);
        Surface::new(&network, &Texture { wet_share, ..Texture::SMOOTH }, 0)
    }

    /// Readings of many sweeps from the middle of the tunnel, with the noise-free view.
    fn sweeps(lidar: &Lidar, surface: &Surface) -> (Vec<Echo>, Vec<Vec<Reading>>) {
        let view = lidar.view(surface, 4.0, &Motion::still(Pose::level(Point::origin(), 0.0)));
        let mut rng = generator(1, "test");
        let readings = (0..200).map(|_| lidar.read(surface, &view, &mut rng)).collect();
        (view, readings)
    }

    /// Share of the sweeps in which `beam` is lost.
    fn lost(readings: &[Vec<Reading>], beam: usize) -> f64 {
        let lost = readings.iter().filter(|sweep| sweep[beam] == Reading::Nothing).count();
        lost as f64 / readings.len() as f64
    }

    #[test]
    fn noise_has_the_stated_size_and_ranges_are_rounded() {
        let lidar = Lidar { noise_sd_m: 0.02, quantum_m: 0.005, ..Lidar::CLEAN };
        let (_, readings) = sweeps(&lidar, &tunnel(0.0));
        // Beam 270 looks at the wall 2 m to the left.
        let errors: Vec<f64> = readings
            .iter()
            .map(|sweep| match sweep[270] {
                Reading::Echo(range_m) => {
                    assert!((range_m / 0.005 - (range_m / 0.005).round()).abs() < 1e-9);
                    range_m - 2.0
                }
                other => panic!("{other:?} at the wall"),
            })
            .collect();
        let sd_m = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((sd_m - 0.02).abs() < 0.004, "{sd_m}");
    }

    #[test]
    fn each_kind_of_loss_has_the_stated_probability() {
        // Beam 270 meets the wall head on 2 m away, beam 190 at 10° of incidence 11.5 m away.
        let losses = |lidar: Lidar, wet_share: f64| {
            let (_, readings) = sweeps(&lidar, &tunnel(wet_share));
            [lost(&readings, 270), lost(&readings, 190)]
        };
        let near = |found: [f64; 2], wanted: [f64; 2]| {
            assert!((0..2).all(|i| (found[i] - wanted[i]).abs() < 0.1), "{found:?} is not {wanted:?}");
        };
        near(losses(Lidar::CLEAN, 0.0), [0.0, 0.0]);
        near(losses(Lidar { loss: 0.3, ..Lidar::CLEAN }, 0.0), [0.3, 0.3]);
        near(losses(Lidar { loss_at_range_max: 0.8, ..Lidar::CLEAN }, 0.0), [0.8 * 0.0178, 0.8 * 0.589]);
        near(losses(Lidar { loss_at_grazing: 0.8, ..Lidar::CLEAN }, 0.0), [0.0, 0.8 * (1.0 - 0.1736 / 0.3420)]);
        near(losses(Lidar { loss_on_wet: 0.7, ..Lidar::CLEAN }, 1.0), [0.7, 0.7]);
        near(losses(Lidar { loss_on_wet: 0.7, ..Lidar::CLEAN }, 0.0), [0.0, 0.0]);
    }

    #[test]
    fn patches_have_the_stated_share_and_length() {
        let lidar = Lidar { patch_share: 0.15, patch_beams: [4, 4], ..Lidar::CLEAN };
        let (view, readings) = sweeps(&lidar, &tunnel(0.0));
        let hit: Vec<usize> = (0..360).filter(|&beam| view[beam] != Echo::Nothing).collect();
        let share = hit.iter().map(|&beam| lost(&readings, beam)).sum::<f64>() / hit.len() as f64;
        assert!((0.14..0.18).contains(&share), "{share}");
        for sweep in &readings {
            // Between beams 60 and 120 everything returns unless it lies in a patch.
            let gone: Vec<bool> = (60..120).map(|beam| sweep[beam] == Reading::Nothing).collect();
            for run in gone[4..56].split(|gone| !gone).filter(|run| !run.is_empty()) {
                let at_the_rim = gone[4..8].iter().all(|&g| g) || gone[52..56].iter().all(|&g| g);
                assert!(run.len() >= 4 || at_the_rim || gone[4] || gone[55], "a run of {}", run.len());
            }
        }
    }

    #[test]
    fn dust_is_nearer_than_the_wall_and_within_its_range() {
        let lidar = Lidar { dust: 0.2, dust_range_m: 6.0, ..Lidar::CLEAN };
        let (view, readings) = sweeps(&lidar, &tunnel(0.0));
        let mut count = 0;
        for sweep in &readings {
            for (echo, reading) in view.iter().zip(sweep) {
                let Reading::Dust(dust_m) = *reading else { continue };
                count += 1;
                assert!((0.3..=6.0).contains(&dust_m));
                assert!(!matches!(*echo, Echo::Rock { range_m, .. } if dust_m >= range_m));
            }
        }
        let share = f64::from(count) / (200.0 * 360.0);
        assert!((share - 0.2).abs() < 0.01, "{share}");
    }

    #[test]
    fn mixed_returns_lie_between_both_sides_of_an_edge() {
        // A branch to the left: its corners, at (2, 2) and (-2, 2), hide parts of its walls.
        let mut network = Network::new(4.0);
        let junction = network.add_node(Point::origin());
        for end in [Point::new(-30.0, 0.0), Point::new(30.0, 0.0), Point::new(0.0, 30.0)] {
            network.add_branch(junction, vec![Point::origin(), end], vec![2.0; 2]);
        }
        let surface = Surface::new(&network, &Texture::SMOOTH, 0);
        let lidar = Lidar { mixed_at_edges: 1.0, ..Lidar::CLEAN };
        let view = lidar.view(&surface, 4.0, &Motion::still(Pose::level(Point::new(6.0, 0.0), 0.0)));
        let edges = lidar.edges(&view);
        assert!((1..=2).contains(&edges.len()), "{edges:?}");
        let readings = lidar.read(&surface, &view, &mut generator(1, "test"));
        let mixed = readings.iter().filter(|reading| matches!(reading, Reading::Mixed(_))).count();
        assert_eq!(mixed, edges.len());
        for beam in edges {
            let [a_m, b_m] = [view[beam].range_m(), view[beam + 1].range_m()];
            let is_between = |reading: &Reading| matches!(*reading, Reading::Mixed(m) if (m - a_m) * (m - b_m) <= 1e-3);
            assert!(readings[beam..=beam + 1].iter().any(is_between), "{a_m} {b_m} {readings:?}");
        }
        let lossy = Lidar { loss_at_edges: 1.0, ..Lidar::CLEAN };
        let lost = |lidar: &Lidar| {
            let readings = lidar.read(&surface, &view, &mut generator(1, "test"));
            readings.iter().filter(|reading| **reading == Reading::Nothing).count()
        };
        assert_eq!(lost(&lossy), lost(&Lidar::CLEAN) + lidar.edges(&view).len());
    }
}
