//! `clear_width`: a wall ends where one number says so, a baseline.
//!
//! The returns, without what hangs in the air or stands free ([`Scan`]), are cut where two neighbours are the width of the
//! vehicle or more apart. Of the two ends at a gap, let p be the one that is nearer to the sensor, and F the line of the wall beside the
//! other one, over the metre behind it. The wall ends there if
//!
//! ```text
//! d(p, F) >= width of the vehicle
//! ```
//!
//! and goes on if not. Nothing is asked of turns, depths, sizes or lost beams: this is what other rules have to beat.
//! W_ij = 1 between neighbouring returns of one wall, else 0.

use crosscut_scan::{ISLAND_M, Lengths, Ring, Scan, VEHICLE_WIDTH_M};
use crosscut_stage::{Affinity, AffinityStage, Invariance, Kind, Measured, Notes, Revolution, StageError, Verdict};

use crate::edges::Neighbours;

/// The line of a wall is that of as much of it beside the gap.
const LINE_M: f64 = 1.0;
/// One number at a gap.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "clear_width",
    "a 0/1 graph: a wall ends where the nearer end of a gap is a vehicle's width off the line of the other wall (baseline)",
    |params| Box::new(ClearWidth { passage_m: params.get(VEHICLE_WIDTH_M),
            island_m: params.get(ISLAND_M),
            scan: Scan::default(),
            neighbours: Neighbours::default(),
        }),
)
.params(&[VEHICLE_WIDTH_M.shared("vehicle.width_m"), ISLAND_M.shared("report.island_m")])
.needs_beams()
// It sees ranges, distances and the order of the beams.
.blind_to(&[Invariance::Turn, Invariance::Mirror]);

struct ClearWidth {
    passage_m: f64,
    island_m: f64,
    scan: Scan,
    neighbours: Neighbours,
}

impl AffinityStage for ClearWidth {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let Some(sweep) = revolution.beams() else { return Err(StageError::without_beams("clear_width")) };
        let Self { passage_m, island_m, scan, neighbours } = self;
        let lengths = Lengths { passage_m: *passage_m, island_m: *island_m, stretch_m: LINE_M };
        scan.make(sweep, &revolution.points_m, &lengths)?;
        let ring = &scan.ring;
        neighbours.reset(ring.len());
        let mut connect = |i: usize, j: usize| neighbours.connect(ring.returns[i].number, ring.returns[j].number);
        scan.islands.pieces.iter().flat_map(|piece| piece.windows(2)).for_each(|pair| connect(pair[0], pair[1]));

        let kept = scan.pieces.returns();
        let gaps = if ring.full_turn { kept.len() } else { kept.len().saturating_sub(1) };
        for at in 0..gaps {
            let ends = [kept[at], kept[(at + 1) % kept.len()]];
            if !ring.are_apart(ends[0], ends[1], *passage_m) {
                if ends[0] != ends[1] {
                    connect(ends[0], ends[1]);
                }
                continue;
            }
            let width_m = clear_width_m(ring, kept, at);
            let is_opening = width_m >= *passage_m;
            if !is_opening {
                connect(ends[0], ends[1]);
            }
            out.verdicts.push(Verdict {
                returns: ends.map(|i| ring.returns[i].number),
                is_opening,
                room_ratio: width_m / *passage_m,
                p: None,
                reason: "clear width",
                measured: Some(Measured::metres(
                    "the one end is off the line of the wall at the other one by",
                    width_m,
                    "the vehicle needs",
                    *passage_m,
                )),
            });
        }
        neighbours.write(out);
        Ok(())
    }
}

/// The distance of the nearer end of the gap behind return number `at` from the line of the metre of wall beside its other
/// end.
fn clear_width_m(ring: &Ring, kept: &[usize], at: usize) -> f64 {
    let n = kept.len();
    let next = (at + 1) % n;
    let [p_m, q_m] = [at, next].map(|at| ring.position_m(kept[at]));
    let is_first_nearer = p_m.norm_squared() <= q_m.norm_squared();
    let end_m = if is_first_nearer { q_m } else { p_m };
    let onward = |step: usize| if is_first_nearer { (next + step) % n } else { (at + n - step) % n };
    let mut ahead_m = (1..n).map(|step| ring.position_m(kept[onward(step)]) - end_m);
    let line = ahead_m.find(|ahead| ahead.norm() >= LINE_M).unwrap_or(q_m - p_m);
    line.perp(&(q_m - p_m)).abs() / line.norm().max(f64::MIN_POSITIVE)
}
