//! What is logged of one revolution, and what that needs to know of those before it.

use crosscut_explain::{Explanation, Watch};
use crosscut_stage::Frame;
use rerun::{Clear, TextLog, TextLogLevel};

use crate::as_read::AsRead;
use crate::beam_order::BeamOrder;
use crate::eigenvectors::Bands;
use crate::layout::Extent;
use crate::matrices::{Absent, Pictures};
use crate::notes::Notes;
use crate::options::RecorderOptions;
use crate::rows::Rows;
use crate::scan::BeamGeometry;
use crate::schema::{
    AFFINITY_DEGREES, AFFINITY_LINKS, AFFINITY_MARKS, KMEANS_BLOCKS, LOG, SPECTRAL_EMBEDDING, SPECTRAL_U,
    SPECTRAL_U_BARS,
};
use crate::scope::Share;
use crate::timing::Times;
use crate::tracks::Tracks;
use crate::walls::Before;
use crate::ways::Unrolled;
use crate::why::Told;
use crate::{exact, gaps, numbers, partition, profile, report, scan, spectrum, truth, why};

/// Logs revolutions, one after the other.
#[derive(Default)]
pub(crate) struct RevolutionLog {
    tracks: Tracks,
    before: Before,
    watch: Watch,
    doubts: why::Doubts,
    times: Times,
    notes: Notes,
    beams: BeamGeometry,
    as_read: AsRead,
    pictures: Pictures,
    unrolled: Unrolled,
    bands: Bands,
    absent: Absent,
    truth_before: Option<usize>,
    /// The stamp of the first revolution.
    first_ns: Option<u64>,
}

impl RevolutionLog {
    /// Logs one revolution. An empty one writes empty values, so that no older ones stay on the screen.
    pub(crate) fn log(
        &mut self,
        rows: &mut Rows,
        frame: &Frame,
        share: Share,
        extent: Extent,
        options: &RecorderOptions,
    ) {
        let order = BeamOrder::of(frame);
        let classes = self.tracks.classes_of(frame);
        let reach_m = extent.range_m;
        if let Some(sweep) = frame.revolution.beams()
            && self.beams.log(rows, sweep)
        {
            profile::log_axes(rows, reach_m, sweep);
        }
        scan::log(rows, frame, &classes, reach_m);
        self.unrolled.log(rows, frame, &classes, extent.has_ways());
        self.as_read.log(rows, frame);
        let scale = spectrum::embedding_scale(&frame.spectrum.u);
        spectrum::log(rows, frame);
        if share.matrices {
            self.pictures.log(rows, frame, &order);
            self.bands.log(rows, frame, &order, &classes);
            spectrum::log_embedding(rows, frame, &classes, scale);
            partition::log_blocks(rows, frame, &order, &classes);
            why::log_graph(rows, frame);
            if extent.by_gaps || !frame.affinity.verdicts.is_empty() {
                gaps::log(rows, frame, &classes);
            }
        }
        if share.exact {
            exact::log(rows, frame);
        }
        partition::log(rows, frame, &order, &classes, scale);
        profile::log(rows, frame, &classes, reach_m);
        report::log(rows, frame, &classes);
        self.absent.log(rows, frame, share.matrices, &order);
        let revolution = &frame.revolution;
        let truth = options.truth.of(revolution.seq);
        truth::log(rows, revolution.seq, truth.as_ref(), &mut self.truth_before);
        let truth = truth.map(|(walls, _)| walls);
        let first_ns = *self.first_ns.get_or_insert(revolution.stamp_ns);
        let changed = self.before.what_changed(frame, &classes);
        let told = Told { classes: &classes, source: &options.source, first_ns, truth, changed };
        let explanation = Explanation::of(frame);
        let decisive = why::decisive(&explanation);
        why::log(rows, frame, &explanation, &told, &mut self.watch);
        why::log_decisive(rows, revolution, &decisive, reach_m);
        numbers::log(rows, frame, &explanation, &classes, reach_m);
        self.doubts.log(rows, self.watch.doubt());
        if share.matrices {
            why::log_marks(rows, frame, &order, &decisive);
        }
        self.times.log(rows, frame);
        self.notes.log(rows, frame);
        if share.exact_refused {
            let text = "the count changes often: exact matrices are recorded at fewer of the changes";
            rows.log(&LOG, &TextLog::new(text).with_level(TextLogLevel::WARN));
        }
    }

    /// Logs a failure and clears the screen. The frame is not recorded, as it may hold parts of another revolution.
    pub(crate) fn log_failure(&mut self, rows: &mut Rows, failure: &str) {
        for area in ["/scan", "/affinity", "/spectral", "/kmeans", "/report"] {
            rows.log_at(area, &Clear::recursive());
        }
        self.pictures.log_dark(rows);
        self.bands.log_dark(rows);
        rows.log(&LOG, &TextLog::new(failure).with_level(TextLogLevel::ERROR));
    }

    /// Leaves nothing of the matrices of older revolutions on the screen.
    pub(crate) fn log_no_matrices(&mut self, rows: &mut Rows) {
        self.pictures.log_dark(rows);
        self.bands.log_dark(rows);
        for entity in [
            AFFINITY_MARKS,
            KMEANS_BLOCKS,
            SPECTRAL_U_BARS,
            AFFINITY_DEGREES,
            AFFINITY_LINKS,
            SPECTRAL_U,
            SPECTRAL_EMBEDDING,
        ] {
            rows.log(&entity, &Clear::flat());
        }
    }

    /// Writes again, with the next revolution, what is only written when it changes: it goes into another file, or was cleared
    /// from the screen.
    pub(crate) fn repeat(&mut self) {
        (self.beams, self.as_read, self.absent) = Default::default();
        self.doubts.repeat();
    }

    /// Forgets the revolution before, which is not the one that comes before the next in the flight.
    pub(crate) fn jump(&mut self) {
        (self.watch, self.before) = Default::default();
    }

    /// Nanoseconds of sensor time since the first revolution.
    pub(crate) fn since_first_ns(&self, stamp_ns: u64) -> u64 {
        self.first_ns.map_or(0, |first_ns| stamp_ns.abs_diff(first_ns))
    }

    /// Takes over the colours of the other log, and the time that it counts from.
    pub(crate) fn begin_as(&mut self, other: &Self) {
        self.colour_as(other);
        self.first_ns = other.first_ns;
    }

    /// Gives walls the colours that they have by the other log.
    pub(crate) fn colour_as(&mut self, other: &Self) {
        self.tracks.clone_from(&other.tracks);
    }
}
