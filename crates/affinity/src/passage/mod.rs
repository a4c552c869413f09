//! `passage`: an edge wherever the wall goes on, none where a vehicle could pass.

mod carrying;
mod chains;
mod dark;
mod dust;
mod gap;
mod islands;
mod joining;
mod line;
mod mixed;
mod mouth;
mod pieces;
mod ring;
mod roughness;
mod tangent;
mod way;

use std::cell::RefCell;

use crosscut_stage::{
    Affinity, AffinityStage, Count, Invariance, Kind, LevelView, Notes, Number, Params, Point, Revolution, StageError,
    Storage, Sweep, Verdict, counted,
};

use carrying::Carrying;
use chains::Chains;
use dust::Dust;
use gap::Judge;
use pieces::Pieces;
use ring::Ring;
use roughness::Roughness;
use tangent::Tangents;

const PASSAGE_M: Number = Number::new("passage_m", "m", 0.6)
    .above(0.0)
    .to(100.0)
    .follows("vehicle.width_m", 1.0)
    .doc("vehicle.width_m unless it is set: returns nearer to each other are of one wall; nearer to the sensor than half of it, of none");

const STRETCH_M: Number = Number::new("stretch_m", "m", 0.85)
    .above(0.0)
    .to(100.0)
    .doc("length of wall over which the direction of its end is taken");

const STRAIGHT_DEG: Number = Number::new("straight_deg", "°", 36.0)
    .from(0.0)
    .to(180.0)
    .doc("a wall that turns left by less at a gap goes on behind it; branches turn it by 54° and more");

const WAY_DEG: Number = Number::new("way_deg", "°", 115.0).from(0.0).to(360.0).doc(
    "a wall that turns left by more at a gap ends there, unless the gap is narrow; the corner of a dead end is 90°",
);

const CLEAR_SHARE: Number = Number::new("clear_share", "", 1.15)
    .from(0.0)
    .to(100.0)
    .doc("at turns between the two a wall ends if the gap's clear width is at least this share of the median range");

const ISLAND_M: Number = Number::new("island_m", "m", 2.0)
    .from(0.0)
    .to(100.0)
    .doc("a piece no longer than this that stands in front of what is on both sides of it is cut off; 0: none is");

const WALL_DEG: Number = Number::new("wall_deg", "°", 3.0)
    .from(0.0)
    .to(90.0)
    .doc("a piece with fewer returns than there are beams in this angle, or than three, is no wall");

const NEIGHBOURS: Count = Count::new("neighbours", "returns", 2)
    .from(1)
    .to(1000)
    .doc("each return has an edge to so many of its wall on either side");

const HEIGHT_M: Number = Number::new("height_m", "m", 0.6)
    .above(0.0)
    .to(100.0)
    .follows("vehicle.height_m", 1.0)
    .doc("vehicle.height_m unless it is set: of a cloud, returns farther above or below the sensor than half of it are of no wall");

const LEAK: Number = Number::new("leak", "", 1e-8).from(0.0).to(1.0).doc(
    "the zero tolerance; gaps leak so that their eigenvalues come the nearer to it the less decided they are; 0: none",
);

/// The graph of the walls.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "passage",
    "edges along the walls, over gaps that only hide them, and none where a vehicle could pass",
    |params| Box::new(Passage::new(params)),
)
.params(&[
    PASSAGE_M.spec,
    HEIGHT_M.spec,
    STRETCH_M.spec,
    STRAIGHT_DEG.spec,
    WAY_DEG.spec,
    CLEAR_SHARE.spec,
    ISLAND_M.spec,
    WALL_DEG.spec,
    NEIGHBOURS.spec,
    LEAK.spec,
])
// On average one more edge to and from a return that is left over; an unseen return of a cloud has three.
.storage(Storage::Sparse(|params, _| (2 * params.get(NEIGHBOURS) + 3).max(7)))
// It sees ranges, and the order of the beams.
.blind_to(&[Invariance::Turn, Invariance::Mirror]);

/// The graph of the walls. Anticlockwise around the sensor:
///
/// 1. Dust, isolated returns nearer than what is around them, has no edge. Nor have returns between the edge of a pillar
///    and what is behind it, nor what lies inside the vehicle.
/// 2. The ring of the others is cut where two that follow each other are `passage_m` apart or more.
/// 3. Short pieces that stand free in front of what is on both sides of them are islands.
/// 4. At each gap between two pieces, with the directions t and t' of their ends and the chord c from one to the other,
///    the wall turns by T = ∠(t, c) + ∠(c, t'), and its clear width is the distance of the nearer end from the line of
///    the farther wall. It goes on if T < `straight_deg` (a bump, lost beams), if no vehicle fits into the clear width,
///    or if that is small beside the place, whose size is the median range: less than `clear_share` of it, or than a
///    smaller share if the gap is dark or T > `way_deg`. Else a vehicle can pass: T is 180° where both walls of a
///    tunnel recede. It can as well where nothing is seen over a wide angle, or in a door where no beams get lost, before
///    the face of a corner or of a side passage, where a gap is in plain sight and wider, or the farther wall deeper
///    behind the nearer one, than a bump hides, and where that is seen through a mouth; not where the other side of the
///    place meets the nearer wall in a corner, or where the next beam meets what goes on along its line, no farther away
///    than the spacing of its returns lets expect: nothing is hidden then.
///    Pieces join at the least |T| first, so that directions come from ever longer walls.
/// 5. A wall is cut where a vehicle can pass between all of it before a gap and all of it behind. What is then small,
///    or alone, joins anew. What is left over goes to the nearer of the walls beside it.
///
/// Within a wall, W_ij = Π exp(-c_g) over the gaps g between i and j that were joined at cost c_g, for the `neighbours`
/// returns of the wall on either side of i. The weights along a wall do not fall with the spacing of its returns, so
/// the second eigenvalue of its block does not either. From wall to wall there is one weak edge over each way on: its
/// eigenvalue is half of `leak`, divided by the fourth power of how many times the room that a way on needs there is.
///
/// Of a cloud, what a level vehicle sees of it ([`LevelView`]) is such a sweep. The walls are then carried on to the
/// returns that are not seen, and the graph is made so that the second eigenvalue depends on the walls and not on n.
struct Passage {
    limits: Limits,
    height_m: f64,
    wall_rad: f64,
    leak: f64,
    cloud: Cloud,
    ring: Ring,
    dust: Dust,
    tangents: RefCell<Tangents>,
    walls: Pieces,
    islands: Pieces,
    chains: Chains,
}

