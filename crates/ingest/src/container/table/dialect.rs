//! How the cells of a table are separated, and how its numbers are written.

/// The words that stand for no number, in small letters.
const NO_NUMBER: [&str; 6] = ["", "na", "n/a", "none", "null", "-"];

/// Separator and decimal sign of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// `None` stands for any blanks.
    separator: Option<char>,
}

impl Dialect {
    /// By the first line. A comma may separate cells or be the decimal sign of cells between blanks.
    pub(crate) fn of(line: &str) -> Self {
        let separator = [';', '\t'].into_iter().find(|separator| line.trim().contains(*separator));
        let has_decimal_commas = || {
            let mut words = line.split_whitespace();
            words.clone().count() > 1
                && words.all(|word| parsed(&word.replace(',', ".")).is_some() && !word.ends_with(','))
        };
        Self { separator: separator.or_else(|| (line.contains(',') && !has_decimal_commas()).then_some(',')) }
    }

    /// Its separator in words.
    pub(crate) fn name(self) -> &'static str {
        match self.separator {
            None => "blanks",
            Some(',') => "`,`",
            Some(';') => "`;`",
            Some(_) => "tabs",
        }
    }

    /// The cells of a line, without quotes and blanks around them. A separator between quotes is part of its cell.
    pub(crate) fn cells(self, line: &str) -> Vec<&str> {
        let mut is_quoted = false;
        let is_end = |c: char| {
            is_quoted ^= c == '"';
            !is_quoted && self.separator.map_or_else(|| c.is_whitespace(), |separator| c == separator)
        };
        let cells = line.split(is_end).map(|cell| cell.trim().trim_matches('"').trim());
        cells.filter(|cell| self.separator.is_some() || !cell.is_empty()).collect()
    }

    /// The number in a cell; NaN where it says that there is none. Where commas do not separate cells, they may be
    /// decimal signs.
    pub(crate) fn number(self, cell: &str) -> Option<f64> {
        if self.separator == Some(',') || !cell.contains(',') { parsed(cell) } else { parsed(&cell.replace(',', ".")) }
    }
}

fn parsed(cell: &str) -> Option<f64> {
    let is_none = || NO_NUMBER.contains(&cell.to_ascii_lowercase().as_str());
    cell.parse().ok().or_else(|| is_none().then_some(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_and_decimal_commas_are_told_apart() {
        for (line, cells, second) in [
            ("1,2.5,3", 3, Some(2.5)),
            ("1, 2.5, 3", 3, Some(2.5)),
            ("1;2,5;3", 3, Some(2.5)),
            ("1,0\t2,5\t3,0", 3, Some(2.5)),
            ("1,0 2,5  3,0", 3, Some(2.5)),
            (" 1.0  2.5\t", 2, Some(2.5)),
            ("\"1\",\"2.5\",3", 3, Some(2.5)),
            ("a,\"[1, 2]\",3", 3, None),
            ("time r0 r1", 3, None),
        ] {
            let dialect = Dialect::of(line);
            let found = dialect.cells(line);
            assert_eq!((found.len(), dialect.number(found[1])), (cells, second), "{line}");
        }
        assert!(Dialect::of("1,2").number("").is_some_and(f64::is_nan), "an empty cell is no measurement");
    }
}
