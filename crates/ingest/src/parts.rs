//! The parts of a flight, open.

use std::path::PathBuf;

use crate::container::{self, Container};
use crate::{CsvGeometry, IngestError, Loss, Parts, parts_in};

/// The parts of a flight that can be read, and what is missing of it.
pub(crate) struct OpenParts {
    pub(crate) containers: Vec<Box<dyn Container>>,
    pub(crate) losses: Vec<Loss>,
    /// As in [`Parts`].
    pub(crate) left_out: Vec<PathBuf>,
}

impl OpenParts {
    /// Opens every part of a flight. One that `metadata.yaml` names and is not there, or that is no recording, is a loss, as
    /// long as another can be read.
    pub(crate) fn open(inputs: &[PathBuf], csv: &CsvGeometry) -> Result<Self, IngestError> {
        let Parts { files, missing: mut losses, left_out } = parts_in(inputs)?;
        let mut containers = Vec::new();
        for file in &files {
            match container::open(file, csv) {
                Ok(container) => containers.push(container),
                Err(error) => {
                    let is_one_of_several = files.len() > 1 || !inputs.contains(file);
                    let loss = error.as_loss(inputs.contains(file)).filter(|_| is_one_of_several);
                    losses.push(loss.ok_or(error)?);
                }
            }
        }
        if containers.is_empty() {
            Err(IngestError::NothingReadable { losses })
        } else {
            Ok(Self { containers, losses, left_out })
        }
    }
}