/// What is asked of walls, gaps and islands: the parameters of these names.
#[derive(Clone, Copy, Debug)]
struct Limits {
    passage_m: f64,
    stretch_m: f64,
    straight_rad: f64,
    way_rad: f64,
    clear_share: f64,
    island_m: f64,
}

/// Held from one cloud to the next.
#[derive(Clone, Debug, Default)]
struct Cloud {
    view: LevelView,
    /// The graph of what is seen.
    seen: Affinity,
    carrying: Carrying,
}

impl Passage {
    fn new(params: &Params) -> Self {
        let limits = Limits {
            passage_m: params.get(PASSAGE_M),
            stretch_m: params.get(STRETCH_M),
            straight_rad: params.get(STRAIGHT_DEG).to_radians(),
            way_rad: params.get(WAY_DEG).to_radians(),
            clear_share: params.get(CLEAR_SHARE),
            island_m: params.get(ISLAND_M),
        };
        Self {
            limits,
            height_m: params.get(HEIGHT_M),
            cloud: Cloud::default(),
            wall_rad: params.get(WALL_DEG).to_radians(),
            leak: params.get(LEAK),
            ring: Ring::default(),
            dust: Dust::default(),
            tangents: RefCell::default(),
            walls: Pieces::default(),
            islands: Pieces::default(),
            chains: Chains::new(params.get(NEIGHBOURS)),
        }
    }

    /// W and D of the returns of one sweep, with edges over the ways on that leak so much.
    fn walls_of_sweep(
        &mut self,
        sweep: &Sweep,
        points_m: &[Point],
        leak: f64,
        out: &mut Affinity,
        notes: &mut Notes,
    ) -> Result<(), StageError> {
        let Self { limits, ring, dust, tangents, walls, islands, .. } = self;
        ring.fill(sweep, points_m)?;
        let dust = dust.find(ring, limits);

        // A step of 0 gives an infinite number: then no piece is a wall.
        let least_returns = ((self.wall_rad / ring.step_rad).round() as usize).max(joining::LEAST_RETURNS);
        let inside_m = limits.passage_m / 2.0;
        let kept = (0..ring.len()).filter(|&i| !dust[i] && ring.range_m(i) > inside_m);
        walls.fill(ring, kept, limits.passage_m);
        let hanging = dust.iter().filter(|dust| **dust).count();
        let inside = ring.len() - hanging - walls.returns().len();
        ring.roughness = Roughness::of(ring, walls);
        islands::take(ring, walls, limits, islands);
        let judge = Judge::new(ring, tangents, walls, *limits);
        let mut left_over = joining::join(ring, &judge, walls, least_returns);
        if joining::cut_at_ways(&judge, walls) {
            left_over.extend(joining::join(ring, &judge, walls, least_returns));
        }

        if hanging > 0 {
            notes.add(format!(
                "passage: {} in the air (dust, edges of pillars), tied to none",
                counted(hanging as u64, "return")
            ));
        }
        if inside > 0 {
            let inside = counted(inside as u64, "return");
            notes.add(format!(
                "passage: {inside} within the vehicle, nearer than {inside_m} m (half of vehicle.width_m), tied to none"
            ));
        }
        self.chains.write(ring, &judge, (walls, islands), &left_over, leak, out);
        Ok(())
    }

    /// W and D of a cloud, by way of the sweep that a level vehicle sees.
    fn walls_of_cloud(&mut self, cloud: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        let mut buffers = std::mem::take(&mut self.cloud);
        let Cloud { view, seen, carrying } = &mut buffers;
        view.look(cloud, self.height_m, self.limits.passage_m);
        if let Some(sweep) = cloud.beams() {
            notes.add(format!("passage: {} beams are many, worked on as {}", sweep.len(), view.beams()));
        }
        let aside = cloud.len() - view.level().len();
        if aside > 0 {
            let aside = counted(aside as u64, "return");
            notes.add(format!("passage: {aside} above or below the vehicle, or within it, tied to none"));
        }
        let sweep = view.seen().sweep.as_ref().expect("a view has beams");
        // Carried on to what is not seen, a leak would be many.
        let done = self.walls_of_sweep(sweep, &view.seen().points_m, 0.0, seen, notes);
        if done.is_ok() {
            seen.sum_degrees(); // by which a return that has an edge is known
            out.verdicts.extend(
                seen.verdicts.iter().map(|verdict| Verdict {
                    returns: verdict.returns.map(|i| view.numbers()[i as usize]),
                    ..*verdict
                }),
            );
            carrying.write(cloud, view, seen, self.limits.passage_m, out);
        }
        self.cloud = buffers;
        done
    }
}

impl AffinityStage for Passage {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        match revolution.as_sweep() {
            Some(sweep) => self.walls_of_sweep(sweep, &revolution.points_m, self.leak, out, notes),
            None => self.walls_of_cloud(revolution, out, notes),
        }
    }
}
