//! How a comparison is shown: on a terminal, as Markdown, as JSON.

use comfy_table::{CellAlignment, TableStyle, presets};
use crosscut_evaluate::tables::Table;
use crosscut_evaluate::{Comparison, Evaluation};
use serde_json::json;

/// For a terminal.
pub(crate) fn text(tables: &[Table]) -> String {
    let text = |table: &Table| match table.rows.is_empty() {
        true => format!("{}: none\n\n", table.title),
        false => format!("{}\n{}\n\n", table.title, drawn(table, presets::NOTHING)),
    };
    tables.iter().map(text).collect()
}

/// For a Markdown document.
pub(crate) fn markdown(tables: &[Table]) -> String {
    let escaped = |table: &Table| {
        let escape = |cells: &Vec<String>| cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        Table { header: escape(&table.header), rows: table.rows.iter().map(escape).collect(), ..table.clone() }
    };
    let drawn = |table| drawn(&escaped(table), presets::ASCII_MARKDOWN);
    tables.iter().map(|table| format!("**{}**\n\n{}\n\n", table.title, drawn(table))).collect()
}

/// Every figure, by family and configuration, with the `settings` of each configuration in full and what went wrong.
pub(crate) fn json(comparison: &Comparison, settings: &[String], problems: &[String]) -> String {
    let names = comparison.configurations();
    let configurations: Vec<_> =
        names.iter().zip(settings).map(|(name, toml)| json!({"name": name, "settings": toml})).collect();
    let results = |evaluations: &[Evaluation]| -> Vec<_> {
        let named = names.iter().zip(evaluations);
        named.map(|(name, of)| json!({"configuration": name, "figures": of.figures()})).collect()
    };
    let families: Vec<_> = comparison
        .families()
        .iter()
        .map(|family| json!({"family": family.name, "results": results(&family.evaluations)}))
        .collect();
    let document = json!({
        "configurations": configurations,
        "families": families,
        "all": results(&comparison.all()),
        "problems": problems,
    });
    format!("{document:#}\n")
}

/// Names to the left, numbers to the right.
fn drawn(table: &Table, style: TableStyle) -> comfy_table::Table {
    let mut drawn = comfy_table::Table::new();
    drawn.load_style(style).set_header(&table.header).add_rows(&table.rows);
    for (place, column) in drawn.column_iter_mut().enumerate() {
        let is_name = matches!(table.header[place].as_str(), "family" | "configuration" | "setting" | "stage");
        column.set_cell_alignment(if is_name { CellAlignment::Left } else { CellAlignment::Right });
    }
    drawn
}
