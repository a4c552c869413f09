//! W and U to the last bit.

use crosscut_stage::Frame;

use crate::beam_order::LARGEST_SIDE;
use crate::rows::Rows;
use crate::schema::{AFFINITY_W_EXACT, SPECTRAL_U_EXACT};
use crate::tensors::{f64_matrix, f64_rows};

/// The upper triangle of W, with zeros below that compress to almost nothing; and U.
pub(crate) fn log(rows: &mut Rows, frame: &Frame) {
    let n = frame.affinity.weights.n();
    if n > LARGEST_SIDE {
        return; // the note about pictures covers this as well
    }
    let mut upper = vec![0.0; n * n];
    frame.affinity.weights.for_each(|i, j, w| {
        if i <= j {
            upper[i * n + j] = w;
        }
    });
    rows.log_tensor(&AFFINITY_W_EXACT, f64_matrix(upper, [n, n], AFFINITY_W_EXACT.dims), &[]);
    rows.log_tensor(&SPECTRAL_U_EXACT, f64_rows(&frame.spectrum.u, SPECTRAL_U_EXACT.dims), &[]);
}
