//! Clusters by a callable: kmeans(U, k) -> labels.

use std::collections::BTreeMap;

use crosscut_stage::{Kind, KmeansStage, Notes, Partition, Spectrum, StageError};
use faer::Mat;
use pyo3::prelude::*;

use super::{CALLABLE, Callable, PYTHON};
use crate::arrays;

pub(crate) const KIND: Kind<dyn KmeansStage> =
    Kind::kmeans(PYTHON, "clusters by a callable of Python: kmeans(U, k) -> labels", |params| {
        Box::new(PythonKmeans { callable: Callable::chosen(params) })
    })
    .params(&[CALLABLE.spec]);

struct PythonKmeans {
    callable: Option<Callable>,
}

impl KmeansStage for PythonKmeans {
    fn partition(&mut self, spectrum: &Spectrum, out: &mut Partition, _: &mut Notes) -> Result<(), StageError> {
        let (callable, n, k) = (self.callable.as_ref(), spectrum.u.nrows(), spectrum.k);
        let labels: Vec<i64> = if n == 0 {
            Vec::new()
        } else {
            let u = &spectrum.u;
            let read = |returned: &Bound<'_, PyAny>| arrays::labels(returned, n);
            Callable::call(callable, |py| (arrays::embedding(py, u)?, k).into_pyobject(py), read)?
        };
        if labels.len() != n {
            return Err(Callable::refuse(callable, format!("{} labels for {n} returns", labels.len())));
        }
        if let Some(at) = labels.iter().position(|label| *label < -1) {
            return Err(Callable::refuse(callable, format!("labels[{at}] = {}, which is less than -1", labels[at])));
        }
        (out.clusters, out.labels) = numbered_by_first_return(&labels);
        place_centroids(spectrum, out);
        Ok(())
    }
}

/// The number of clusters, and the labels with clusters numbered by their first return; a negative label is of no cluster.
fn numbered_by_first_return(labels: &[i64]) -> (usize, Vec<Option<u32>>) {
    let mut numbers = BTreeMap::new();
    let mut number = |label: i64| {
        let next = numbers.len() as u32;
        (label >= 0).then(|| *numbers.entry(label).or_insert(next))
    };
    let labels = labels.iter().map(|&label| number(label)).collect();
    (numbers.len(), labels)
}

/// Sets the means of the rows of each cluster, and how far the rows are from them.
fn place_centroids(spectrum: &Spectrum, out: &mut Partition) {
    let (clusters, k) = (out.clusters, spectrum.u.ncols());
    let (mut sums, mut counts) = (vec![0.0; clusters * k], vec![0.0; clusters]);
    let labelled = || out.labels.iter().enumerate().filter_map(|(i, label)| Some((i, (*label)? as usize)));
    for (i, cluster) in labelled() {
        counts[cluster] += 1.0;
        (0..k).for_each(|j| sums[cluster * k + j] += spectrum.u[(i, j)]);
    }
    let centre = |cluster: usize, j: usize| sums[cluster * k + j] / counts[cluster];
    out.inertia = labelled()
        .map(|(i, cluster)| (0..k).map(|j| (spectrum.u[(i, j)] - centre(cluster, j)).powi(2)).sum::<f64>())
        .sum();
    out.centroids = Mat::from_fn(clusters, k, centre);
}
