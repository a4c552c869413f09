//! The count in one sentence, and what would make it another one.

use crosscut_stage::{Frame, Verdict, counted};

use crate::Explanation;

/// A verdict whose room differs from what an opening needs by more than this factor is not near to another one.
const NEAR: f64 = 10.0;
/// A wall of at most this many returns may be none.
const FEW: usize = 3;

/// What is nearest to another count.
enum Nearest {
    /// Two walls with this gap between them, metres, would be one.
    Joined([u32; 2], f64),
    /// One wall with returns this far apart, metres, would be two.
    Broken(u32, f64),
}

impl Explanation {
    /// The count: "4 walls." And what is nearest to another one: "It would be 3 if orange and blue were one: the gap between
    /// them is 3.2 m. Without vermilion, which has 2 returns, it would be 3."; empty if nothing is known to be near. `color_of`
    /// names the colour in which a wall is drawn.
    pub fn sentence(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> [String; 2] {
        let count = frame.junction.junctions;
        let walls = if frame.revolution.is_empty() {
            "No wall: the scan has no return.".to_owned()
        } else {
            format!("{}.", counted(count as u64, "wall"))
        };
        let named = |wall: u32| {
            let color = color_of(wall);
            let shared = frame.junction.walls.iter().filter(|other| color_of(other.id) == color).count() > 1;
            if shared || color.is_empty() { format!("wall {wall}") } else { color.to_owned() }
        };
        let near = self.nearest(frame).map(|nearest| match nearest {
            Nearest::Joined([a, b], gap_m) => format!(
                "It would be {} if {} and {} were one: the gap between them is {gap_m:.1} m.",
                count.saturating_sub(1),
                named(a),
                named(b)
            ),
            Nearest::Broken(wall, gap_m) => format!(
                "It would be {} if {} were two: neighbours in it are {gap_m:.1} m apart.",
                count + 1,
                named(wall)
            ),
        });
        let small = frame.junction.walls.iter().filter(|wall| !wall.island && wall.returns <= FEW && count > 1);
        let without = small.min_by_key(|wall| wall.returns).map(|wall| {
            let (name, returns) = (named(wall.id), counted(wall.returns as u64, "return"));
            format!("Without {name}, which has {returns}, it would be {}.", count - 1)
        });
        [walls, near.into_iter().chain(without).collect::<Vec<_>>().join(" ")]
    }

    /// By the verdict nearest to its threshold where an affinity decides gap by gap, else by the smallest change of τ, else
    /// by the two closest walls.
    fn nearest(&self, frame: &Frame) -> Option<Nearest> {
        let points_m = &frame.revolution.points_m;
        let gap_m = |[i, j]: [usize; 2]| Some((points_m.get(i)? - points_m.get(j)?).norm());
        let is_island = |wall: u32| frame.junction.walls.iter().any(|other| other.id == wall && other.island);
        let joined = |walls: [u32; 2], returns| {
            (!walls.into_iter().any(is_island)).then_some(())?;
            Some(Nearest::Joined(walls, gap_m(returns)?))
        };
        let by_verdict = |verdict: &Verdict| {
            let returns = verdict.returns.map(|i| i as usize);
            let [a, b] = returns.map(|i| frame.junction.wall_of_return.get(i).copied().flatten());
            match (a?, b?, verdict.is_opening) {
                (a, b, true) if a != b => joined([a, b], returns),
                (a, b, false) if a == b && !is_island(a) => Some(Nearest::Broken(a, gap_m(returns)?)),
                _ => None,
            }
        };
        let doubt = |verdict: &Verdict| verdict.room_ratio.ln().abs();
        let mut verdicts: Vec<&Verdict> =
            frame.affinity.verdicts.iter().filter(|verdict| doubt(verdict) < NEAR.ln()).collect();
        verdicts.sort_by(|a, b| doubt(a).total_cmp(&doubt(b)));
        let by_change = || {
            self.changes.iter().find_map(|change| match (&change.walls[..], change.edge?) {
                (&[a, b], edge) => joined([a, b], edge.returns),
                (&[wall], edge) if !is_island(wall) => Some(Nearest::Broken(wall, gap_m(edge.returns)?)),
                _ => None,
            })
        };
        let by_distance = || self.closest.and_then(|(walls, returns)| joined(walls, returns));
        verdicts.into_iter().find_map(by_verdict).or_else(by_change).or_else(by_distance)
    }
}
