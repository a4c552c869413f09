//! Whether a wall continues across a gap, at which cost, or a vehicle can pass.

use std::f64::consts::PI;

use crosscut_scan::{Directions, LostBeams, Position};

use super::context::ScanContext;
use super::decision::Decision;
use super::gap::{Gap, ends_run};
use super::odds::Measures;
use super::verdict::Rules;

/// A wall clearly continues across a gap where it turns by less than this.
const GOES_ON_RAD: f64 = 30.0 * PI / 180.0;
/// Where a wall clearly continues, neither end is off the line of the other piece by more than this share of the place's
/// size.
const GOES_ON_OFF_SHARE: f64 = 0.3;

/// Turns are known to within this much.
const DOUBT_RAD: f64 = 5.0 * PI / 180.0;
/// The room ratio of an opening is at least this.
const LEAST_ROOM_RATIO: f64 = 1.05;
/// The room ratio of an opening between pieces without directions.
const ROOM_RATIO_WITHOUT_DIRECTION: f64 = 3.0;

/// A piece without a direction belongs to a wall if it lies within this of the line of the wall.
const OFF_LINE_M: f64 = 0.3;
/// A piece without a direction may lie farther off the line of its wall by this share of its distance.
const OFF_LINE_SHARE: f64 = 0.15;
/// Two pieces without a direction are of one wall at grazing incidence if at least this share of their distance is along the
/// beams.
const GRAZING_SHARE: f64 = 0.8;

/// Joining two pieces with directions costs this, and one for each radian of turn.
const COST: f64 = 0.1;
/// Joining two pieces costs this for each radian that the wall turns at the end where it turns less.
const DETOUR_COST: f64 = 0.2;
/// Joining two pieces costs this for each metre of the gap, if that is longer than [`LONG_GAP_M`] or a piece has no
/// direction.
const COST_PER_M: f64 = 0.05;
/// Shorter gaps between pieces with directions cost nothing for their length.
const LONG_GAP_M: f64 = 3.0;
/// Joining a piece without a direction to one that has one costs this at least.
const COST_OF_SMALL: f64 = 0.3;
/// Joining two pieces without directions costs this at least.
const COST_OF_TWO_SMALL: f64 = 1.0;
/// Joining two pieces without directions costs this for each metre of the gap.
const COST_OF_TWO_SMALL_PER_M: f64 = 0.1;

/// Judges the gaps of one scan.
pub(super) struct Judge<'s> {
    pub(super) context: &'s ScanContext<'s>,
    rules: Rules,
    directions: &'s mut Directions,
}

/// What it takes to join the two pieces at a gap.
pub(super) struct Joint<'p> {
    /// `None` where a vehicle could pass.
    pub(super) cost: Option<f64>,
    /// The gap and the decision at it; `None` if a piece has no direction.
    judged: Option<(Gap<'p>, Decision)>,
}

/// The beams that are lost within the pieces of a scan, and between two pieces where the wall clearly continues.
pub(super) fn lost_beams(context: &ScanContext<'_>, directions: &mut Directions) -> LostBeams {
    let (ring, pieces, mut lost) = (&context.scan.ring, &context.scan.pieces, LostBeams::default());
    for pair in pieces.iter().flat_map(|piece| piece.windows(2)) {
        lost.count(ring, ring.dark_between(pair[0], pair[1]));
    }
    let gaps = if ring.full_turn { pieces.len() } else { pieces.len().saturating_sub(1) };
    for at in 0..gaps {
        let (a, b) = (&pieces[at], &pieces[pieces.next(at)]);
        let beams = ring.dark_between(a[a.len() - 1], b[0]);
        if beams > 0 && Gap::between(context, a, b, directions).is_some_and(|gap| clearly_goes_on(&gap)) {
            lost.count(ring, beams);
        }
    }
    lost
}

fn clearly_goes_on(gap: &Gap<'_>) -> bool {
    let off_m = gap.clear_m.max(gap.depth_m.abs());
    off_m < GOES_ON_OFF_SHARE * gap.context.scan.size_m && gap.turns.whole_rad < GOES_ON_RAD
}

impl<'s> Judge<'s> {
    /// The judge of a context by these rules; the directions are those of its scan.
    pub(super) fn new(context: &'s ScanContext<'s>, rules: Rules, directions: &'s mut Directions) -> Self {
        Self { context, rules, directions }
    }

