//! Tables as text for a terminal and as HTML, and fields of CSV.

use std::borrow::Cow;

use comfy_table::{CellAlignment, presets};
use crosscut_evaluate::tables::Table;

/// Formats tables for a terminal.
pub(crate) fn text(tables: &[Table]) -> String {
    let text = |table: &Table| {
        if table.rows.is_empty() {
            format!("{}: none\n\n", table.title)
        } else {
            format!("{}\n{}\n\n", table.title, layout(table))
        }
    };
    tables.iter().map(text).collect()
}

/// Formats a table without its title for a terminal.
pub(crate) fn plain(table: &Table) -> String {
    layout(table).trim_fmt()
}

/// Formats a table without its title as HTML.
pub(crate) fn html(table: &Table) -> String {
    let row = |cells: &[String], tag: &str| -> String {
        let cells = cells.iter().enumerate().map(|(place, cell)| {
            let class = if is_number(table, place) { " class=\"number\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escaped(cell))
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = table.rows.iter().map(|cells| row(cells, "td")).collect();
    format!("<table>\n<thead>{}</thead>\n<tbody>\n{rows}</tbody>\n</table>\n", row(&table.header, "th").trim_end())
}

/// Text as it stands in HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A text as a field of CSV (RFC 4180).
pub(crate) fn csv_field(text: &str) -> Cow<'_, str> {
    if text.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\"")).into()
    } else {
        text.into()
    }
}

/// Aligns names left and numbers right.
fn layout(table: &Table) -> comfy_table::Table {
    let mut drawn = comfy_table::Table::new();
    drawn.load_preset(presets::NOTHING).set_header(&table.header).add_rows(&table.rows);
    for (place, column) in drawn.column_iter_mut().enumerate() {
        column.set_cell_alignment(if is_number(table, place) { CellAlignment::Right } else { CellAlignment::Left });
    }
    drawn
}

/// Whether a column has numbers: every cell begins with one, but for those that have no value.
fn is_number(table: &Table, place: usize) -> bool {
    let mut cells = table
        .rows
        .iter()
        .filter_map(|cells| cells.get(place))
        .filter(|cell| !["", "-", "?"].contains(&cell.as_str()))
        .peekable();
    let begins_with_digit =
        |cell: &String| cell.trim_start_matches(['*', '+', '-', '[', '(']).starts_with(|c: char| c.is_ascii_digit());
    cells.peek().is_some() && cells.all(begins_with_digit)
}
