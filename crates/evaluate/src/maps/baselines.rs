//! Plain ways to count junctions on a flight, to compare a map with.

use super::WhereAt;

/// A stay at one count, or at one place: its first and last stamp, and where the vehicle was in its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stay {
    /// First and last stamp.
    pub time_ns: [u64; 2],
    /// Position of its middle revolution by the pose of the flight, metres.
    pub position_m: [f64; 2],
}

/// Collects stays from the revolutions of a flight: runs of one count other than that of a passage.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// The count that holds, and the revolutions since it does.
    open: Option<(usize, Vec<WhereAt>)>,
    stays: Vec<Stay>,
}

impl Counts {
    /// Adds a revolution with its number of ways, and where it was taken by its pose.
    pub fn add(&mut self, ways: usize, here: WhereAt) {
        match &mut self.open {
            Some((count, at)) if *count == ways => {
                if ways != 2 {
                    at.push(here);
                }
            }
            _ => {
                self.end();
                self.open = Some((ways, vec![here]));
            }
        }
    }

    fn end(&mut self) {
        if let Some((ways, at)) = self.open.take()
            && ways != 2
        {
            let (from, to) = (at[0], at[at.len() - 1]);
            self.stays.push(Stay { time_ns: [from.stamp_ns, to.stamp_ns], position_m: at[at.len() / 2].position_m });
        }
    }

    /// The stays, in order.
    pub fn stays(mut self) -> Vec<Stay> {
        self.end();
        self.stays
    }
}

/// Every stay is a new node.
pub fn every_change(stays: &[Stay]) -> Vec<Vec<[u64; 2]>> {
    stays.iter().map(|stay| vec![stay.time_ns]).collect()
}

/// Stays within a radius of the first one of a node are to this node.
pub fn within_radius(stays: &[Stay], radius_m: f64) -> Vec<Vec<[u64; 2]>> {
    let mut nodes: Vec<([f64; 2], Vec<[u64; 2]>)> = Vec::new();
    for stay in stays {
        let apart_m = |at: &[f64; 2]| (at[0] - stay.position_m[0]).hypot(at[1] - stay.position_m[1]);
        let nearest = nodes.iter_mut().min_by(|a, b| apart_m(&a.0).total_cmp(&apart_m(&b.0)));
        match nearest.filter(|node| apart_m(&node.0) < radius_m) {
            Some((_, visits)) => visits.push(stay.time_ns),
            None => nodes.push((stay.position_m, vec![stay.time_ns])),
        }
    }
    nodes.into_iter().map(|(_, visits)| visits).collect()
}