    /// What is decided at the gap of a joint, and what the odds of that rest on.
    pub(super) fn verdict(&self, joint: &Joint<'_>) -> Option<(Decision, Option<Measures>)> {
        let (gap, decision) = joint.judged.as_ref()?;
        Some((*decision, Some(self.rules.measures(gap, *decision))))
    }

    /// The cost at which a wall continues from the end of piece `a` to the start of piece `b`, anticlockwise; `None`
    /// where a vehicle could pass between them.
    #[inline]
    pub(super) fn cost(&mut self, a: &[usize], b: &[usize]) -> Option<f64> {
        if self.context.is_gap(a[a.len() - 1], b[0]) { self.joint(a, b).cost } else { Some(0.0) }
    }

    /// What it takes to join two pieces that have a gap between them.
    #[inline]
    pub(super) fn joint<'p>(&mut self, a: &'p [usize], b: &'p [usize]) -> Joint<'p>
    where
        's: 'p,
    {
        match self.directions(a, b) {
            [Some(before), Some(after)] => {
                let gap = Gap::measure(self.context, [a, b], [before, after]);
                let decision = self.rules.decide(&gap);
                let detour_rad = gap.turns.near_rad.abs().min(gap.turns.far_rad.abs());
                let chord_m = gap.chord_m();
                let long = if chord_m > LONG_GAP_M { COST_PER_M * chord_m } else { 0.0 };
                let cost = COST + gap.turns.whole_rad.abs() + DETOUR_COST * detour_rad + long;
                Joint { cost: (!decision.is_opening()).then_some(cost), judged: Some((gap, decision)) }
            }
            [before, after] => Joint { cost: self.cost_of_small(a, b, before.or(after)), judged: None },
        }
    }

    /// The cost of joining two pieces if at most one of them has a direction.
    fn cost_of_small(&self, a: &[usize], b: &[usize], line: Option<Position>) -> Option<f64> {
        let ring = &self.context.scan.ring;
        let (p, q) = (a[a.len() - 1], b[0]);
        let chord = ring.position_m(q) - ring.position_m(p);
        let chord_m = chord.norm();
        let Some(line) = line else {
            let along_m = (ring.range_m(q) - ring.range_m(p)).abs();
            let is_grazing = along_m > GRAZING_SHARE * chord_m;
            return is_grazing.then_some(COST_OF_TWO_SMALL + COST_OF_TWO_SMALL_PER_M * chord_m);
        };
        let along_m = line.dot(&chord);
        let off = line.perp(&chord).abs() / (OFF_LINE_M + OFF_LINE_SHARE * along_m);
        (along_m > 0.0 && off < 1.0).then_some(COST_OF_SMALL + off + COST_PER_M * chord_m)
    }

    /// The room ratio between two pieces with directions, if that makes an opening.
    pub(super) fn room_ratio_of_opening(&mut self, a: &[usize], b: &[usize]) -> Option<f64> {
        let gap = Gap::between(self.context, a, b, self.directions)?;
        let decision = self.rules.decide(&gap);
        decision.is_opening().then_some(decision.room_ratio)
    }

    /// What makes the gap between two walls an opening, and the least room that there is, or would be if the wall turned
    /// by [`DOUBT_RAD`] less or more. With what its odds rest on, unless a piece has no direction.
    pub(super) fn least_room(&mut self, a: &[usize], b: &[usize]) -> (Decision, Option<Measures>) {
        let Some(gap) = Gap::between(self.context, a, b, self.directions) else {
            let reason = "too little is seen for a direction";
            let room_ratio = ROOM_RATIO_WITHOUT_DIRECTION;
            return (Decision { room_ratio, reason, measured: None, ratio_by_rules: room_ratio }, None);
        };
        let decision = self.rules.decide(&gap);
        let turned = [-DOUBT_RAD, DOUBT_RAD].map(|more_rad| self.rules.decide(&gap.turned_by(more_rad)).room_ratio);
        let least = turned.into_iter().fold(decision.room_ratio, f64::min);
        (Decision { room_ratio: least.max(LEAST_ROOM_RATIO), ..decision }, Some(self.rules.measures(&gap, decision)))
    }

    /// The directions in which a wall runs at the end of piece `a` and on from the start of piece `b`, if they have
    /// one.
    pub(super) fn directions(&mut self, a: &[usize], b: &[usize]) -> [Option<Position>; 2] {
        ends_run(self.context, a, b, self.directions)
    }
}
