//! What is written must not be what is read.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::exit::UsageError;

/// A new file that is none of the `inputs`, or standard output for `-`.
pub(crate) fn create(path: &Path, inputs: &[PathBuf]) -> anyhow::Result<Box<dyn Write>> {
    if path == Path::new("-") {
        return Ok(Box::new(std::io::stdout()));
    }
    refuse(&[path], inputs)?;
    Ok(Box::new(File::create(path).with_context(|| format!("cannot write {}", path.display()))?))
}

/// Refuses an output that is one of the inputs, or that another output is written to already.
pub(crate) fn refuse(outputs: &[&Path], inputs: &[PathBuf]) -> Result<(), UsageError> {
    for (i, output) in outputs.iter().enumerate() {
        let is_input = inputs.iter().any(|input| is_same_file(input, output));
        if is_input || outputs[..i].iter().any(|other| is_same_file(other, output)) {
            return Err(UsageError(format!("{} would be overwritten; write to another file", output.display())));
        }
    }
    Ok(())
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
