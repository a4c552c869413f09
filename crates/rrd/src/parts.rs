//! The parts of a long recording: the names of their files, and the marks by which a missing part is noticed.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use rerun::log::{Chunk, LogMsg};
use rerun::{Tensor, TensorBuffer, components};

use crate::Damage;
use crate::messages::{Messages, chunk_of};
use crate::schema;

/// The file of a part: FLIGHT.rrd is the first, FLIGHT-2.rrd the second.
pub fn part_path(first: &Path, part: u64) -> PathBuf {
    if part < 2 {
        return first.to_owned();
    }
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    let extension = first.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
    first.with_file_name(format!("{stem}-{part}{extension}"))
}

/// The files beside `first` that have the names of its further parts, in order. Those of an older, longer recording of
/// this name may be among them.
pub fn files_named_like_parts(first: &Path) -> Vec<PathBuf> {
    let folder = first.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut parts: Vec<u64> = files.filter_map(|file| part_number(first, &file.file_name())).collect();
    parts.sort_unstable();
    parts.into_iter().map(|part| part_path(first, part)).collect()
}

/// The number of the part of recording `first` to which a file of this name in the same folder belongs; `None` if it is
/// no later part.
pub fn part_number(first: &Path, name: &OsStr) -> Option<u64> {
    let part = Path::new(name).file_stem()?.to_str()?.rsplit_once('-')?.1.parse().ok()?;
    (part > 1 && part_path(first, part).file_name() == Some(name)).then_some(part)
}

/// The part number that a file states; `None` if it is no recording or states none.
pub fn part_in(path: &Path) -> Option<u64> {
    Messages::open(path).ok()?.flatten().find_map(|(_, message)| {
        let LogMsg::ArrowMsg(_, message) = message else { return None };
        let chunk = chunk_of(&message).ok().filter(|chunk| chunk.entity_path().to_string() == schema::PART.path)?;
        let mut marks = Marks::default();
        marks.read(&chunk);
        marks.continues.into_keys().next()
    })
}

/// The marks of the parts of a recording. A recording of a version that wrote none is taken for complete.
#[derive(Debug, Default)]
pub struct Marks {
    /// Whether another part follows, by part number. A file that was merged from several parts has several.
    continues: BTreeMap<u64, bool>,
}

impl Marks {
    /// Reads a chunk of [`schema::PART`].
    pub fn read(&mut self, chunk: &Chunk) {
        for row in 0..chunk.num_rows() {
            let data = chunk.component_batch::<components::TensorData>(Tensor::descriptor_data().component, row);
            if let Some(Ok(data)) = data
                && let Some(TensorBuffer::F64(values)) = data.first().map(|tensor| &tensor.buffer)
                && let [number, continues] = values.as_ref()
            {
                *self.continues.entry(*number as u64).or_default() |= *continues != 0.0;
            }
        }
    }

    /// The parts that are missing of the recording that begins at `path`.
    pub fn missing(&self, path: &Path) -> Vec<Damage> {
        let mut missing = Vec::new();
        let mut next = 1;
        for &number in self.continues.keys() {
            if number > next {
                missing.push(Damage::PartsMissing { path: path.to_owned(), first: next, last: number - 1 });
            }
            next = number.saturating_add(1);
        }
        if self.continues.values().next_back() == Some(&true) {
            missing.push(Damage::EndMissing { path: path.to_owned(), part: next });
        }
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_numbered_from_the_second() {
        let parts = |name: &str| [1, 2, 10].map(|part| part_path(Path::new(name), part).display().to_string());
        assert_eq!(parts("out/tee.rrd"), ["out/tee.rrd", "out/tee-2.rrd", "out/tee-10.rrd"]);
        assert_eq!(parts("tee"), ["tee", "tee-2", "tee-10"]);
    }

    #[test]
    fn only_the_name_of_a_part_is_taken_for_one() {
        let number = |name: &str| part_number(Path::new("out/tee.rrd"), OsStr::new(name));
        assert_eq!(["tee-2.rrd", "tee-10.rrd"].map(number), [Some(2), Some(10)]);
        for other in ["tee.rrd", "tee-1.rrd", "tee-02.rrd", "tee-2.mcap", "tee-x.rrd", "bee-2.rrd", "tee-2-2.rrd"] {
            assert_eq!(number(other), None, "{other}");
        }
    }

    #[test]
    fn missing_parts_are_found_by_the_marks_of_the_others() {
        let found = |marks: &[(u64, bool)]| -> Vec<String> {
            let marks = Marks { continues: marks.iter().copied().collect() };
            marks.missing(Path::new("x")).iter().map(ToString::to_string).collect()
        };
        assert_eq!(found(&[]), [""; 0]);
        assert_eq!(found(&[(1, true), (2, true), (3, false)]), [""; 0]);
        assert_eq!(found(&[(1, true), (3, false)]), ["part 2 is missing: x"]);
        assert_eq!(found(&[(1, true), (5, false)]), ["parts 2 to 4 are missing: x"]);
        assert_eq!(found(&[(2, false)]), ["part 1 is missing: x"]);
        assert_eq!(found(&[(1, true), (2, true)]), ["part 3, which continues the recording, is missing: x"]);
    }
}
