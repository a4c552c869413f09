//! The returns from above: each in the sign of its wall, the sensor in the middle, ahead is up.

use crosscut_stage::Frame;

use super::sign;

/// Size of the picture; a character is about twice as high as it is wide.
const COLUMNS: usize = 61;
const ROWS: usize = 25;
/// This share of the returns is within the picture.
const SHOWN_SHARE: f64 = 0.95;

pub(super) fn picture(frame: &Frame) -> String {
    let points = &frame.revolution.points_m;
    let mut reach: Vec<f64> = points.iter().map(|p| p.x.abs().max(p.y.abs())).collect();
    reach.sort_by(f64::total_cmp);
    let last = (SHOWN_SHARE * reach.len() as f64) as usize;
    let half_m = reach.get(last.min(reach.len().saturating_sub(1))).copied().unwrap_or(1.0).max(0.1);
    let (middle_column, middle_row) = ((COLUMNS / 2) as f64, (ROWS / 2) as f64);
    let mut rows = vec![vec![' '; COLUMNS]; ROWS];
    for (i, point) in points.iter().enumerate() {
        let column = (middle_column - point.y / half_m * middle_column).round();
        let row = (middle_row - point.x / half_m * middle_row).round();
        if (0.0..COLUMNS as f64).contains(&column) && (0.0..ROWS as f64).contains(&row) {
            let wall = frame.junction.wall_of_return.get(i).copied().flatten().filter(|_| frame.failure.is_none());
            rows[row as usize][column as usize] = wall.map_or('.', sign);
        }
    }
    rows[ROWS / 2][COLUMNS / 2] = '^';
    let lines: Vec<String> =
        rows.into_iter().map(|row| row.into_iter().collect::<String>().trim_end().to_owned()).collect();
    format!("{}\n{half_m:.1} m from the vehicle (^) to each side; digits are walls, . no wall", lines.join("\n"))
}
