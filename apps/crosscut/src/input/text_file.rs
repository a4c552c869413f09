//! Text files that a command reads beside recordings: settings and plans.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use crosscut_simulator::{Plan, PlanError};

use crate::exit::UsageError;

/// A file of more bytes is refused.
const MOST_BYTES: u64 = 64 << 20;

/// The whole text of a file.
///
/// # Errors
/// When it cannot be read, is not UTF-8, or is too large.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    if File::open(path)?.take(MOST_BYTES + 1).read_to_string(&mut text)? as u64 > MOST_BYTES {
        let cause = format!("larger than the {} MiB that a text file may have", MOST_BYTES >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, cause));
    }
    Ok(text)
}

/// What is made of the plan of a mine in a file; messages name the file.
pub(crate) fn of_plan<T>(path: &Path, make: impl FnOnce(Plan) -> Result<T, PlanError>) -> Result<T, UsageError> {
    let in_plan = |error: &dyn Display| UsageError(format!("{}: {error}", path.display()));
    let text = read(path).map_err(|error| in_plan(&error))?;
    Plan::from_json(&text).and_then(make).map_err(|error| in_plan(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_beyond_the_limit_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("plan.json");
        for (bytes, is_read) in [(MOST_BYTES, true), (MOST_BYTES + 1, false)] {
            std::fs::write(&path, vec![b' '; bytes as usize]).expect("written");
            assert_eq!(read(&path).is_ok(), is_read, "{bytes}");
        }
        let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/recordings.md"));
        let row = format!("\n| plan, file of settings | {} MiB |", MOST_BYTES >> 20);
        assert!(page.expect("the documentation").contains(&row), "no row {row}");
    }
}
