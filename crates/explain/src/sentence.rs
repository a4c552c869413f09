//! The count in one sentence, and what would make it another one.

use crosscut_stage::{Frame, SURE, counted};

use crate::doubtful::FEW;
use crate::nearest::Nearest;
use crate::words::{power, wall};
use crate::{Change, Explanation, ways};

impl Explanation {
    /// The count: "4 walls." or "4 walls and 1 island." And what is nearest to another one: "Without wall 3 (vermilion), which
    /// has 2 returns, there would be 3 walls. There would be 3 walls if wall 1 (orange) and wall 2 (blue) were one: their ends
    /// are 3.2 m apart."; empty if nothing is known to be near. Of ways on: "4 ways on. Level view: 3 walls.", R, the least
    /// sure of them that is not sure, and what parts the two that are nearest to being one.
    /// `color_of` names the colour in which a wall is drawn.
    pub fn sentence(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> [String; 2] {
        let count = frame.junction.junctions;
        let walls = |count: usize| counted(count as u64, "wall");
        let islands = frame.junction.walls.iter().filter(|wall| wall.island).count();
        let title = match islands {
            _ if frame.revolution.is_empty() => "No wall: the scan has no return.".to_owned(),
            0 => format!("{}.", walls(count)),
            _ => format!("{} and {}.", walls(count), counted(islands as u64, "island")),
        };
        if let Some(ways) = &frame.junction.ways {
            let least = ways.iter().filter(|way| way.p < SURE).min_by(|a, b| a.p.total_cmp(&b.p));
            let least = least.map(|way| format!("The least sure is {}, p = {:.2}.", way.words(), way.p));
            let dual = frame.affinity.dual.as_ref();
            let nearest = dual.and_then(|dual| ways::nearest(ways, dual, color_of));
            let room = dual.filter(|dual| dual.room_m > 0.0).map(|dual| {
                format!("R is {:.1} m: the radius of the largest ball that holds the sensor.", dual.room_m)
            });
            let reason = room.into_iter().chain(least).chain(nearest).collect::<Vec<_>>().join(" ");
            let walls = if frame.revolution.is_empty() { "no wall." } else { &title };
            return [format!("{} on. Level view: {walls}", counted(ways.len() as u64, "way")), reason];
        }
        let named = |id: u32| wall(id, color_of(id));
        let near = self.nearest.as_ref().map(|Nearest { count, walls: of, gap_m, .. }| {
            let (are, gap) = match of[..] {
                [a, b] => (format!("{} and {} were one", named(a), named(b)), "their ends"),
                _ => (format!("{} were two", of.iter().copied().map(named).collect::<String>()), "neighbours in it"),
            };
            format!("There would be {} if {are}: {gap} are {gap_m:.1} m apart.", walls(*count))
        });
        let change = || self.changes.first().filter(|_| frame.affinity.verdicts.is_empty());
        let by_spectrum = || change().map(|change| spectral(change, frame, &named));
        let doubtful = frame.junction.walls.iter().find(|wall| Some(wall.id) == self.may_be_none);
        let without = doubtful.map(|of| {
            let few = format!("has {}", counted(of.returns as u64, "return"));
            let why = if of.returns <= FEW { &few } else { "stands free inside a gap" };
            format!("Without {}, which {why}, there would be {}.", named(of.id), walls(count.saturating_sub(1)))
        });
        let near = near.or_else(by_spectrum);
        [title, without.into_iter().chain(near).collect::<Vec<_>>().join(" ")]
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
        "{} would count as zero, not {}, with a tolerance {side} {} (λ{of}), {:.1} decades from τ{joined}. No single \
         edge decides that.",
        counted(*k as u64, "eigenvalue"),
        frame.spectrum.k,
        power(*eigenvalue),
        decades.abs()
    )
}
