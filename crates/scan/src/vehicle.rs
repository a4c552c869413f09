//! The size of the vehicle, and the returns of the vehicle itself.

use crosscut_stage::{Number, ParamSpec};

use crate::dust::touch;
use crate::ring::Ring;

/// The width of the vehicle.
pub const VEHICLE_WIDTH_M: Number =
    Number::new("width_m", "m", 0.6).above(0.0).to(100.0).doc("diameter of the disc that must fit through an opening");

/// The height of the vehicle.
pub const VEHICLE_HEIGHT_M: Number = Number::new("height_m", "m", 0.6)
    .above(0.0)
    .to(100.0)
    .doc("of a cloud, the returns no farther above or below the sensor than half of it are seen");

/// Section `vehicle` of the configuration.
pub const VEHICLE_PARAMS: &[ParamSpec] = &[VEHICLE_WIDTH_M.spec, VEHICLE_HEIGHT_M.spec];

/// Marks the returns that are of the vehicle: those no farther than `reach_m`, in stretches that step back to what is
/// behind them at one end at least. A stretch that continues as a wall at both ends is of that wall, which a vehicle that
/// is narrower has come near to.
pub(crate) fn find(ring: &Ring, reach_m: f64, of_vehicle: &mut Vec<bool>) {
    let n = ring.len();
    of_vehicle.clear();
    of_vehicle.extend((0..n).map(|i| ring.range_m(i) <= reach_m));
    // A stretch around the whole turn has no ends.
    let Some(beyond) = of_vehicle.iter().position(|is_near| !is_near) else { return };
    let mut steps = 1;
    while steps < n {
        let first = (beyond + steps) % n;
        let is_cut = |i: usize| i + 1 == n && !ring.full_turn;
        let mut returns = 0;
        while of_vehicle[(first + returns) % n] {
            returns += 1;
            if is_cut((first + returns - 1) % n) {
                break;
            }
        }
        if returns > 0 && goes_on(ring, first, (first + returns - 1) % n) {
            (0..returns).for_each(|k| of_vehicle[(first + k) % n] = false);
        }
        steps += returns.max(1);
    }
}

/// Whether a stretch of returns touches the next ones at both ends.
fn goes_on(ring: &Ring, first: usize, last: usize) -> bool {
    let touches = |end: usize, step: isize| ring.after(end, step).is_some_and(|next| touch(ring, end, next));
    touches(first, -1) && touches(last, 1)
}
