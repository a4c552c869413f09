//! What is odd about a scan beside the one before it: holes in the stamps, steps back, another sensor.

use crosscut_messages::NS_PER_S;
use crosscut_stage::NoteCode::{N040, N041, N042, N043};
use crosscut_stage::{Notes, Revolution};

/// A stamp after a hole is later than the one before by more than this.
const GAP_NS: u64 = 1_000_000_000;
/// A stamp after a hole is later by more than this many times the usual interval as well.
const GAP_TIMES: u64 = 5;

/// Compares each scan with the one before it.
#[derive(Debug, Default)]
pub struct Before {
    scan: Option<Previous>,
}

/// What the scan before said.
#[derive(Debug)]
struct Previous {
    stamp_ns: u64,
    /// From a stamp to the next, the last time that they differed and nothing was missing.
    usual_ns: Option<u64>,
    frame_id: String,
}

impl Before {
    /// Notes what is odd about `revolution`, which is the scan before from now on.
    pub fn compare(&mut self, revolution: &Revolution, notes: &mut Notes) {
        let Some(previous) = &mut self.scan else {
            let (stamp_ns, frame_id) = (revolution.stamp_ns, revolution.frame_id.clone());
            self.scan = Some(Previous { stamp_ns, usual_ns: None, frame_id });
            return;
        };
        if revolution.stamp_ns == previous.stamp_ns {
            notes.add(N040, "the stamp is that of the scan before");
        } else if revolution.stamp_ns < previous.stamp_ns {
            let back = seconds(previous.stamp_ns, revolution.stamp_ns);
            notes.add(N041, format!("the stamp is {back} before that of the scan before"));
        }
        let interval_ns = revolution.stamp_ns.checked_sub(previous.stamp_ns).filter(|&ns| ns > 0);
        let is_gap = |usual_ns: u64| interval_ns.is_some_and(|ns| ns > GAP_NS && ns / GAP_TIMES > usual_ns);
        if previous.usual_ns.is_some_and(is_gap) {
            let on = seconds(revolution.stamp_ns, previous.stamp_ns);
            notes.add(N042, format!("the stamp is {on} after that of the scan before"));
        } else {
            previous.usual_ns = interval_ns.or(previous.usual_ns);
        }
        previous.stamp_ns = revolution.stamp_ns;
        if revolution.frame_id != previous.frame_id {
            notes.add(
                N043,
                format!(
                    "frame_id `{}` after `{}`; of several sensors on a topic ingest.frame_id takes one",
                    revolution.frame_id, previous.frame_id
                ),
            );
            previous.frame_id.clone_from(&revolution.frame_id);
        }
    }
}

/// The time from `earlier_ns` to `later_ns` in words.
fn seconds(later_ns: u64, earlier_ns: u64) -> String {
    format!("{:.3} s", later_ns.saturating_sub(earlier_ns) as f64 / NS_PER_S)
}
