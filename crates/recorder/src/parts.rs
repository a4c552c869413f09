//! Names of the parts of a long recording.

use std::path::{Path, PathBuf};

/// FLIGHT.rrd is the first part, FLIGHT-2.rrd the second.
pub(crate) fn part_path(first: &Path, part: u64) -> PathBuf {
    if part < 2 {
        return first.to_owned();
    }
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    let extension = first.extension().map(|extension| format!(".{}", extension.to_string_lossy())).unwrap_or_default();
    first.with_file_name(format!("{stem}-{part}{extension}"))
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
}
