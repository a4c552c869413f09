//! How a comparison is shown: on a terminal, as Markdown, as JSON.

use comfy_table::{CellAlignment, TableStyle, presets};
use crosscut_evaluate::Comparison;
use crosscut_evaluate::tables::Table;
use serde_json::json;

/// For a terminal.
pub(crate) fn text(tables: &[Table]) -> String {
    tables.iter().map(|table| format!("{}\n{}\n\n", table.title, drawn(table, presets::NOTHING))).collect()
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

/// Every figure, by family and configuration, with each configuration in full and what went wrong.
pub(crate) fn json(comparison: &Comparison, configurations: &[(&str, String)], said: &[String]) -> String {
    let figures = |evaluations: &[crosscut_evaluate::Evaluation]| -> Vec<_> {
        let named = configurations.iter().zip(evaluations);
        named.map(|((name, _), of)| json!({"configuration": name, "figures": of.figures()})).collect()
    };
    let families = comparison.families().iter();
    let document = json!({
        "configurations": configurations.iter().map(|(name, toml)| json!({"name": name, "toml": toml})).collect::<Vec<_>>(),
        "families": families.map(|f| json!({"family": f.name, "results": figures(&f.evaluations)})).collect::<Vec<_>>(),
        "all": figures(&comparison.all()),
        "problems": said,
    });
    format!("{document:#}\n")
}

/// Names to the left, numbers to the right.
fn drawn(table: &Table, style: TableStyle) -> comfy_table::Table {
    let mut drawn = comfy_table::Table::new();
    drawn.load_style(style).set_header(&table.header).add_rows(&table.rows);
    for (place, column) in drawn.column_iter_mut().enumerate() {
        let is_name = matches!(table.header[place].as_str(), "family" | "configuration");
        column.set_cell_alignment(if is_name { CellAlignment::Left } else { CellAlignment::Right });
    }
    drawn
}
