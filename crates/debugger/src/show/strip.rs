//! Strips: the turn around the sensor, and the columns of U, in one line each.

use std::f64::consts::{PI, TAU};

use crosscut_stage::Frame;

use super::{degrees, sign};

/// Characters of a strip: five degrees each.
const WIDTH: usize = 72;
/// Most columns of U.
const MOST_COLUMNS: usize = 12;

/// The strip of the walls, with its axis.
pub(super) fn of_walls(frame: &Frame) -> Vec<String> {
    // The smallest wall in each direction, so that none is hidden; left is +180°, the middle is ahead.
    let returns_of = |wall: u32| frame.junction.walls.get(wall as usize).map_or(usize::MAX, |wall| wall.returns);
    let mut seen = vec![(usize::MAX, ' '); WIDTH];
    for (i, wall) in frame.junction.wall_of_return.iter().enumerate() {
        let drawn = wall.map_or((usize::MAX - 1, '.'), |wall| (returns_of(wall), sign(wall)));
        let place = place(frame.revolution.bearing_rad(i));
        seen[place] = seen[place].min(drawn);
    }
    let strip: String = seen.into_iter().map(|(_, drawn)| drawn).collect();
    let half = WIDTH / 2 - 1;
    vec![format!("[{strip}]"), format!("{:<half$}{:<half$}{}", " 180°", "  0°", "-180°")]
}

/// The strip of the walls and a line for each.
pub(super) fn walls(frame: &Frame) -> String {
    let mut lines = of_walls(frame);
    for wall in &frame.junction.walls {
        let [from, to] = wall.bearing_rad.map(degrees);
        let island = if wall.island { ", an island" } else { "" };
        lines.push(format!("{}: {} returns, {from} to {to}{island}", sign(wall.id), wall.returns));
    }
    lines.join("\n")
}

/// A line for each column of U: its entries in beam order, by their share of the largest.
pub(super) fn columns(frame: &Frame) -> String {
    const SHADES: [char; 5] = [' ', '.', '-', '+', '#'];
    let u = &frame.spectrum.u;
    let n = u.nrows();
    let width = n.clamp(1, WIDTH);
    let line = |j: usize| {
        let largest = (0..n).map(|i| u[(i, j)].abs()).fold(0.0, f64::max);
        let cell = |at: usize| {
            let rows = at * n / width..((at + 1) * n / width).max(at * n / width + 1).min(n);
            let share = rows.map(|i| u[(i, j)].abs()).fold(0.0, f64::max) / largest.max(f64::MIN_POSITIVE);
            SHADES[(share * 4.0).round() as usize]
        };
        format!("u{:<3}[{}]", j + 1, (0..width).map(cell).collect::<String>())
    };
    let mut lines: Vec<String> = (0..u.ncols().min(MOST_COLUMNS)).map(line).collect();
    if u.ncols() > MOST_COLUMNS {
        lines.push(format!("and {} more columns", u.ncols() - MOST_COLUMNS));
    }
    lines.push(format!(
        "|U|, {n}x{} in beam order: the largest of each cell, ' ' 0 to '#' the column's largest",
        u.ncols()
    ));
    lines.join("\n")
}

/// The place of a bearing in a strip.
fn place(bearing_rad: f64) -> usize {
    (((PI - bearing_rad) / TAU * WIDTH as f64) as usize).min(WIDTH - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_of_the_strip_is_left_of_the_vehicle() {
        assert_eq!(place(PI), 0);
        assert_eq!(place(PI / 2.0), WIDTH / 4);
        assert_eq!(place(0.0), WIDTH / 2);
        assert_eq!(place(-PI), WIDTH - 1);
    }
}
