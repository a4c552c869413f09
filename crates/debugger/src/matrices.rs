//! Arrays of the present revolution, for NumPy and for pictures.

use std::path::Path;

use crosscut_spectral::Laplacian;
use crosscut_stage::Frame;
use faer::Mat;

use crate::command::takes;
use crate::npy::NpyArray;
use crate::{Refused, Session};

impl Session {
    pub(crate) fn get(&mut self, what: &str, path: &str) -> Result<String, Refused> {
        if self.frame().failure.is_some() {
            return Err(Refused::Failed(crate::session::answer_in_words(self.frame())));
        }
        let array = array(self.frame(), what)?;
        let written = crosscut_outfile::write(Path::new(path), array.to_bytes());
        written.map_err(|error| Refused::Failed(format!("{error}, in {path}")))?;
        let shape: Vec<String> = array.shape.iter().map(ToString::to_string).collect();
        Ok(format!("{what}, {}, in {path}", shape.join("x")))
    }
}

/// An array of a revolution, by its name on the command line.
fn array(frame: &Frame, what: &str) -> Result<NpyArray, Refused> {
    let vector = |values: Vec<f64>| NpyArray { shape: vec![values.len()], values };
    Ok(match what {
        "W" => by_rows(&w(frame)),
        "L" => by_rows(&l(frame)?),
        "U" => by_rows(&frame.spectrum.u),
        "D" => vector(frame.affinity.degrees.clone()),
        "eigenvalues" => vector(frame.spectrum.eigenvalues.clone()),
        "labels" => vector(frame.partition.labels.iter().map(|label| label.map_or(-1.0, f64::from)).collect()),
        "points" => {
            let values = frame.revolution.points_m.iter().flat_map(|point| [point.x, point.y, point.z]).collect();
            NpyArray { shape: vec![frame.revolution.len(), 3], values }
        }
        _ => return Err(takes("get")),
    })
}

fn by_rows(matrix: &Mat<f64>) -> NpyArray {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let values = (0..rows * columns).map(|at| matrix[(at / columns, at % columns)]).collect();
    NpyArray { shape: vec![rows, columns], values }
}

/// W, dense.
pub(crate) fn w(frame: &Frame) -> Mat<f64> {
    let n = frame.affinity.weights.n();
    let mut w = Mat::zeros(n, n);
    frame.affinity.weights.for_each(|i, j, weight| w[(i, j)] = weight);
    w
}

/// L = I - D^-1/2 W D^-1/2.
pub(crate) fn l(frame: &Frame) -> Result<Mat<f64>, Refused> {
    let mut laplacian = Laplacian::default();
    let l = laplacian.form(&frame.affinity).map_err(|error| Refused::Failed(error.to_string()))?;
    let n = frame.affinity.weights.n();
    Ok(Mat::from_fn(n, n, |i, j| l[(i, j)]))
}
