//! What the programs that make `docs/` share.

mod contradictions;
pub mod solid;

pub use contradictions::{Contradiction, contradictions};
use crosscut_evaluate::tables::Table;

/// A table as Markdown, without its title.
pub fn markdown(table: &Table) -> String {
    let row = |cells: &Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rows: String = table.rows.iter().map(row).collect();
    format!("{}|{}\n{rows}", row(&table.header), "---|".repeat(table.header.len()))
}
