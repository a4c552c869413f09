//! What the `metadata.yaml` of a rosbag2 says of its parts.

use std::fs;
use std::path::{Path, PathBuf};

use saphyr::{LoadableYamlNode as _, Yaml};

const FILE: &str = "metadata.yaml";

/// No list of parts is longer: what is, is no metadata.
const MOST_BYTES: u64 = 64 << 20;

/// The parts of the bag that is kept in `folder`, in the order in which they were recorded, whether they are there or
/// not; empty if it is none, or says nothing that can be read.
pub(crate) fn parts_of(folder: &Path) -> Vec<PathBuf> {
    let path = folder.join(FILE);
    let is_small = path.metadata().is_ok_and(|file| file.is_file() && file.len() <= MOST_BYTES);
    let text = if is_small { fs::read_to_string(path).unwrap_or_default() } else { String::new() };
    // A bag may have been moved, with paths as they were before, on another system.
    names_in(&text).iter().filter_map(|name| Some(folder.join(name.rsplit(['/', '\\']).next()?))).collect()
}

/// Whether `folder` has such a file: then its recorder has closed the bag.
pub(crate) fn is_there(folder: &Path) -> bool {
    folder.join(FILE).is_file()
}

fn names_in(text: &str) -> Vec<String> {
    let Ok(documents) = Yaml::load_from_str(text) else { return Vec::new() };
    let bag = documents.first().and_then(|document| document.as_mapping_get("rosbag2_bagfile_information"));
    let paths = bag.and_then(|bag| bag.as_mapping_get("relative_file_paths")).and_then(Yaml::as_sequence);
    paths.into_iter().flatten().filter_map(Yaml::as_str).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::names_in;

    #[test]
    fn parts_are_named_in_the_order_in_which_they_were_recorded() {
        let text =
            "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - zeta.mcap\n    - \"a b.mcap\"\n";
        assert_eq!(names_in(text), ["zeta.mcap", "a b.mcap"]);
        for other in [
            "",
            "a: [",
            "rosbag2_bagfile_information: 3",
            "- 1",
            "rosbag2_bagfile_information:\n  relative_file_paths: {}",
        ] {
            assert_eq!(names_in(other), [""; 0], "{other}");
        }
    }
}
