//! The report stage: walls, then openings, then the name of the place.

use crosscut_scan::{ISLAND_M, VEHICLE_WIDTH_M};
use crosscut_stage::NoteCode::{N080, N081, N082};
use crosscut_stage::{
    Affinity, Count, Junction, Notes, Number, ParamSpec, Params, Partition, Revolution, Spectrum, StageError, Sweep,
    Verdict, Word,
};

use crate::confidence::Grounds;
use crate::openings::{self, OpeningRule};
use crate::wall_ring::WallRing;
use crate::{confidence, doorway, islands, known, odds, place, walls, ways};

/// The confidence of an answer without any way on: a closed place, or a sensor that the vehicle covers.
const OF_NO_WAY: f64 = 0.5;

const MIN_RETURNS: Count = Count::new("min_returns", "returns", 1)
    .from(1)
    .to(1_000_000)
    .doc("clusters with fewer returns are no wall; their returns are labelled -2");

const OPENINGS: Word = Word::one_of("openings", &["free_space", "between_walls"])
    .doc("where openings are: where the vehicle fits into free space, or wherever one wall ends and another begins");

/// What the confidence is computed from. Those of two rules cannot be compared.
pub const CONFIDENCE: Word = Word::one_of("confidence", &["margin", "scene"])
    .doc("what the confidence is computed from: the zero rule's margin, or how clear the verdicts at the gaps of the scene are");

const MAX_RANGE_M: Number = Number::new("max_range_m", "m", f64::INFINITY)
    .above(0.0)
    .to(f64::INFINITY)
    .doc("openings whose nearer end is farther than this are left out of the list; place and count do not change");

/// Section `report` of the configuration.
pub const PARAMS: &[ParamSpec] = &[MIN_RETURNS.spec, ISLAND_M.spec, OPENINGS.spec, MAX_RANGE_M.spec, CONFIDENCE.spec];

/// Turns clusters into walls and openings.
#[derive(Clone, Debug)]
pub struct Reporter {
    min_returns: usize,
    island_m: f64,
    max_range_m: f64,
    confidence_of_scene: bool,
    /// Nothing was calibrated for the affinity.
    uncalibrated: bool,
    vehicle_width_m: f64,
    openings: OpeningRule,
    outline: WallRing,
}

impl Reporter {
    /// From checked values of [`PARAMS`] and [`VEHICLE_PARAMS`](crosscut_scan::VEHICLE_PARAMS).
    pub fn new(report: &Params, vehicle: &Params) -> Self {
        Self {
            min_returns: report.get(MIN_RETURNS),
            island_m: report.get(ISLAND_M),
            max_range_m: report.get(MAX_RANGE_M),
            confidence_of_scene: report.get(CONFIDENCE) == "scene",
            uncalibrated: false,
            vehicle_width_m: vehicle.get(VEHICLE_WIDTH_M),
            openings: match report.get(OPENINGS).as_str() {
                "between_walls" => OpeningRule::BetweenWalls,
                _ => OpeningRule::FreeSpace,
            },
            outline: WallRing::default(),
        }
    }

    /// For the clusters of a stage that no confidence was calibrated for: there is none, and a note says so.
    pub fn without_confidence(mut self) -> Self {
        self.uncalibrated = true;
        self
    }

    /// Writes walls, openings, the name of the place and the confidence into `out`, whatever `out` held before. Of an affinity
    /// whose rows are directions, the clusters are ways on, and the walls are what a level vehicle sees between level ones.
    ///
    /// # Errors
    /// When there is not one label for each return, or direction.
    pub fn report(
        &mut self,
        revolution: &Revolution,
        affinity: &Affinity,
        spectrum: &Spectrum,
        partition: &Partition,
        out: &mut Junction,
        notes: &mut Notes,
    ) -> Result<(), StageError> {
        out.ways = None;
        if let Some(dual) = &affinity.dual {
            let found = ways::of_clusters(dual, partition)?;
            let (verdicts, partition) = ways::level(&found, dual, revolution, revolution.beams(), self.vehicle_width_m);
            self.walls(revolution, &verdicts, spectrum, &partition, out, notes)?;
            if verdicts.is_empty() && revolution.beams().is_some() {
                // Free space at the height of the vehicle is no way on by itself.
                out.openings.clear();
                out.place = place::name(openings::sees_all(&self.outline), out.junctions, &out.openings);
            }
            // The count is as right as the most doubtful way. That there is none, a sensor that is covered tells as well.
            let least = found.iter().map(|way| way.p).reduce(f64::min);
            let of_none = if dual.cut_m > 0.0 { OF_NO_WAY } else { 0.0 };
            out.confidence = out.confidence.map(|_| least.unwrap_or(of_none));
            out.ways = Some(found);
            return Ok(());
        }
        self.walls(revolution, &affinity.verdicts, spectrum, partition, out, notes)
    }

