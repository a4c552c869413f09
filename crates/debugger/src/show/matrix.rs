//! A matrix as shades of its powers of ten.

use faer::Mat;

/// Most rows and columns of the picture; a character is about twice as high as it is wide.
const ROWS: usize = 24;
const COLUMNS: usize = 48;
/// From 1e-16 and less to 1, two decades a shade.
const SHADES: [char; 9] = [' ', '.', ':', '-', '=', '+', '*', '#', '@'];

pub(super) fn picture(matrix: &Mat<f64>, name: &str) -> String {
    let n = matrix.nrows();
    if n == 0 {
        return format!("{name} is 0x0: there is no return");
    }
    let (rows, columns) = (n.min(ROWS), n.min(COLUMNS));
    let line = |row: usize| -> String {
        let span = |at: usize, of: usize| at * n / of..((at + 1) * n / of).max(at * n / of + 1);
        let largest = |column: usize| {
            let entries = span(row, rows).flat_map(|i| span(column, columns).map(move |j| (i, j)));
            entries.map(|(i, j)| matrix[(i, j)].abs()).fold(0.0, f64::max)
        };
        (0..columns).map(|column| shade(largest(column))).collect::<String>().trim_end().to_owned()
    };
    let lines: Vec<String> = (0..rows).map(line).collect();
    let legend = "the largest of each cell, from ' ' at 1e-16 or less by \". : - = + * #\" to '@' near 1";
    format!("{}\n|{name}|, {n}x{n} in beam order: {legend}", lines.join("\n"))
}

fn shade(value: f64) -> char {
    let decades = (value.log10() + 16.0).clamp(0.0, 16.0);
    SHADES[if decades > 0.0 { (decades / 2.0).round() as usize } else { 0 }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_follow_powers_of_ten() {
        assert_eq!([0.0, 1e-17, 1e-8, 1.0, 7.0].map(shade), [' ', ' ', '=', '@', '@']);
    }

    #[test]
    fn blocks_of_a_matrix_stay_blocks_however_large_it_is() {
        for n in [2, 40, 401] {
            let blocks = Mat::from_fn(n, n, |i, j| f64::from(u8::from((2 * i < n) == (2 * j < n))));
            let picture = picture(&blocks, "W");
            let first = picture.lines().next().expect("a line");
            assert!(first.starts_with('@') && first.len() <= n.min(COLUMNS) / 2 + 1, "{n}: {picture}");
        }
    }
}
