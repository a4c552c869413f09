//! Truths and answers made from labels.

use crosscut_messages::Truth;
use crosscut_report::{ResultsLine, WallLine};
use crosscut_stage::{KnownGaps, Wall};

/// A truth with these labels; its first `islands` walls are islands.
pub(crate) fn truth(labels: &[i32], islands: u32) -> Truth {
    let walls = labels.iter().max().map_or(0, |&last| (last + 1).max(0) as u32);
    Truth { walls: walls - islands, islands, labels: labels.to_vec(), ..Truth::default() }
}

/// An answer with these labels; the walls in `islands` are reported as islands.
pub(crate) fn answer(labels: &[i32], islands: &[u32]) -> ResultsLine {
    let mut ids: Vec<i32> = labels.iter().copied().filter(|&label| label >= 0).collect();
    ids.sort_unstable();
    ids.dedup();
    let walls: Vec<_> = ids
        .iter()
        .map(|&id| {
            let (id, returns) = (id as u32, labels.iter().filter(|&&label| label == id).count());
            let island = islands.contains(&id);
            let wall = Wall { id, returns, bearing_rad: [0.0; 2], island };
            WallLine { wall, nearest_m: None, nearest_rad: None }
        })
        .collect();
    ResultsLine {
        gaps: KnownGaps::default(),
        holds_for_width_m: None,
        ways: None,
        ways_flyer: None,
        ways_ground: None,
        ways_view_rad: None,
        seq: 0,
        stamp_ns: 0,
        returns: labels.iter().filter(|&&label| label != -1).count(),
        junctions: walls.iter().filter(|of| !of.wall.island).count(),
        k: walls.len(),
        margin: None,
        confidence: Some(0.5),
        place: String::new(),
        eigenvalues: Vec::new(),
        walls,
        openings: Vec::new(),
        here: None,
        steady: None,
        pose: None,
        labels: labels.to_vec(),
        notes: Vec::new(),
    }
}
