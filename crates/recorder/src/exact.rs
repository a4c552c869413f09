//! W and U as the pipeline had them, to the last bit.

use crosscut_stage::Frame;
use rerun::{RecordingStream, RecordingStreamResult};

use crate::beam_order::LARGEST_SIDE;
use crate::tensors::{f64_matrix, f64_rows};

/// W as its upper triangle with zeros below, which compression takes at next to nothing; and U.
pub(crate) fn log(rec: &RecordingStream, frame: &Frame) -> RecordingStreamResult<()> {
    let n = frame.affinity.weights.n();
    if n > LARGEST_SIDE {
        return Ok(()); // a note says so for the pictures
    }
    let mut upper = vec![0.0; n * n];
    frame.affinity.weights.for_each(|i, j, w| {
        if i <= j {
            upper[i * n + j] = w;
        }
    });
    rec.log("affinity/W/exact", &f64_matrix(upper, [n, n], ["return i", "return j, upper triangle"]))?;
    rec.log("spectral/U/exact", &f64_rows(&frame.spectrum.u, "return"))
}
