//! `passage`: edges along each wall, and none where a vehicle could pass.

mod chains;
mod context;
mod dark;
mod decision;
mod gap;
mod joining;
mod judge;
mod line;
mod mouth;
mod odds;
mod rules;
mod terms;
mod verdict;
mod widths;

use crosscut_scan::{Directions, ISLAND_M, LEAST_WALL_RETURNS, Lengths, LostBeams, Pieces, Scan, VEHICLE_WIDTH_M};
use crosscut_stage::NoteCode::{N060, N061};
use crosscut_stage::{
    Affinity, AffinityStage, Flag, Invariance, Kind, Names, Notes, Number, Params, Revolution, StageError, Verdict,
    counted,
};

use chains::Chains;
use context::ScanContext;
use judge::{Judge, lost_beams};
use verdict::Rules;

pub use odds::{MEASURES, Measures};

/// Length of wall over which the direction of its end is taken.
const STRETCH_M: f64 = 0.85;
/// A piece with fewer returns than there are beams in this angle is no wall.
const WALL_RAD: f64 = 3.0_f64.to_radians();

const LEAK: Number = Number::new("leak", "", 1e-8).from(0.0).to(1.0).doc(
    "a weak edge over each opening makes an eigenvalue of leak/2 divided by the odds that a vehicle can pass; the zero tolerance follows it; 0: no such edges",
);

const WITHOUT: Names =
    Names::any_of("without", &verdict::NAMES).doc("rules and vetoes that are left out, to see what each is good for");

const WIDTHS: Flag = Flag::new("widths", false).doc(
    "report the widths of the vehicle for which the count stays the same; decides each scan about a hundred times",
);

/// The graph of the walls.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "passage",
    "edges along the walls, over gaps that only hide them, and none where a vehicle could pass",
    |params| Box::new(PassageAffinity::new(params)),
)
.params(&[
    VEHICLE_WIDTH_M.shared("vehicle.width_m"),
    ISLAND_M.shared("report.island_m"),
    LEAK.spec,
    WITHOUT.spec,
    WIDTHS.spec,
])
.needs_beams()
// It sees ranges, and the order of the beams.
.blind_to(&[Invariance::Turn, Invariance::Mirror]);

/// The graph of the walls. Anticlockwise around the sensor:
///
/// 1. [`Scan`] makes the geometry: dust, mixed returns beside pillars and the vehicle's own returns are left out, the
///    ring of the others is cut where two neighbours are a vehicle's width apart, and islands are taken out.
/// 2. `Gap` measures each gap between two pieces: how much the wall turns, the clear width, the depth, what is dark.
///    With the directions t and t' of the two ends and the chord c between them, the wall turns by T = ∠(t, c) + ∠(c,
///    t').
/// 3. A table (`verdict.rs`) lists the rules and the vetoes. Rules (`rules.rs`, `dark.rs`, `mouth.rs`) measure how much
///    room there is for an opening, divided by how much one needs. At 1 and more a vehicle can pass. Vetoes (`line.rs`,
///    `mouth.rs`) hold where the wall plainly continues, or the gap is a slit, or an opening is too doubtful
///    (`odds.rs`). `without` leaves some of them out.
/// 4. Pieces between which no vehicle can pass are joined, at the least |T| first, so that directions come from ever
///    longer walls (`joining.rs`). Then walls are cut where a vehicle can pass between all before a gap and all behind
///    it, and what is too small for a wall is joined again. What is left over goes to the nearer of the walls beside
///    it.
/// 5. Each wall and each island becomes a chain (`chains.rs`): W_ij = Π exp(-c_g) over the gaps g between i and j,
///    which were joined at cost c_g, for the two returns on either side of i. These weights do not fall with
///    the spacing of returns, so the second eigenvalue of a wall's block does not either. From wall to wall there is
///    one weak edge over each opening. Its eigenvalue is half of `leak`, divided by the odds (`odds.rs`) that a vehicle can pass.
struct PassageAffinity {
    lengths: Lengths,
    rules: Rules,
    leak: f64,
    tells_widths: bool,
    chains: Chains,
    scan: Scan,
    directions: Directions,
    walls: Pieces,
}

