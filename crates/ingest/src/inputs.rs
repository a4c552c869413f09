//! The files that the inputs of a run stand for.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::{IngestError, Loss, LossKind, metadata};

/// Endings of recordings. Of a folder that has several kinds, the first kind counts: the others are copies.
const KINDS: [&str; 6] = ["mcap", "db3", "bag", "clf", "pcd", "ply"];

/// Endings of recordings that no folder stands for: they are those of the program itself.
const KINDS_TO_NAME: [&str; 1] = ["rrd"];

/// What may follow these: files that are compressed (rosbag2 has the first), and those that a recorder did not close.
const AFTER_KIND: [&str; 5] = ["zstd", "zst", "lz4", "bz2", "active"];

/// The parts of a flight.
#[derive(Debug, Default)]
pub struct Parts {
    /// Those that are there, in order.
    pub files: Vec<PathBuf>,
    /// Those that are not there although the `metadata.yaml` of their folder names them.
    pub missing: Vec<Loss>,
    /// Recordings of other kinds in a folder, which are left out: most are copies, or made of its recordings.
    pub left_out: Vec<PathBuf>,
}

/// The recordings in `inputs`, in the order given. A folder stands for the .mcap files in it; if there are none, for the
/// .db3 files; then .bag, .clf, .pcd, .ply. They come in the order in which its `metadata.yaml` names them, others by name,
/// `flight_2` before `flight_10`.
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
    let failed = |source| IngestError::cannot_open(folder, source);
    let (mut files, mut folders) = (Vec::new(), 0);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        folders += usize::from(path.is_dir());
        if path.is_file() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
    let kind = KINDS.into_iter().find(|kind| files.iter().any(|path| is_of_kind(path, kind)));
    let Some(kind) = kind else {
        return Err(IngestError::NoRecordings { path: folder.to_owned(), files: files.len(), folders });
    };
    let (mut recordings, others): (Vec<_>, Vec<_>) = files.into_iter().partition(|path| is_of_kind(path, kind));
    let is_recording = |path: &PathBuf| KINDS.iter().chain(&KINDS_TO_NAME).any(|kind| is_of_kind(path, kind));
    parts.left_out.extend(others.into_iter().filter(is_recording));
    // Who decompressed or closed a part may have kept both.
    let is_twin = |path: &PathBuf| original(path) != *path && original(path).is_file();
    recordings.retain(|path| !is_twin(path));
    let named = metadata::parts_of(folder);
    let mut places = BTreeMap::new();
    for (place, path) in named.iter().enumerate() {
        places.entry(name_of(path)).or_insert(place);
    }
    recordings.sort_by_cached_key(|path| places.get(&name_of(path)).copied().unwrap_or(usize::MAX));
    let there: BTreeSet<_> = recordings.iter().map(|path| name_of(path)).collect();
    let missing = named.into_iter().filter(|path| is_of_kind(path, kind) && !there.contains(&name_of(path)));
    parts.missing.extend(missing.map(|file| {
        let kind = LossKind::File { cause: "it is not there, though metadata.yaml names it".to_owned() };
        Loss { file, kind }
    }));
    parts.files.extend(recordings);
    Ok(())
}

fn is_of_kind(path: &Path, kind: &str) -> bool {
    has_extension(&original(path), kind)
}

/// The name of a part before it was compressed, and when it was closed: FLIGHT.mcap of FLIGHT.mcap.zstd.
fn original(path: &Path) -> PathBuf {
    let has_more = AFTER_KIND.iter().any(|ending| has_extension(path, ending));
    if has_more { original(&path.with_extension("")) } else { path.to_owned() }
}

/// What a part is called in its folder, compressed or not, on any file system.
fn name_of(path: &Path) -> String {
    original(path).file_name().unwrap_or_default().to_string_lossy().to_lowercase()
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
