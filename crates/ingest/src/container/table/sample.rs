//! The first lines of a table, from which it is known what its columns hold.

use std::io::{self, BufReader, Seek as _};

use super::columns::{bearings_rad, count_up, numbers};
use super::dialect::Dialect;
use crate::container::lines::{Line, next_line};
use crate::container::resting_file::RestingFile;

/// This many rows show what the columns hold; less, if they take more than that.
const SAMPLED_ROWS: usize = 64;
const SAMPLED_BYTES: usize = 16 << 20;

/// The first lines of a table.
#[derive(Default)]
pub(super) struct Sample {
    /// The last line before the first row that may have the names.
    pub(super) header: Option<String>,
    pub(super) rows: Vec<String>,
    pub(super) first_row: u64,
}

impl Sample {
    pub(super) fn of(file: &mut RestingFile) -> io::Result<Self> {
        let mut input = BufReader::new(&mut *file);
        let (mut lines, mut comment, mut number, mut bytes) = (Vec::<Line>::new(), None, 0, 0);
        while lines.len() <= SAMPLED_ROWS && bytes < SAMPLED_BYTES {
            let Some(line) = next_line(&mut input, &mut number)? else { break };
            bytes += line.text.len();
            match is_comment(&line.text) {
                _ if line.text.trim().is_empty() => {}
                true if lines.is_empty() => comment = Some(line.text),
                true => {}
                false => lines.push(line),
            }
        }
        file.rewind()?;
        Ok(Self::of_lines(comment, lines))
    }

    /// Names are on the first line, or in a comment before it.
    pub(super) fn of_lines(comment: Option<String>, mut lines: Vec<Line>) -> Self {
        let next = lines.get(1).map(|line| line.text.as_str());
        let has_names = lines.first().is_some_and(|line| is_header(&line.text, next));
        let header = if has_names { Some(lines.remove(0).text) } else { comment };
        let first_row = lines.first().map_or(u64::MAX, |line| line.number);
        Self { header, first_row, rows: lines.into_iter().map(|line| line.text).collect() }
    }
}

/// Whether a first line has the names of columns: words where the line after it has numbers, or numbers that count up or
/// are evenly spaced, as no ranges are.
fn is_header(line: &str, next: Option<&str>) -> bool {
    let dialect = Dialect::of(line);
    let cells = dialect.cells(line);
    let is_word =
        |cell: &&str| dialect.number(cell).is_none() && cell.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let has_names = match next {
        Some(next) => {
            let dialect = Dialect::of(next);
            let are_numbers = dialect.cells(next).into_iter().map(|cell| dialect.number(cell).is_some());
            cells.iter().zip(are_numbers).any(|(cell, is_number)| is_word(cell) && is_number)
        }
        None => 2 * cells.iter().filter(|cell| is_word(cell)).count() > cells.len(),
    };
    // Of a writer that gives every row a number, the first name is empty.
    let rest = if cells.first().is_some_and(|cell| cell.is_empty()) { &cells[1..] } else { &cells[..] };
    has_names || count_up(rest) || bearings_rad(&numbers(dialect, rest)).is_some()
}

pub(super) fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%'])
}
