//! The configuration as TOML that reads back, with unit, range and layer as comments.

use std::fmt;

use crosscut_stage::value_text;

use super::resolve::{Config, SetBy};

impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, section) in self.sections.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            writeln!(f, "[{}]", section.name)?;
            if let Some((kind, set_by)) = &section.kind {
                writeln!(f, "# {}", kind.doc)?;
                writeln!(f, "kind = {:?}  # {set_by}", kind.name)?;
            }
            for (spec, value, set_by) in section.own() {
                let unit = if spec.unit.is_empty() { String::new() } else { format!(" [{}]", spec.unit) };
                writeln!(f, "# {}{unit}: {}", spec.doc, spec.expected())?;
                // What follows another parameter does so in the file as well, until it is set there.
                let comment = if matches!(set_by, SetBy::Parameter(_)) { "# " } else { "" };
                writeln!(f, "{comment}{} = {}  # {set_by}", spec.name, value_text(value))?;
            }
        }
        Ok(())
    }
}
