//! Lines with fewer points, as most of a wall is straight.

use nalgebra::Vector3;

/// The line without points that lie within `tolerance` of the rest (Douglas and Peucker). `line` must not be empty.
pub(crate) fn simplified(line: &[[f32; 3]], tolerance: f32) -> Vec<[f32; 3]> {
    let mut kept = vec![line[0]];
    let mut spans = vec![(0, line.len() - 1)];
    while let Some((from, to)) = spans.pop() {
        let distance = |i: usize| distance(line[i], line[from], line[to]);
        match (from + 1..to).max_by(|&a, &b| distance(a).total_cmp(&distance(b))) {
            Some(far) if distance(far) > tolerance => spans.extend([(far, to), (from, far)]),
            _ => kept.push(line[to]),
        }
    }
    kept
}

/// Distance of point `p` from the segment from `a` to `b`.
fn distance(p: [f32; 3], a: [f32; 3], b: [f32; 3]) -> f32 {
    let [p, a, b] = [p, a, b].map(Vector3::from);
    let along = ((p - a).dot(&(b - a)) / (b - a).norm_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (p - a - along * (b - a)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_its_corners_and_passes_all_points() {
        let line: Vec<[f32; 3]> =
            (0..=40).map(|i| i as f32 / 10.0).map(|s| [s.min(2.0), (s - 2.0).max(0.0), 0.0]).collect();
        assert_eq!(simplified(&line, 0.03), [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]]);
        assert_eq!(simplified(&line[..2], 0.03), line[..2]);
        assert_eq!(simplified(&line[..1], 0.03), [line[0]; 2], "a single point becomes a line of length 0");
        let closed = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
        assert_eq!(simplified(&closed, 0.03), closed);
    }
}
