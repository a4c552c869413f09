//! `components`: one cluster per column of a U whose columns have no row in common.

use crosscut_stage::{Kind, KmeansStage, Notes, ParamError, ParamSpec, Partition, Shape, Spectrum, StageError, Value};

use crate::no_zeros::without_clusters;
use crate::numbering::by_first_return;
use crate::rows::Rows;

const MIN_CLUSTER: ParamSpec = ParamSpec {
    name: "min_cluster",
    unit: "returns",
    shape: Shape::Integer { default: 1, min: 1, max: 1_000_000 },
    doc: "components with fewer returns are left out: their returns have no cluster",
};

pub(crate) const KIND: Kind<dyn KmeansStage> = Kind {
    name: "components",
    doc: "a cluster for each connected component, read off the U of the solver `components` (baseline)",
    params: &[MIN_CLUSTER],
    build: |params| Box::new(Components::with(params.count(MIN_CLUSTER.name))),
};

/// The cluster of a return is the one column of U in which its row is not 0, as in the U of the solver `components`. Any
/// other U is refused: the full decompositions mix the eigenvectors of a repeated zero.
///
/// Components of fewer than `min_cluster` returns (DBSCAN's noise: fewer than 2) get no cluster, with a note.
#[derive(Clone, Debug)]
pub struct Components {
    min_cluster: usize,
    rows: Rows,
    /// The column of each return, and the number of returns of each column.
    columns: Vec<u32>,
    sizes: Vec<usize>,
}

impl Components {
    /// With the least number of returns of a cluster, at least 1.
    ///
    /// # Errors
    /// When the number is out of range.
    pub fn new(min_cluster: u32) -> Result<Self, ParamError> {
        MIN_CLUSTER.check(Value::Integer(min_cluster.into()))?;
        Ok(Self::with(min_cluster as usize))
    }

    fn with(min_cluster: usize) -> Self {
        Self { min_cluster, rows: Rows::default(), columns: Vec::new(), sizes: Vec::new() }
    }

    /// Fills `columns` and `sizes`; k > 0.
    fn read_columns(&mut self) -> Result<(), StageError> {
        self.columns.clear();
        self.sizes.clear();
        self.sizes.resize(self.rows.dimension(), 0);
        for (i, row) in self.rows.iter().enumerate() {
            let mut present = row.iter().enumerate().filter(|(_, entry)| **entry != 0.0).map(|(column, _)| column);
            let (Some(column), None) = (present.next(), present.next()) else {
                return Err(StageError::Unsupported(format!(
                    "row {i} of U does not have exactly one entry that is not 0: kmeans `components` needs the U of \
                     spectral `components`"
                )));
            };
            self.columns.push(column as u32);
            self.sizes[column] += 1;
        }
        Ok(())
    }

    /// The mean of the rows of each cluster: not 0 in one column only.
    fn write_centroids(&self, numbers: &[Option<u32>], out: &mut Partition) {
        out.centroids.resize_with(out.clusters, self.rows.dimension(), |_, _| 0.0);
        out.centroids.fill(0.0);
        for (i, &column) in self.columns.iter().enumerate() {
            let column = column as usize;
            if let Some(number) = numbers[column] {
                out.centroids[(number as usize, column)] += self.rows.row(i)[column] / self.sizes[column] as f64;
            }
        }
    }

    /// Notes how much is left out.
    fn note_dropped(&self, notes: &mut Notes) {
        let dropped = || self.sizes.iter().filter(|&&size| size > 0 && size < self.min_cluster);
        if dropped().count() > 0 {
            let (components, returns) = (dropped().count(), dropped().sum::<usize>());
            let least = self.min_cluster;
            notes.add(format!(
                "components: {components} of fewer than {least} returns left out, {returns} returns in all"
            ));
        }
    }
}

impl KmeansStage for Components {
    fn partition(&mut self, spectrum: &Spectrum, out: &mut Partition, notes: &mut Notes) -> Result<(), StageError> {
        self.rows.copy_from(spectrum)?;
        let (n, k) = (self.rows.len(), self.rows.dimension());
        if n == 0 || k == 0 {
            without_clusters(n, k, out, notes);
            return Ok(());
        }
        self.read_columns()?;
        let kept = self.columns.iter().copied().filter(|&column| self.sizes[column as usize] >= self.min_cluster);
        let numbers = by_first_return(kept, k);
        out.labels.clear();
        out.labels.extend(self.columns.iter().map(|&column| numbers[column as usize]));
        out.clusters = numbers.iter().flatten().count();
        self.write_centroids(&numbers, out);
        let distance = |(row, label): (&[f64], &Option<u32>)| {
            label.map_or(0.0, |c| (0..k).map(|j| (row[j] - out.centroids[(c as usize, j)]).powi(2)).sum())
        };
        out.inertia = self.rows.iter().zip(&out.labels).map(distance).sum();
        self.note_dropped(notes);
        Ok(())
    }
}
