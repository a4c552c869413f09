//! The name of the place.

use std::f64::consts::PI;

use crosscut_stage::{Opening, Place, wrap_angle_rad};

/// Two openings at least this far apart make a corridor, nearer ones a bend.
const CORRIDOR_RAD: f64 = 0.75 * PI;

/// Names a place by its openings. If the view does not go all the way round, or nothing is known between two walls,
/// there could be more; and a place of which no wall is seen could be anything. Then it has no name.
pub(crate) fn name(sees_all: bool, walls: usize, openings: &[Opening]) -> Place {
    if !sees_all || walls == 0 {
        return Place::PartialView;
    }
    match openings {
        [] => Place::Closed,
        [_] => Place::DeadEnd,
        [a, b] if wrap_angle_rad(a.bearing_rad - b.bearing_rad).abs() >= CORRIDOR_RAD => Place::Corridor,
        [_, _] => Place::Bend,
        [_, _, _] => Place::Tee,
        [_, _, _, _] => Place::Cross,
        more => Place::Junction(more.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Evidence, Point};

    fn named(sees_all: bool, walls: usize, bearings_deg: &[f64]) -> String {
        let opening = |deg: &f64| Opening {
            bearing_rad: deg.to_radians(),
            width_m: 3.0,
            walls: [0, 0],
            returns: [Some(0), Some(1)],
            gaps: Vec::new(),
            evidence: Evidence::NoReturn,
            known: crosscut_stage::Known::Judged,
            edge_m: [Point::origin(); 2],
            p: None,
        };
        name(sees_all, walls, &bearings_deg.iter().map(opening).collect::<Vec<_>>()).to_string()
    }

    #[test]
    fn each_number_of_openings_has_its_name() {
        let bearings = [0.0, 72.0, 144.0, -144.0, -72.0];
        let names: Vec<_> = (0..=5).map(|ways| named(true, ways.max(1), &bearings[..ways])).collect();
        assert_eq!(names, ["closed", "dead_end", "bend", "tee", "cross", "junction_5"]);
    }

    #[test]
    fn two_openings_across_pi_are_a_corridor_only_when_opposite() {
        assert_eq!(named(true, 2, &[0.0, 179.0]), "corridor");
        assert_eq!(named(true, 2, &[90.0, -90.0]), "corridor");
        assert_eq!(named(true, 2, &[170.0, -170.0]), "bend");
    }

    #[test]
    fn a_limited_view_has_no_name_nor_has_a_place_without_walls() {
        assert_eq!(named(false, 1, &[0.0]), "partial_view");
        assert_eq!(named(true, 0, &[]), "partial_view", "nothing closes it");
    }
}
