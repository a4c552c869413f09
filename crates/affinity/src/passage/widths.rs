//! For which widths of the vehicle the count stays the same.
//!
//! The width changes where the ring is cut, what is of the vehicle, what is an island and how far walls are joined, so no
//! measurement at one gap bounds it. The whole scan is decided again at other widths, from that of the vehicle outward,
//! until the count is another one.

/// No vehicle is narrower.
const LEAST_M: f64 = 0.1;
/// No vehicle is wider: the most that `vehicle.width_m` may be.
const MOST_M: f64 = 100.0;
/// From one width to the next.
const STEP: f64 = 1.03;

/// The least and the largest width, metres, to which the count holds at every width that is tried; `holds_at` decides at
/// one.
pub(super) fn hold_m(width_m: f64, mut holds_at: impl FnMut(f64) -> bool) -> [f64; 2] {
    let mut last_m = |next_m: &dyn Fn(f64) -> f64| {
        let mut last_m = width_m;
        while next_m(last_m) != last_m && holds_at(next_m(last_m)) {
            last_m = next_m(last_m);
        }
        last_m
    };
    let narrower_m = |m: f64| (m / STEP).max(LEAST_M).min(m);
    let wider_m = |m: f64| (m * STEP).min(MOST_M).max(m);
    [last_m(&narrower_m), last_m(&wider_m)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_widths_at_which_the_count_holds() {
        let holds = |width_m: f64| (0.35..=2.0).contains(&width_m);
        let [least_m, most_m] = hold_m(0.6, holds);
        assert!((0.35..0.35 * STEP).contains(&least_m) && holds(most_m) && !holds(most_m * STEP));
        assert_eq!(hold_m(0.6, |_| true), [LEAST_M, MOST_M]);
        assert_eq!(hold_m(0.05, |_| false), [0.05, 0.05]);
    }
}
