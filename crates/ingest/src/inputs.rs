//! The files that the inputs of a run stand for.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::{Found, IngestError, Loss, LossKind, bag};

/// Endings of compressed files; rosbag2 has the first.
const COMPRESSED: [&str; 3] = ["zstd", "zst", "lz4"];

/// The parts of a flight.
#[derive(Debug, Default)]
pub struct Parts {
    /// Those that are there, in order. Compressed ones (.mcap.zstd) cannot be read, but are parts as well.
    pub files: Vec<PathBuf>,
    /// Those that are not there although the `metadata.yaml` of their folder names them.
    pub missing: Vec<Loss>,
}

/// The recordings in `inputs`, in the order given; a folder stands for the .mcap files in it, in the order in which its
/// `metadata.yaml` names them, others by name, `flight_2` before `flight_10`.
///
/// # Errors
/// When there are none, or a folder cannot be read or has none.
pub fn parts_in(inputs: &[PathBuf]) -> Result<Parts, IngestError> {
    let mut parts = Parts::default();
    for input in inputs {
        if input.is_dir() {
            add_folder(input, &mut parts)?;
        } else {
            parts.files.push(input.clone());
        }
    }
    if parts.files.is_empty() { Err(IngestError::NoInput) } else { Ok(parts) }
}

/// The files of [`parts_in`].
///
/// # Errors
/// The same.
pub fn recordings_in(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, IngestError> {
    Ok(parts_in(inputs)?.files)
}

fn add_folder(folder: &Path, parts: &mut Parts) -> Result<(), IngestError> {
    let failed = |source| IngestError::Open { path: folder.to_owned(), source };
    let (mut files, mut folders) = (Vec::new(), 0);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        folders += usize::from(path.is_dir());
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    let (mut recordings, others): (Vec<_>, Vec<_>) = files.into_iter().partition(|path| is_recording(path));
    if recordings.is_empty() {
        let found = others.iter().any(|path| has_extension(path, "db3")).then_some(Found::Sqlite);
        return Err(IngestError::NoRecordings { path: folder.to_owned(), files: others.len(), folders, found });
    }
    // Who decompressed a part may have kept both.
    let is_twin = |path: &PathBuf| decompressed(path) != *path && decompressed(path).is_file();
    recordings.retain(|path| !is_twin(path));
    let named = bag::parts_of(folder);
    let mut places = BTreeMap::new();
    for (place, path) in named.iter().enumerate() {
        places.entry(name_of(path)).or_insert(place);
    }
    recordings.sort_by_cached_key(|path| places.get(&name_of(path)).copied().unwrap_or(usize::MAX));
    let there: BTreeSet<_> = recordings.iter().map(|path| name_of(path)).collect();
    let missing = named.into_iter().filter(|path| is_recording(path) && !there.contains(&name_of(path)));
    parts.missing.extend(missing.map(|file| {
        let kind = LossKind::File { cause: "it is not there, though metadata.yaml names it".to_owned() };
        Loss { file, kind }
    }));
    parts.files.extend(recordings);
    Ok(())
}

fn is_recording(path: &Path) -> bool {
    has_extension(&decompressed(path), "mcap")
}

/// The name of a part before it was compressed: FLIGHT.mcap of FLIGHT.mcap.zstd.
fn decompressed(path: &Path) -> PathBuf {
    let is_compressed = COMPRESSED.iter().any(|ending| has_extension(path, ending));
    if is_compressed { path.with_extension("") } else { path.to_owned() }
}

/// What a part is called in its folder, compressed or not, on any file system.
fn name_of(path: &Path) -> String {
    decompressed(path).file_name().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

/// Runs of digits compare as numbers, all else character by character.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let (run_a, run_b) = (digits(rest_a), digits(rest_b));
        let order = if !run_a.is_empty() && !run_b.is_empty() {
            (rest_a, rest_b) = (&rest_a[run_a.len()..], &rest_b[run_b.len()..]);
            let (number_a, number_b) = (run_a.trim_start_matches('0'), run_b.trim_start_matches('0'));
            number_a.len().cmp(&number_b.len()).then_with(|| number_a.cmp(number_b))
        } else {
            let (mut chars_a, mut chars_b) = (rest_a.chars(), rest_b.chars());
            match (chars_a.next(), chars_b.next()) {
                (None, None) => return a.cmp(b), // equal but for leading zeros
                (char_a, char_b) => {
                    (rest_a, rest_b) = (chars_a.as_str(), chars_b.as_str());
                    char_a.cmp(&char_b)
                }
            }
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

/// The digits that `text` begins with.
fn digits(text: &str) -> &str {
    &text[..text.bytes().take_while(u8::is_ascii_digit).count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let mut names = ["f_10.mcap", "f_2.mcap", "f_02.mcap", "f_1.mcap", "f.mcap", "e_11.mcap", "f_2_b.mcap"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["e_11.mcap", "f.mcap", "f_1.mcap", "f_02.mcap", "f_2.mcap", "f_2_b.mcap", "f_10.mcap"]);
        assert_eq!(natural_order("f_99999999999999999999999", "f_100000000000000000000000"), Ordering::Less);
    }

    #[test]
    fn a_folder_without_recordings_is_told_with_what_it_has_instead() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let said = || recordings_in(&[folder.path().to_owned()]).expect_err("no recording").to_string();
        assert!(said().starts_with("the folder is empty: "), "{}", said());
        fs::create_dir(folder.path().join("bag")).expect("writable");
        assert!(said().contains("1 folder; name that of the flight"), "{}", said());
        fs::write(folder.path().join("bag_0.db3"), b"").expect("writable");
        assert!(said().contains("none of the 1 files") && said().contains("rosbag2 .db3"), "{}", said());
        fs::write(folder.path().join("bag_0.mcap.zstd"), b"").expect("writable");
        assert_eq!(recordings_in(&[folder.path().to_owned()]).expect("a part").len(), 1);
    }
}
