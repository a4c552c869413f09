//! The gaps that an affinity judged.

use crosscut_stage::{Frame, Verdict};

/// A gap that an affinity judged.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// What was decided.
    pub verdict: &'a Verdict,
    /// The walls of the returns on both sides.
    pub walls: [Option<u32>; 2],
    /// How far these returns are apart, metres.
    pub gap_m: Option<f64>,
}

impl Judged<'_> {
    /// The distance of its room from what an opening needs: the natural logarithm of their ratio, without its sign.
    pub(crate) fn doubt(&self) -> f64 {
        self.verdict.room_ratio.ln().abs()
    }
}

/// The gaps that the affinity of a finished frame judged, those closest to the threshold first.
pub fn judged(frame: &Frame) -> Vec<Judged<'_>> {
    let judged = frame.affinity.verdicts.iter().map(|verdict| {
        let [a, b] = verdict.returns.map(|i| frame.revolution.points_m.get(i as usize));
        let gap_m = a.zip(b).map(|(a, b)| (a - b).norm());
        let walls = verdict.returns.map(|i| frame.junction.wall_of_return.get(i as usize).copied().flatten());
        Judged { verdict, walls, gap_m }
    });
    let mut judged: Vec<_> = judged.collect();
    judged.sort_by(|a, b| a.doubt().total_cmp(&b.doubt()));
    judged
}
