//! The exact best one-to-one matching of a table of weights.

/// Returns the pairs (row, column) with the largest sum of weights, in ascending rows; each row and each column is in at
/// most one pair. Weights are finite and not negative. There are as many pairs as the shorter side has entries, including
/// pairs of weight 0.
///
/// Hungarian method by shortest augmenting paths: O(a²·b) for sides a <= b. Sums of whole numbers are exact.
pub(crate) fn best_matching(rows: usize, columns: usize, weight: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    let mut pairs = if rows <= columns {
        match_short_side(rows, columns, |row, column| -weight(row, column))
    } else {
        let turned = match_short_side(columns, rows, |column, row| -weight(row, column));
        turned.into_iter().map(|(column, row)| (row, column)).collect()
    };
    pairs.sort_unstable();
    pairs
}

/// Returns the cheapest matching that gives each of `a` rows one of `b` >= a columns.
///
/// Row and column 0 are not in the table: the search for the column of a row starts from column 0. The potentials `u`, `v`
/// keep every reduced cost c(i, j) - u_i - v_j at 0 or above, and at 0 on the pairs of the matching.
fn match_short_side(a: usize, b: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<(usize, usize)> {
    let (mut u, mut v) = (vec![0.0; a + 1], vec![0.0; b + 1]);
    let mut row_of = vec![0; b + 1];
    for row in 1..=a {
        row_of[0] = row;
        let mut distance = vec![f64::INFINITY; b + 1];
        let mut came_from = vec![0; b + 1];
        let mut reached = vec![false; b + 1];
        let mut at = 0;
        // Dijkstra over reduced costs, to the nearest free column.
        while row_of[at] != 0 {
            reached[at] = true;
            let (i, mut nearest, mut step) = (row_of[at], 0, f64::INFINITY);
            for j in (1..=b).filter(|&j| !reached[j]) {
                let reduced = cost(i - 1, j - 1) - u[i] - v[j];
                if reduced < distance[j] {
                    (distance[j], came_from[j]) = (reduced, at);
                }
                if distance[j] < step {
                    (step, nearest) = (distance[j], j);
                }
            }
            for j in 0..=b {
                if reached[j] {
                    u[row_of[j]] += step;
                    v[j] -= step;
                } else {
                    distance[j] -= step;
                }
            }
            at = nearest;
        }
        while at != 0 {
            row_of[at] = row_of[came_from[at]];
            at = came_from[at];
        }
    }
    (1..=b).filter(|&j| row_of[j] != 0).map(|j| (row_of[j] - 1, j - 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{Strategy, prop, prop_assert, prop_assert_eq, proptest};

    /// The best sum over all ways to give each row from `row` on a free column or none.
    fn best_sum(table: &[Vec<f64>], row: usize, taken: &mut [bool]) -> f64 {
        if row == table.len() {
            return 0.0;
        }
        let mut best = best_sum(table, row + 1, taken);
        for column in 0..taken.len() {
            if !taken[column] {
                taken[column] = true;
                best = best.max(table[row][column] + best_sum(table, row + 1, taken));
                taken[column] = false;
            }
        }
        best
    }

    #[test]
    fn the_matching_is_not_greedy() {
        // Greedy takes 10, then 0; the best is 9 + 8.
        let table = [[10.0, 9.0], [8.0, 0.0]];
        assert_eq!(best_matching(2, 2, |i, j| table[i][j]), [(0, 1), (1, 0)]);
    }

    #[test]
    fn an_empty_side_has_no_pairs() {
        assert!(best_matching(0, 3, |_, _| 1.0).is_empty());
        assert!(best_matching(3, 0, |_, _| 1.0).is_empty());
    }

    proptest! {
        #[test]
        fn no_other_matching_has_a_larger_sum(
            table in (0usize..6, 0usize..6).prop_flat_map(|(rows, columns)| {
                prop::collection::vec(prop::collection::vec((0u8..12).prop_map(f64::from), columns), rows)
            })
        ) {
            let columns = table.first().map_or(0, Vec::len);
            let pairs = best_matching(table.len(), columns, |i, j| table[i][j]);
            prop_assert_eq!(pairs.len(), table.len().min(columns));
            prop_assert!(pairs.windows(2).all(|p| p[0].0 < p[1].0), "a row twice");
            let mut used: Vec<_> = pairs.iter().map(|p| p.1).collect();
            used.sort_unstable();
            prop_assert!(used.windows(2).all(|p| p[0] < p[1]), "a column twice");
            let sum: f64 = pairs.iter().map(|&(i, j)| table[i][j]).sum();
            prop_assert_eq!(sum, best_sum(&table, 0, &mut vec![false; columns]));
        }
    }
}
