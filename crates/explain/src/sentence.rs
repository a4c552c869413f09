//! The count in one sentence, and what would make it another one.

use crosscut_stage::{Frame, Verdict, counted};

use crate::doubtful::FEW;
use crate::words::{power, wall};
use crate::{Change, Explanation};

/// A verdict whose room differs from what an opening needs by more than this factor is not near to another one.
const NEAR: f64 = 10.0;

/// The gap at which another decision gives the nearest other count.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// The count that there would be.
    pub count: usize,
    /// Two walls that would be one, or one that would be two.
    pub walls: Vec<u32>,
    /// The returns on both sides of the gap.
    pub returns: [usize; 2],
    /// From one to the other, metres.
    pub gap_m: f64,
}

impl Explanation {
    /// The count: "4 walls." And what is nearest to another one: "Without 3 (vermilion), which has
    /// 2 returns, it would be 3. It would be 3 if 1 (orange) and 2 (blue) were one: their ends are 3.2 m apart."; empty if nothing is known to be near.
    /// `color_of` names the colour in which a wall is drawn.
    pub fn sentence(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> [String; 2] {
        let count = frame.junction.junctions;
        let walls = if frame.revolution.is_empty() {
            "No wall: the scan has no return.".to_owned()
        } else {
            format!("{}.", counted(count as u64, "wall"))
        };
        let named = |id: u32| wall(id, color_of(id));
        let near = self.nearest(frame).map(|Nearest { count, walls, gap_m, .. }| match walls[..] {
            [a, b] => format!(
                "It would be {count} if {} and {} were one: their ends are {gap_m:.1} m apart.",
                named(a),
                named(b)
            ),
            _ => format!(
                "It would be {count} if {} were two: neighbours in it are {gap_m:.1} m apart.",
                walls.first().map_or_else(String::new, |one| named(*one))
            ),
        });
        let by_spectrum = || {
            self.changes
                .first()
                .filter(|_| frame.affinity.verdicts.is_empty())
                .map(|change| spectral(change, frame, &named))
        };
        let doubtful = frame.junction.walls.iter().find(|wall| Some(wall.id) == self.may_be_none);
        let without = doubtful.map(|of| {
            let why = if of.returns <= FEW {
                format!("has {}", counted(of.returns as u64, "return"))
            } else {
                "stands free inside a gap".to_owned()
            };
            format!("Without {}, which {why}, it would be {}.", named(of.id), count.saturating_sub(1))
        });
        let near = near.or_else(by_spectrum);
        [walls, without.into_iter().chain(near).collect::<Vec<_>>().join(" ")]
    }

    /// By the verdict nearest to its threshold where an affinity decides gap by gap, else by the smallest change of τ that an
    /// edge explains, else by the two closest walls.
    pub fn nearest(&self, frame: &Frame) -> Option<Nearest> {
        let (points_m, count) = (&frame.revolution.points_m, frame.junction.junctions);
        let is_island = |wall: u32| frame.junction.walls.iter().any(|other| other.id == wall && other.island);
        let near = |walls: &[u32], returns: [usize; 2]| {
            let [a, b] = returns.map(|i| points_m.get(i));
            let count = if walls.len() > 1 { count.saturating_sub(1) } else { count + 1 };
            let of = Nearest { count, walls: walls.to_vec(), returns, gap_m: (a? - b?).norm() };
            (!walls.iter().copied().any(is_island)).then_some(of)
        };
        let by_verdict = |verdict: &Verdict| {
            let returns = verdict.returns.map(|i| i as usize);
            let [a, b] = returns.map(|i| frame.junction.wall_of_return.get(i).copied().flatten());
            match (a?, b?, verdict.is_opening) {
                (a, b, true) if a != b => near(&[a, b], returns),
                (a, b, false) if a == b => near(&[a], returns),
                _ => None,
            }
        };
        let doubt = |verdict: &Verdict| verdict.room_ratio.ln().abs();
        let mut verdicts: Vec<&Verdict> =
            frame.affinity.verdicts.iter().filter(|verdict| doubt(verdict) < NEAR.ln()).collect();
        verdicts.sort_by(|a, b| doubt(a).total_cmp(&doubt(b)));
        let by_change = || self.changes.iter().find_map(|change| near(&change.walls, change.edge?.returns));
        let by_distance = || self.closest.and_then(|(walls, returns)| near(&walls, returns));
        verdicts.into_iter().find_map(by_verdict).or_else(by_change).or_else(by_distance)
    }
}

/// By which tolerance there would be another count, where no single edge explains that.
fn spectral(change: &Change, frame: &Frame, named: &dyn Fn(u32) -> String) -> String {
    let Change { k, eigenvalue, decades, walls, .. } = change;
    let (of, side) = if *k > frame.spectrum.k { (*k, "above") } else { (frame.spectrum.k, "below") };
    let joined = match walls[..] {
        [a, b] => format!("; {} and {} are the nearest to being one", named(a), named(b)),
        _ => String::new(),
    };
    format!(
        "k would be {k} with a tolerance {side} λ{of} = {}, {:.1} decades from τ{joined}. No single edge decides that.",
        power(*eigenvalue),
        decades.abs()
    )
}
