//! The parts of a long recording: their names, and what each says of itself, so that a missing one is noticed.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use rerun::log::{Chunk, LogMsg};
use rerun::{Tensor, TensorBuffer, components};

use crate::reading::Damage;
use crate::reading::messages::{Messages, chunk_of};
use crate::rows::Rows;
use crate::schema::PART;
use crate::tensors::f64_vector;

/// FLIGHT.rrd is the first part, FLIGHT-2.rrd the second.
pub(crate) fn part_path(first: &Path, part: u64) -> PathBuf {
    if part < 2 {
        return first.to_owned();
    }
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    let extension = first.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
    first.with_file_name(format!("{stem}-{part}{extension}"))
}

/// The files beside `first` that are called like its further parts, in order. Those of an older, longer recording of
/// this name may be among them.
pub(crate) fn called_like_parts(first: &Path) -> Vec<PathBuf> {
    let folder = first.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut parts: Vec<u64> = files.filter_map(|file| part_number(first, &file.file_name())).collect();
    parts.sort_unstable();
    parts.into_iter().map(|part| part_path(first, part)).collect()
}

/// The number of the later part of the recording `first`, in the same folder, that a file of this name is; `None` if it
/// is none.
pub fn part_number(first: &Path, name: &OsStr) -> Option<u64> {
    let part = Path::new(name).file_stem()?.to_str()?.rsplit_once('-')?.1.parse().ok()?;
    (part > 1 && part_path(first, part).file_name() == Some(name)).then_some(part)
}

/// The number of the next file after `number` that a part may be written to. A recording of its own that is called like
/// a part is passed over; a later part, as an older recording of this name left it, is replaced.
pub(crate) fn next_free(first: &Path, number: u64) -> u64 {
    let next = number + 1;
    (next..).find(|&number| is_free(&part_path(first, number))).unwrap_or(next)
}

fn is_free(path: &Path) -> bool {
    match path.metadata() {
        Ok(file) if file.is_file() && file.len() > 0 => part_in(path).is_some_and(|part| part > 1),
        _ => true, // where nothing can be written, creating it says why
    }
}

/// Which part a file says it is; `None` if it is no recording, or says nothing.
fn part_in(path: &Path) -> Option<u64> {
    Messages::open(path).ok()?.flatten().find_map(|(_, message)| {
        let LogMsg::ArrowMsg(_, message) = message else { return None };
        let chunk = chunk_of(&message).ok().filter(|chunk| chunk.entity_path().to_string() == MARK)?;
        let mut marks = Marks::default();
        marks.read(&chunk);
        marks.goes_on.into_keys().next()
    })
}

/// Where every part says which it is.
pub(crate) const MARK: &str = PART.path;

/// Says at the first revolution of a part which it is, from 1; and again at its last if another part follows.
pub(crate) fn log(rows: &mut Rows, part: u64, goes_on: bool) {
    rows.log(&PART, &f64_vector(vec![part as f64, f64::from(u8::from(goes_on))], PART.dims));
}

/// What the parts of a recording say of themselves. Those of a version that said nothing are taken for whole.
#[derive(Debug, Default)]
pub(crate) struct Marks {
    /// Whether another part follows, by number. In rows, as files that were merged into one keep them all.
    goes_on: BTreeMap<u64, bool>,
}

impl Marks {
    /// Takes in a chunk of [`MARK`].
    pub(crate) fn read(&mut self, chunk: &Chunk) {
        for row in 0..chunk.num_rows() {
            let data = chunk.component_batch::<components::TensorData>(Tensor::descriptor_data().component, row);
            if let Some(Ok(data)) = data
                && let Some(TensorBuffer::F64(values)) = data.first().map(|tensor| &tensor.buffer)
                && let [number, goes_on] = values.as_ref()
            {
                *self.goes_on.entry(*number as u64).or_default() |= *goes_on != 0.0;
            }
        }
    }

    /// The parts that are missing of the recording that begins at `path`.
    pub(crate) fn missing(&self, path: &Path) -> Vec<Damage> {
        let mut missing = Vec::new();
        let mut next = 1;
        for &number in self.goes_on.keys() {
            if number > next {
                missing.push(Damage::PartsMissing { path: path.to_owned(), first: next, last: number - 1 });
            }
            next = number.saturating_add(1);
        }
        if self.goes_on.values().next_back() == Some(&true) {
            missing.push(Damage::EndMissing { path: path.to_owned(), part: next });
        }
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_stand_beside_each_other_and_are_numbered_from_the_second() {
        let parts = |name: &str| [1, 2, 10].map(|part| part_path(Path::new(name), part).display().to_string());
        assert_eq!(parts("out/tee.rrd"), ["out/tee.rrd", "out/tee-2.rrd", "out/tee-10.rrd"]);
        assert_eq!(parts("tee"), ["tee", "tee-2", "tee-10"]);
    }

    #[test]
    fn only_a_name_that_a_part_would_have_is_taken_for_one() {
        let number = |name: &str| part_number(Path::new("out/tee.rrd"), OsStr::new(name));
        assert_eq!(["tee-2.rrd", "tee-10.rrd"].map(number), [Some(2), Some(10)]);
        for other in ["tee.rrd", "tee-1.rrd", "tee-02.rrd", "tee-2.mcap", "tee-x.rrd", "bee-2.rrd", "tee-2-2.rrd"] {
            assert_eq!(number(other), None, "{other}");
        }
    }

    #[test]
    fn parts_that_are_missing_are_told_by_what_the_others_say_of_themselves() {
        let said = |marks: &[(u64, bool)]| -> Vec<String> {
            let marks = Marks { goes_on: marks.iter().copied().collect() };
            marks.missing(Path::new("x")).iter().map(ToString::to_string).collect()
        };
        assert_eq!(said(&[]), [""; 0]);
        assert_eq!(said(&[(1, true), (2, true), (3, false)]), [""; 0]);
        assert_eq!(said(&[(1, true), (3, false)]), ["part 2 is missing: x"]);
        assert_eq!(said(&[(1, true), (5, false)]), ["parts 2 to 4 are missing: x"]);
        assert_eq!(said(&[(2, false)]), ["part 1 is missing: x"]);
        assert_eq!(said(&[(1, true), (2, true)]), ["part 3, in which the recording goes on, is missing: x"]);
    }
}
