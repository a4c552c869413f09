//! What the views have to show.

use crosscut_stage::Frame;
use rerun::{RecordingStream, RecordingStreamResult, Tensor};

use crate::beam_order::BeamOrder;
use crate::schema::EXTENT;
use crate::tensors::f64_vector;

/// What the views have to show: taken from the first revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Farthest distance that the views show, metres.
    pub(crate) range_m: f64,
    /// Places along the side of the pictures.
    pub(crate) places: usize,
    /// The affinity decides gap by gap: its gaps are shown before the eigenvalues.
    pub(crate) by_gaps: bool,
    /// The flight has its truth.
    pub(crate) has_truth: bool,
    /// The distance at which directions around a cloud are cut, metres: cloud and sphere take the places of returns and ranges. 0
    /// where no ways on of clouds are counted.
    pub(crate) ways_m: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { range_m: 15.0, places: 360, by_gaps: false, has_truth: false, ways_m: 0.0 }
    }
}

/// No lidar sees farther. A return beyond this is an error of the sensor and does not widen the views.
const FARTHEST_RETURN_M: f64 = 1000.0;

impl Extent {
    /// The sensor's range, but at most twice the distance of its farthest return; and the number of its beams.
    pub(crate) fn of(frame: &Frame) -> Self {
        let (default, revolution) = (Self::default(), &frame.revolution);
        let ranges_m = (0..revolution.len()).map(|i| revolution.range_m(i));
        let farthest_m = ranges_m.filter(|range_m| *range_m <= FARTHEST_RETURN_M).fold(0.0, f64::max);
        let seen_m = if farthest_m > 0.0 { 2.0 * farthest_m } else { default.range_m };
        let limit_m = revolution.beams().map(|sweep| sweep.range_max_m).filter(|limit| *limit > 0.0);
        let places = BeamOrder::of(frame).used;
        Self {
            range_m: limit_m.unwrap_or(f64::INFINITY).min(seen_m),
            places: if places > 0 { places } else { default.places },
            by_gaps: !frame.affinity.verdicts.is_empty(),
            has_truth: default.has_truth,
            ways_m: frame
                .affinity
                .dual
                .as_ref()
                .filter(|_| !revolution.cloud_m.is_empty())
                .map_or(0.0, |dual| dual.cut_m),
        }
    }

    /// What changes the layout.
    pub(crate) fn asks(self) -> (usize, [bool; 2]) {
        (self.places, [self.by_gaps, self.has_ways()])
    }

    /// Whether ways on of clouds are counted.
    pub(crate) fn has_ways(self) -> bool {
        self.ways_m > 0.0
    }

    /// Records the extent, so that the recording can be laid out again.
    pub(crate) fn log(self, rec: &RecordingStream) -> RecordingStreamResult<()> {
        let [by_gaps, has_truth] = [self.by_gaps, self.has_truth].map(|is_so| f64::from(u8::from(is_so)));
        let values = vec![self.range_m, self.places as f64, by_gaps, has_truth, self.ways_m];
        rec.log_static(EXTENT.path, &Tensor::new(f64_vector(values, EXTENT.dims)))
    }

    /// The extent that was recorded as these values.
    pub(crate) fn of_values(values: &[f64]) -> Option<Self> {
        let [range_m, places, ..] = values else { return None };
        let ways_m = values.get(4).copied().unwrap_or(0.0);
        let [by_gaps, has_truth] = [2, 3].map(|at| values.get(at).is_some_and(|value| *value > 0.0));
        Some(Self { range_m: *range_m, places: *places as usize, by_gaps, has_truth, ways_m })
    }
}

/// One of two flights.
pub(crate) struct Side<'a> {
    /// The entity that all its entities stand below.
    pub(crate) below: &'a str,
    /// Its name in titles.
    pub(crate) name: &'a str,
    pub(crate) extent: Extent,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    #[test]
    fn an_impossible_range_does_not_widen_the_views() {
        let range_m = |ranges_m: &[f64]| {
            let mut frame = Frame::default();
            frame.revolution.points_m = ranges_m.iter().map(|&range_m| Point::new(range_m, 0.0, 0.0)).collect();
            Extent::of(&frame).range_m
        };
        assert_eq!(range_m(&[3.0, 40.0]), 80.0);
        for wild in [2e9, 1e30, f64::MAX, f64::INFINITY, f64::NAN] {
            assert_eq!(range_m(&[3.0, wild, 40.0]), 80.0, "{wild}");
            assert_eq!(range_m(&[wild]), Extent::default().range_m, "{wild}");
        }
    }
}
