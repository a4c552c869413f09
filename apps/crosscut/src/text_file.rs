//! Text files that a command reads beside recordings: settings, plans, and what a sweep has computed.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::iter;
use std::path::Path;

/// A file of more bytes is refused.
const MOST_BYTES: u64 = 64 << 20;

/// The whole text of a file.
///
/// # Errors
/// When it cannot be read, is not UTF-8, or is too large.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    if File::open(path)?.take(MOST_BYTES + 1).read_to_string(&mut text)? as u64 > MOST_BYTES {
        return Err(too_large());
    }
    Ok(text)
}

/// The lines of a file, each as long as a whole text may be at most.
pub(crate) fn lines(path: &Path) -> io::Result<impl Iterator<Item = io::Result<String>> + use<>> {
    let mut file = BufReader::new(File::open(path)?);
    Ok(iter::from_fn(move || {
        let mut line = String::new();
        match file.by_ref().take(MOST_BYTES + 1).read_line(&mut line) {
            Ok(0) => None,
            Ok(bytes) if bytes as u64 > MOST_BYTES => Some(Err(too_large())),
            Ok(_) => Some(Ok(line)),
            Err(error) => Some(Err(error)),
        }
    }))
}

fn too_large() -> io::Error {
    let cause = format!("larger than the {} MiB that a text file may have", MOST_BYTES >> 20);
    io::Error::new(io::ErrorKind::FileTooLarge, cause)
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
            let mut lines = lines(&path).expect("a file");
            assert_eq!(lines.next().expect("a line").is_ok(), is_read, "{bytes}");
        }
        let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/recordings.md"));
        let row = format!("\n| plan, file of settings, row of a sweep, line of a golden | {} MiB |", MOST_BYTES >> 20);
        assert!(page.expect("the documentation").contains(&row), "no row {row}");
    }
}
