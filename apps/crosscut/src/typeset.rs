//! Tables as text for a terminal and as Markdown.

use comfy_table::{CellAlignment, presets};
use crosscut_evaluate::tables::Table;

/// Formats tables for a terminal.
pub(crate) fn text(tables: &[Table]) -> String {
    let text = |table: &Table| {
        if table.rows.is_empty() {
            format!("{}: none\n\n", table.title)
        } else {
            format!("{}\n{}\n\n", table.title, layout(table, presets::NOTHING))
        }
    };
    tables.iter().map(text).collect()
}

/// Formats tables as Markdown.
pub(crate) fn markdown(tables: &[Table]) -> String {
    let escaped = |table: &Table| {
        let escape = |cells: &Vec<String>| cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        Table { header: escape(&table.header), rows: table.rows.iter().map(escape).collect(), ..table.clone() }
    };
    let markdown = |table| layout(&escaped(table), presets::ASCII_MARKDOWN);
    tables.iter().map(|table| format!("**{}**\n\n{}\n\n", table.title, markdown(table))).collect()
}

/// Aligns names left and numbers right.
fn layout(table: &Table, preset: &str) -> comfy_table::Table {
    let mut drawn = comfy_table::Table::new();
    drawn.load_preset(preset).set_header(&table.header).add_rows(&table.rows);
    for (place, column) in drawn.column_iter_mut().enumerate() {
        let is_name = matches!(table.header[place].as_str(), "family" | "configuration" | "setting" | "stage");
        column.set_cell_alignment(if is_name { CellAlignment::Left } else { CellAlignment::Right });
    }
    drawn
}
