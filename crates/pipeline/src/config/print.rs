//! The configuration as TOML that reads back, with unit, range and layer as comments.

use std::fmt;

use super::resolve::Config;

impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, section) in self.sections.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            writeln!(f, "[{}]", section.name)?;
            if let Some(kind) = &section.kind {
                writeln!(f, "# {}", kind.doc)?;
                writeln!(f, "kind = {:?}  # {}", kind.name, kind.layer)?;
            }
            for ((spec, (name, value)), layer) in section.specs.iter().zip(section.params.iter()).zip(&section.layers) {
                let unit = if spec.unit.is_empty() { String::new() } else { format!(" [{}]", spec.unit) };
                writeln!(f, "# {}{unit}: {}", spec.doc, spec.expected())?;
                writeln!(f, "{name} = {value}  # {layer}")?;
            }
        }
        Ok(())
    }
}
