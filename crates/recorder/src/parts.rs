//! The parts of a long recording, as they are written: which file is next, and what each part says of itself.

use std::path::Path;

use crosscut_rrd::parts::{part_in, part_path};

use crate::rows::Rows;
use crate::schema::PART;
use crate::tensors::f64_vector;

/// The number of the next file after `number` that a part may be written to. A recording of its own that has the name
/// of a part is passed over. A later part that an older recording of this name left is replaced.
pub(crate) fn next_free(first: &Path, number: u64) -> u64 {
    let next = number + 1;
    (next..).find(|&number| is_free(&part_path(first, number))).unwrap_or(next)
}

fn is_free(path: &Path) -> bool {
    match path.metadata() {
        Ok(file) if file.is_file() && file.len() > 0 => part_in(path).is_some_and(|part| part > 1),
        _ => true, // where nothing can be written, creating the file reports why
    }
}

/// Records at the first revolution of a part which one it is, from 1; and at its last again if another part follows.
pub(crate) fn log(rows: &mut Rows, part: u64, continues: bool) {
    rows.log_tensor(&PART, f64_vector(vec![part as f64, f64::from(u8::from(continues))], PART.dims), &[]);
}
