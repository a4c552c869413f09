//! How far two walls leave each other's line at the gap between them.

use crate::ring::Position;

/// How far the walls beside a gap leave each other's line, metres. The nearer wall is the one whose end is nearer to the
/// sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The distance of the nearer end from the line of the farther wall. It is small at a bump, and at a corner of
    /// which only the returns are missing; at a branch it is the width of the branch.
    pub clear_m: f64,
    /// How far behind the line of the nearer wall the farther one begins; negative in front of it.
    pub depth_m: f64,
}

impl Clearance {
    /// Measures a gap. `chord` leads from its clockwise end to the other, metres. `directions` are the unit directions,
    /// anticlockwise around the sensor, in which the wall runs at the first end and on from the second.
    #[inline]
    pub fn at(chord: Position, directions: [Position; 2], first_is_nearer: bool) -> Self {
        // How far each end lies to the left of the line of the other piece; right is behind that piece, out of sight.
        let [second_left_m, first_left_m] = [directions[0].perp(&chord), directions[1].perp(&-chord)];
        let (clear_m, depth_m) =
            if first_is_nearer { (first_left_m.abs(), -second_left_m) } else { (second_left_m.abs(), -first_left_m) };
        Self { clear_m, depth_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{prop_assert, proptest};

    proptest! {
        #[test]
        fn a_wall_that_continues_in_its_line_leaves_none(turn_rad in -3.0..3.0f64, gap_m in 0.1..20.0f64) {
            let along = Position::new(turn_rad.cos(), turn_rad.sin());
            for first_is_nearer in [true, false] {
                let Clearance { clear_m, depth_m } = Clearance::at(along * gap_m, [along; 2], first_is_nearer);
                prop_assert!(clear_m < 1e-12 && depth_m.abs() < 1e-12, "{clear_m} {depth_m}");
            }
        }

        #[test]
        fn a_step_back_has_its_depth_and_a_branch_its_width(
            turn_rad in -3.0..3.0f64, gap_m in 0.1..20.0f64, back_m in 0.1..20.0f64,
        ) {
            let turned = nalgebra::Rotation2::new(turn_rad);
            // The wall runs on `gap_m` farther and `back_m` to the right, which is away from the sensor.
            let chord = turned * Position::new(gap_m, -back_m);
            let (along, across) = (turned * Position::x(), turned * Position::y());
            let step = Clearance::at(chord, [along; 2], true);
            prop_assert!((step.clear_m - back_m).abs() < 1e-9 && (step.depth_m - back_m).abs() < 1e-9, "{step:?}");
            // The farther wall is the far side of a branch that leaves to the right.
            let branch = Clearance::at(chord, [along, across], true);
            prop_assert!((branch.clear_m - gap_m).abs() < 1e-9 && (branch.depth_m - back_m).abs() < 1e-9, "{branch:?}");
        }
    }
}