impl PassageAffinity {
    fn new(params: &Params) -> Self {
        let lengths =
            Lengths { passage_m: params.get(VEHICLE_WIDTH_M), island_m: params.get(ISLAND_M), stretch_m: STRETCH_M };
        Self {
            lengths,
            rules: Rules::without(&params.get(WITHOUT)),
            leak: params.get(LEAK),
            tells_widths: params.get(WIDTHS),
            chains: Chains::default(),
            scan: Scan::default(),
            directions: Directions::default(),
            walls: Pieces::default(),
        }
    }

    /// The widths of the vehicle, about its own one, for which there are as many walls. There are as many islands, too: the
    /// report counts an island that it does not take for one as a wall.
    fn count_holds_m(&mut self, revolution: &Revolution) -> Option<[f64; 2]> {
        let (width_m, mut other) = (self.lengths.passage_m, Affinity::default());
        let mut count_at = |width_m: f64| {
            self.lengths.passage_m = width_m;
            let done = self.write_walls(revolution, &mut other, &mut Notes::default());
            done.is_ok().then_some([self.walls.len(), self.scan.islands.pieces.len()])
        };
        let holds_m = count_at(width_m).map(|count| widths::hold_m(width_m, |m| count_at(m) == Some(count)));
        self.lengths.passage_m = width_m;
        holds_m
    }

    /// Writes W and the verdicts of a sweep.
    fn write_walls(
        &mut self,
        revolution: &Revolution,
        out: &mut Affinity,
        notes: &mut Notes,
    ) -> Result<(), StageError> {
        let Some(sweep) = revolution.beams() else { return Err(StageError::without_beams("passage")) };
        let Self { lengths, rules, scan, directions, walls, .. } = self;
        scan.make(sweep, &revolution.points_m, lengths)?;
        if scan.dust_returns > 0 {
            let dust_returns = counted(scan.dust_returns as u64, "return");
            notes.add(N060, format!("passage: {dust_returns} in the air (dust, edges of pillars) ignored"));
        }
        if scan.self_returns > 0 {
            let (inside, inside_m) = (counted(scan.self_returns as u64, "return"), lengths.passage_m / 2.0);
            notes.add(
                N061,
                format!(
                    "passage: {inside} within the vehicle, nearer than {inside_m} m (half of vehicle.width_m), ignored"
                ),
            );
        }

        // A step of 0 gives an infinite number: then no piece is a wall.
        let least_returns = ((WALL_RAD / scan.ring.step_rad).round() as usize).max(LEAST_WALL_RETURNS);
        directions.start(&scan.ring, &scan.roughness, lengths.stretch_m);
        let mut context = ScanContext { scan, lengths: *lengths, lost: LostBeams::default() };
        context.lost = lost_beams(&context, directions);
        let mut judge = Judge::new(&context, *rules, directions);
        walls.clone_from(&scan.pieces);
        let mut left_over = joining::join(&mut judge, walls, least_returns);
        if joining::cut_at_openings(&mut judge, walls) {
            left_over.extend(joining::join(&mut judge, walls, least_returns));
        }
        self.chains.write(&mut judge, walls, &left_over, self.leak, out);
        Ok(())
    }
}

/// The verdicts of a revolution, each with what its odds rest on ([`MEASURES`]); `None` where too little is seen. The odds
/// are fitted to these.
///
/// # Errors
/// As the stage.
pub fn measured_gaps(revolution: &Revolution, params: &Params) -> Result<Vec<(Verdict, Option<Measures>)>, StageError> {
    let (mut passage, mut out) = (PassageAffinity::new(params), Affinity::default());
    passage.weigh(revolution, &mut out, &mut Notes::default())?;
    Ok(out.verdicts.into_iter().zip(passage.chains.measures).collect())
}

impl AffinityStage for PassageAffinity {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        // First, so that the buffers end with the walls of the vehicle's own width.
        let holds_m = if self.tells_widths { self.count_holds_m(revolution) } else { None };
        self.write_walls(revolution, out, notes)?;
        out.holds_for_width_m = holds_m;
        Ok(())
    }
}
