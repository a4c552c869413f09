//! `components`: one cluster per column of a U whose columns have no row in common.

use crosscut_stage::NoteCode::{N076, N077};
use crosscut_stage::{Count, Kind, KmeansStage, Notes, Partition, Spectrum, StageError, counted};
use faer::Mat;

use crate::kmeans_plus_plus::KmeansPlusPlus;
use crate::no_zeros::without_clusters;
use crate::numbering::by_first_return;
use crate::rows::{check_columns, not_finite};

const MIN_CLUSTER: Count = Count::new("min_cluster", "returns", 1)
    .from(1)
    .to(1_000_000)
    .doc("components with fewer returns are left out: their returns have no cluster");

/// The column of a return whose row is 0.
const NO_COLUMN: u32 = u32::MAX;
/// Entries of U that are compared with 0 together: as a rule a column belongs to one wall and is 0 for long stretches.
const CHUNK: usize = 8;

/// Clusters without k-means.
pub const KIND: Kind<dyn KmeansStage> = Kind::kmeans(
    "components",
    "a cluster for each connected component, read off a U whose columns share no row",
    |params| Box::new(ColumnClusters { min_cluster: params.get(MIN_CLUSTER), ..ColumnClusters::default() }),
)
.params(&[MIN_CLUSTER.spec]);

/// The cluster of a return is the one column of U in which its row is not 0, as in the U of the solvers `components`
/// and `blocks`. The full decompositions mix the eigenvectors of a repeated zero, and so does `blocks` where a
/// component has more zeros than one: such a U goes to [`KmeansPlusPlus`] with its defaults, with a note.
///
/// Clusters of fewer than `min_cluster` returns are left out, with a note.
#[derive(Default)]
struct ColumnClusters {
    min_cluster: usize,
    /// The column of each return, and what stands there.
    columns: Vec<u32>,
    entries: Vec<f64>,
    /// The number of returns of each column.
    sizes: Vec<usize>,
    /// The mean of the entries of each column.
    means: Vec<f64>,
    /// For a U that mixes its columns.
    mixed: KmeansPlusPlus,
}

impl ColumnClusters {
    /// Fills `columns`, `entries`, `sizes` and `means`, unless a row has not exactly one entry.
    ///
    /// # Errors
    /// When an entry is not finite.
    fn read_columns(&mut self, u: &Mat<f64>) -> Result<bool, StageError> {
        let Self { columns, entries, sizes, means, .. } = self;
        columns.clear();
        columns.resize(u.nrows(), NO_COLUMN);
        entries.resize(u.nrows(), 0.0);
        sizes.clear();
        sizes.resize(u.ncols(), 0);
        means.clear();
        means.resize(u.ncols(), 0.0);
        let (mut shared, mut finite) = (false, true);
        for j in 0..u.ncols() {
            for (start, values) in (0..).step_by(CHUNK).zip(u.col_as_slice(j).chunks(CHUNK)) {
                if values.iter().fold(true, |zero, &value| zero & (value == 0.0)) {
                    continue;
                }
                for (i, &entry) in (start..).zip(values).filter(|(_, value)| **value != 0.0) {
                    finite &= entry.is_finite();
                    shared |= columns[i] != NO_COLUMN;
                    (columns[i], entries[i]) = (j as u32, entry);
                    sizes[j] += 1;
                    means[j] += entry;
                }
            }
        }
        if !finite {
            return Err(not_finite(u));
        }
        means.iter_mut().zip(sizes).for_each(|(sum, &mut size)| *sum /= size.max(1) as f64);
        Ok(!shared && !columns.contains(&NO_COLUMN))
    }

    /// Notes how much is left out.
    fn note_dropped(&self, notes: &mut Notes) {
        let dropped = || self.sizes.iter().filter(|&&size| size > 0 && size < self.min_cluster);
        if dropped().count() > 0 {
            let (components, returns) = (dropped().count(), counted(dropped().sum::<usize>() as u64, "return"));
            let least = self.min_cluster;
            notes.add(
                N076,
                format!("components: {components} of fewer than {least} returns left out, {returns} in all"),
            );
        }
    }
}

impl KmeansStage for ColumnClusters {
    fn partition(&mut self, spectrum: &Spectrum, out: &mut Partition, notes: &mut Notes) -> Result<(), StageError> {
        check_columns(spectrum)?;
        let (n, k) = (spectrum.u.nrows(), spectrum.u.ncols());
        if n == 0 || k == 0 {
            without_clusters(n, k, out, notes);
            return Ok(());
        }
        if !self.read_columns(&spectrum.u)? {
            notes.add(
                N077, "components: some rows of U do not have exactly one entry, so kmeans++ clusters them, small clusters too",
            );
            return self.mixed.partition(spectrum, out, notes).map_err(|error| match error {
                StageError::TooLarge(_) => StageError::TooLarge(format!(
                    "some rows of U do not have exactly one entry, and k-means on its {n}x{k} numbers is too large: choose \
                     spectral.kind = \"components\""
                )),
                error => error,
            });
        }
        let columns = self.columns.iter().copied();
        let numbers = by_first_return(columns.filter(|&column| self.sizes[column as usize] >= self.min_cluster), k);
        out.labels.clear();
        out.labels.extend(self.columns.iter().map(|&column| numbers[column as usize]));
        out.clusters = numbers.iter().flatten().count();
        // The mean of the rows of a cluster is not 0 in its column only.
        out.centroids.resize_with(out.clusters, k, |_, _| 0.0);
        out.centroids.fill(0.0);
        for (column, number) in numbers.iter().enumerate() {
            number.iter().for_each(|&number| out.centroids[(number as usize, column)] = self.means[column]);
        }
        let distance = |((&column, entry), label): ((&u32, &f64), &Option<u32>)| {
            label.map_or(0.0, |_| (entry - self.means[column as usize]).powi(2))
        };
        out.inertia = self.columns.iter().zip(&self.entries).zip(&out.labels).map(distance).sum();
        self.note_dropped(notes);
        Ok(())
    }
}
