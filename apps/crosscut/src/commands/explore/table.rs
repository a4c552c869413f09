//! Many missions, a line for each family.

use comfy_table::{CellAlignment, Table, presets};
use crosscut_missions::Flown;

use super::Job;

/// The table.
pub(super) fn table(missions: &[(&Job, &Flown)]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header([
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
    ]);
    let mut names: Vec<&str> = Vec::new();
    for (job, _) in missions {
        if !names.contains(&job.name.as_str()) {
            names.push(&job.name);
        }
    }
    for name in &names {
        let of: Vec<&Flown> = missions.iter().filter(|(job, _)| job.name == **name).map(|(_, flown)| *flown).collect();
        table.add_row(row(name, &of));
    }
    if names.len() > 1 {
        table.add_row(row("all", &missions.iter().map(|(_, flown)| *flown).collect::<Vec<_>>()));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let lines: Vec<String> = table.to_string().lines().map(|line| line.trim_end().to_owned()).collect();
    lines.join("\n")
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
