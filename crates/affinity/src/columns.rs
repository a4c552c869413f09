//! A search for near points by columns, since a mine is flat.

use crosscut_stage::Point;
use nalgebra::distance_squared;

/// Columns are wider than the reach by this share of it, for the rounding of coordinates of up to a million reaches.
const MARGIN: f64 = 1e-9;

/// Points sorted into upright columns of square section, so that all points within the side of a column are in the
/// column of the point or in those around it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    side_m: f64,
    /// Column and number of each point, by column: x first, so that three neighbouring columns along y are one stretch.
    sorted: Vec<([i64; 2], u32)>,
}

impl Columns {
    /// Takes points, to be asked for distances up to `reach_m` > 0. Finite coordinates.
    pub(crate) fn fill(&mut self, points_m: &[Point], reach_m: f64) {
        let side_m = reach_m * (1.0 + MARGIN);
        self.side_m = side_m;
        self.sorted.clear();
        self.sorted.extend((0..).zip(points_m).map(|(number, point)| (column(point, side_m), number)));
        self.sorted.sort_unstable();
    }

    /// Writes the numbers of all points no farther from `point` than `reach_m`, ascending, into `out`. `points_m` are
    /// those that were taken, and `reach_m` is at most that for which they were.
    pub(crate) fn near(&self, points_m: &[Point], point: &Point, reach_m: f64, out: &mut Vec<u32>) {
        debug_assert!(reach_m <= self.side_m, "{reach_m} m is beyond the columns around, {} m", self.side_m);
        out.clear();
        let [x, y] = column(point, self.side_m);
        for x in x.saturating_sub(1)..=x.saturating_add(1) {
            let start = self.sorted.partition_point(|(column, _)| *column < [x, y.saturating_sub(1)]);
            let stretch = self.sorted[start..].iter().take_while(|(column, _)| *column <= [x, y.saturating_add(1)]);
            let is_near = |number: &u32| distance_squared(point, &points_m[*number as usize]) <= reach_m * reach_m;
            out.extend(stretch.map(|&(_, number)| number).filter(is_near));
        }
        out.sort_unstable();
    }
}

/// The column of a point. Far off, where a double cannot tell one column from the next, all points share the last one.
fn column(point: &Point, side_m: f64) -> [i64; 2] {
    [point.x, point.y].map(|coordinate_m| (coordinate_m / side_m).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::{prop_assert_eq, proptest};

    proptest! {
        #[test]
        fn none_that_is_near_is_missed_and_none_that_is_not_is_found(
            coordinates in vec([-5.0..5.0f64, -5.0..5.0f64, -1.0..1.0f64], 0..60),
            reach_m in 0.01..8.0f64,
            share in 0.1..=1.0f64,
        ) {
            let points_m: Vec<Point> = coordinates.into_iter().map(Point::from).collect();
            let mut columns = Columns::default();
            columns.fill(&points_m, reach_m);
            let (mut found, asked_m) = (Vec::new(), share * reach_m);
            for point in &points_m {
                columns.near(&points_m, point, asked_m, &mut found);
                let is_near = |i: &u32| distance_squared(point, &points_m[*i as usize]) <= asked_m * asked_m;
                let expected: Vec<u32> = (0..points_m.len() as u32).filter(is_near).collect();
                prop_assert_eq!(&found, &expected);
            }
        }
    }

    #[test]
    fn points_beyond_all_columns_are_found_by_themselves() {
        let points_m = [Point::new(1e300, 0.0, 0.0), Point::new(-1e300, 0.0, 0.0)];
        let (mut columns, mut found) = (Columns::default(), Vec::new());
        columns.fill(&points_m, 1.0);
        columns.near(&points_m, &points_m[0], 1.0, &mut found);
        assert_eq!(found, [0]);
    }
}
