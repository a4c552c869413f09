//! Many missions, a line for each family.

use crosscut_evaluate::tables::Table;
use crosscut_missions::Flown;

use super::job::Job;
use crate::output::typeset::plain;

/// The table.
pub(super) fn table(missions: &[(&Job, &Flown)]) -> String {
    let header = [
        "mission",
        "flown",
        "success %",
        "ways %",
        "home %",
        "crashes",
        "in vain",
        "way / least",
        "way / depth-first",
        "wrong count %",
    ];
    let mut names: Vec<&str> = Vec::new();
    for (job, _) in missions {
        if !names.contains(&job.name.as_str()) {
            names.push(&job.name);
        }
    }
    let of = |name: &str| -> Vec<&Flown> {
        missions.iter().filter(|(job, _)| job.name == name).map(|(_, flown)| *flown).collect()
    };
    let mut rows: Vec<_> = names.iter().map(|name| row(name, &of(name))).collect();
    if names.len() > 1 {
        rows.push(row("all", &missions.iter().map(|(_, flown)| *flown).collect::<Vec<_>>()));
    }
    plain(&Table { title: String::new(), header: header.map(str::to_owned).to_vec(), rows }) + "\n"
}

fn row(name: &str, of: &[&Flown]) -> Vec<String> {
    let sum = |value: fn(&Flown) -> f64| of.iter().map(|flown| value(flown)).sum::<f64>();
    let count = of.len() as f64;
    let percent = |part: f64, whole: f64| format!("{:.1}", 100.0 * part / whole.max(1.0));
    vec![
        name.to_owned(),
        of.len().to_string(),
        percent(sum(|flown| f64::from(u8::from(flown.is_success()))), count),
        percent(sum(|flown| flown.ways_visited as f64), sum(|flown| flown.ways as f64)),
        percent(sum(|flown| f64::from(u8::from(flown.home))), count),
        sum(|flown| f64::from(flown.crashes)).to_string(),
        sum(|flown| f64::from(flown.entered_in_vain)).to_string(),
        format!("{:.2}", sum(|flown| flown.way_m) / sum(|flown| flown.offline_m)),
        format!("{:.2}", sum(|flown| flown.way_m) / sum(|flown| flown.depth_first_m)),
        percent(sum(|flown| f64::from(flown.decisions_on_wrong_count)), sum(|flown| f64::from(flown.decisions))),
    ]
}