    /// All but the ways: `partition` has a label for each return.
    fn walls(
        &mut self,
        revolution: &Revolution,
        verdicts: &[Verdict],
        spectrum: &Spectrum,
        partition: &Partition,
        out: &mut Junction,
        notes: &mut Notes,
    ) -> Result<(), StageError> {
        let (n, labelled) = (revolution.len(), partition.labels.len());
        if n != labelled {
            return Err(StageError::Mismatch(format!("labels: {labelled}, returns: {n}")));
        }
        walls::from_partition(revolution, partition, self.min_returns, out, notes);
        let sweep = revolution.beams();
        if let Some(sweep) = sweep {
            self.look_around(revolution, sweep, verdicts, out)?;
        } else {
            // Returns without beams have walls alone.
            let Junction { walls, wall_of_return, .. } = std::mem::take(out);
            *out = Junction { junctions: walls.len(), walls, wall_of_return, ..Junction::default() };
        }
        out.confidence = if self.uncalibrated {
            notes.add(N080, "report: no confidence, as nothing was calibrated for a stage of one's own");
            None
        } else if self.confidence_of_scene && sweep.is_some() {
            Some(self.confidence_of_scene(revolution, verdicts, spectrum.margin_decades, out, notes))
        } else {
            Some(confidence::of_margin(spectrum.margin_decades))
        };
        out.openings.retain(|opening| opening.range_m() <= self.max_range_m);
        Ok(())
    }

    /// Islands, openings and the name of the place, from the walls of a sweep.
    fn look_around(
        &mut self,
        revolution: &Revolution,
        sweep: &Sweep,
        verdicts: &[Verdict],
        out: &mut Junction,
    ) -> Result<(), StageError> {
        let (outline, vehicle_width_m) = (&mut self.outline, self.vehicle_width_m);
        outline.fill(revolution, sweep, &out.wall_of_return)?;
        islands::mark(revolution, self.island_m, vehicle_width_m, outline, out);
        openings::find(self.openings, revolution, verdicts, outline, vehicle_width_m, &mut out.openings);
        out.junctions = out.walls.iter().filter(|wall| !wall.island).count();
        out.place = place::name(openings::sees_all(outline), out.junctions, &out.openings);
        odds::set_of_openings(verdicts, out);
        known::mark(verdicts, outline, vehicle_width_m, out);
        Ok(())
    }

    /// The share of right answers among those on the grounds of this one.
    fn confidence_of_scene(
        &self,
        revolution: &Revolution,
        verdicts: &[Verdict],
        margin_decades: Option<f64>,
        answer: &Junction,
        notes: &mut Notes,
    ) -> f64 {
        let (outline, vehicle_width_m) = (&self.outline, self.vehicle_width_m);
        let spacing_rad = confidence::spacing_rad(outline, &answer.openings);
        if spacing_rad > confidence::COARSE_RAD && !answer.walls.is_empty() {
            let spacing_deg = spacing_rad.to_degrees();
            notes.add(
                N081,
                format!(
                    "report: returns stand {spacing_deg:.1}° apart, too far to tell a gap in a wall: less confidence"
                ),
            );
        }
        let doorway = doorway::doorway(outline, vehicle_width_m);
        if let Some(gap) = &doorway {
            let [from_m, to_m] = gap.ends_m();
            notes.add(N082, format!(
                "report: {:.1} m of a wall returned nothing, so it may be a doorway: counted as wall, with less confidence",
                (to_m - from_m).norm()
            ));
        }
        let remains = confidence::remains(spacing_rad, doorway.is_some()) * confidence::of_smallest_wall(&answer.walls);
        let grounds = Grounds::on(outline, revolution, verdicts, vehicle_width_m, margin_decades, answer);
        grounds.map_or(0.0, |grounds| remains / (1.0 + (-grounds.log_odds(vehicle_width_m)).exp()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_scan::VEHICLE_PARAMS;
    use crosscut_stage::Point;

    #[test]
    fn labels_of_another_revolution_are_an_error_and_not_a_wrong_answer() {
        let mut reporter = Reporter::new(&Params::defaults(PARAMS), &Params::defaults(VEHICLE_PARAMS));
        let revolution = Revolution { points_m: vec![Point::new(1.0, 0.0, 0.0)], ..Default::default() };
        let result = reporter.report(
            &revolution,
            &Affinity::default(),
            &Spectrum::default(),
            &Partition::default(),
            &mut Junction::default(),
            &mut Notes::default(),
        );
        assert_eq!(result, Err(StageError::Mismatch("labels: 0, returns: 1".into())));
    }
}
