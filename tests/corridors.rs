//! Real corridors: furniture, doors, a view of 255° and a range of 5.6 m.

use std::collections::BTreeMap;

use crate::program::{column, real_recording, results_of};

/// Labelled scans whose count is wrong. In this one the fourth wall is some 5° outside the view: it has no return.
const WRONG: [(&str, usize); 1] = [("corridor_cross.mcap", 448)];
/// Counts that differ from the majority of the five before and after, in % of the revolutions of each recording.
const MOST_FLICKER_PERCENT: [(&str, f64); 4] = [
    ("corridor_cross.mcap", 4.4),
    ("corridor_threeway.mcap", 12.1),
    ("corridor_dead.mcap", 6.7),
    ("corridor_left.mcap", 7.2),
];

#[test]
fn labelled_scans_of_real_corridors_are_counted_as_a_person_does_but_for_those_named() {
    let Some(labels) = real_recording("labels.csv") else { return };
    let labels = std::fs::read_to_string(labels).expect("readable");
    let mut counts: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    let mut wrong = Vec::new();
    for row in labels.lines().skip(1) {
        let [file, scan, walls] = row.split(',').collect::<Vec<_>>()[..] else { panic!("not a label: {row}") };
        let Some(recording) = real_recording(file) else { return };
        let counts = counts
            .entry(file.to_owned())
            .or_insert_with(|| column(&results_of(&recording, &["--preset", "default"]).1, "junctions"));
        let (scan, walls): (usize, u64) = (scan.parse().expect("a number"), walls.parse().expect("a number"));
        println!("{file} {scan}: a person sees {walls}, counted {}", counts[scan]);
        if counts[scan] != walls {
            wrong.push((file.to_owned(), scan));
        }
    }
    assert_eq!(wrong, WRONG.map(|(file, scan)| (file.to_owned(), scan)));
}

#[test]
fn counts_along_real_corridors_do_not_flicker_more_than_stated() {
    for (file, most_percent) in MOST_FLICKER_PERCENT {
        let Some(recording) = real_recording(file) else { return };
        let counts = column(&results_of(&recording, &["--preset", "default"]).1, "junctions");
        let percent = 100.0 * flickers(&counts) as f64 / counts.len() as f64;
        println!("{file}: {percent:.1} % of {} revolutions", counts.len());
        assert!(percent <= most_percent, "{file}: {percent:.1} %");
    }
}

/// How many counts differ from the one that more than half of their neighbours have, five on either side.
pub(crate) fn flickers(counts: &[u64]) -> usize {
    let differs = |at: usize| {
        let around = at.saturating_sub(5)..(at + 6).min(counts.len());
        let neighbours: Vec<u64> = around.filter(|&other| other != at).map(|other| counts[other]).collect();
        let same = |count: u64| neighbours.iter().filter(|&&other| other == count).count();
        neighbours.iter().any(|&count| count != counts[at] && 2 * same(count) > neighbours.len())
    };
    (0..counts.len()).filter(|&at| differs(at)).count()
}
