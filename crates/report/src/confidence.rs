//! How sure an answer is.

use crosscut_stage::{Junction, Revolution};

/// Widths and angles count no further than this.
const WIDE_M: f64 = 3.0;
const BROAD_DEG: f64 = 20.0;
/// The logit at width 0 and angle 0 without islands, and what each adds: a fit to right and wrong answers of `default`
/// on the simulator's development scenes.
const BASE: f64 = -3.6;
const PER_M: f64 = 1.0;
const PER_DEG: f64 = 0.21;
const ISLANDS: f64 = -0.9;

/// 1 - 10^-margin: 0 on the tolerance, 0.9 one decade away, 0.99 two.
pub(crate) fn of_margin(margin_decades: Option<f64>) -> f64 {
    margin_decades.map_or(0.0, |margin| 1.0 - 10f64.powf(-margin.max(0.0)))
}

/// The share of right answers among those with as narrow an opening, as small a wall, and islands or none.
pub(crate) fn of_scene(revolution: &Revolution, answer: &Junction) -> f64 {
    let step_deg = revolution.sweep.as_ref().map_or(0.0, |sweep| sweep.step_rad).to_degrees();
    let walls = answer.walls.iter().filter(|wall| !wall.island).map(|wall| wall.returns);
    let Some(fewest) = walls.min() else { return 0.0 };
    let narrowest_m = answer.openings.iter().map(|opening| opening.width_m).fold(WIDE_M, f64::min);
    let islands = answer.walls.iter().any(|wall| wall.island);
    let smallest_deg = (fewest as f64 * step_deg).min(BROAD_DEG);
    let logit = BASE + PER_M * narrowest_m + PER_DEG * smallest_deg + if islands { ISLANDS } else { 0.0 };
    1.0 / (1.0 + (-logit).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Sweep, Wall};

    #[test]
    fn confidence_grows_with_the_margin_and_is_none_without_a_spectrum() {
        assert_eq!(of_margin(None), 0.0);
        assert_eq!(of_margin(Some(-1.0)), 0.0);
        assert!((of_margin(Some(2.0)) - 0.99).abs() < 1e-12);
    }

    #[test]
    fn a_broad_wall_is_surer_than_a_small_one_and_no_wall_is_not_sure_at_all() {
        let sweep = Sweep { step_rad: 1f64.to_radians(), ..Sweep::default() };
        let revolution = Revolution { sweep: Some(sweep), ..Revolution::default() };
        let of = |returns: &[usize], island| {
            let wall = |(id, returns): (usize, &usize)| Wall {
                id: id as u32,
                returns: *returns,
                bearing_rad: [0.0; 2],
                island,
            };
            of_scene(
                &revolution,
                &Junction { walls: returns.iter().enumerate().map(wall).collect(), ..Junction::default() },
            )
        };
        assert!(of(&[100, 100], false) > 0.9 && of(&[100, 3], false) < 0.9);
        assert_eq!((of(&[], false), of(&[50], true)), (0.0, 0.0), "nothing but islands");
    }
}
