//! What became of a mission, for programs and for people.

use crosscut_missions::Flown;
use crosscut_stage::counted;
use serde_json::{Value, json};

use super::job::Job;
use crate::output::maps;

/// The outcome with the map.
pub(super) fn whole(job: &Job, flown: &Flown) -> Value {
    let mut outcome = figures(job, flown);
    outcome["map"] = maps::json(&flown.map);
    outcome
}

/// The outcome without the map.
pub(super) fn figures(job: &Job, flown: &Flown) -> Value {
    let missed_m: Vec<[f64; 2]> = flown.missed_m.iter().map(|place_m| [place_m.x, place_m.y]).collect();
    json!({
        "mission": job.name,
        "seed": job.seed,
        "success": flown.is_success(),
        "ways": flown.ways,
        "ways_visited": flown.ways_visited,
        "missed_m": missed_m,
        "entered_in_vain": flown.entered_in_vain,
        "home": flown.home,
        "crashes": flown.crashes,
        "way_m": flown.way_m,
        "offline_m": flown.offline_m,
        "offline_is_exact": flown.offline_is_exact,
        "depth_first_m": flown.depth_first_m,
        "revolutions": flown.revolutions,
        "decisions": flown.decisions,
        "decisions_on_wrong_count": flown.decisions_on_wrong_count,
        "end": end(flown),
    })
}

fn end(flown: &Flown) -> &'static str {
    match (&flown.failure, flown.end) {
        (Some(_), _) => "failed",
        (None, Some(end)) => end.name(),
        (None, None) => "stopped",
    }
}

/// What a navigator that gave up would need to go on.
fn needed(flown: &Flown) -> String {
    match (flown.map.nodes.len(), flown.map.ways_not_taken()) {
        (0, _) => "a junction or a dead end, of which it saw none".to_owned(),
        (_, 0) => "a way that it has not taken, or one home".to_owned(),
        (_, open) => format!("a route over the map to {} not taken", counted(open as u64, "way")),
    }
}

/// The outcome in four lines: what became of the mission, what it would have taken, the map, and the times.
pub(super) fn words(flown: &Flown) -> String {
    let [became, least, map] = parts(flown);
    let [median_ms, slow_ms] = [0.5, 0.99].map(|share| flown.loop_ms(share));
    format!(
        "{became}\n{least}\n{map}\nfrom scan to command: {median_ms:.1} ms (median), {slow_ms:.1} ms (99 of 100 are faster)"
    )
}

/// The printed outcome, in Markdown, without the times: another run would not repeat them.
#[cfg_attr(not(feature = "rerun"), allow(dead_code))] // recordings need the feature
pub(super) fn markdown(flown: &Flown) -> String {
    let [became, least, map] = parts(flown);
    let failure = flown.failure.as_ref().map_or_else(String::new, |failure| format!("\n\nIt failed: {failure}"));
    format!("**{became}.**\n\nMap: {map}.\n\nFor comparison, {least}.{failure}")
}

fn parts(flown: &Flown) -> [String; 3] {
    let home = if flown.home { "home again" } else { "not home" };
    let crashes = match flown.crashes {
        0 => "no crash".to_owned(),
        1 => "1 crash".to_owned(),
        several => format!("{several} crashes"),
    };
    let why = match flown.end.map(crosscut_navigate::MissionEnd::name) {
        Some("stuck") => "; it could not get on".to_owned(),
        Some("gave_up") => format!("; it found nothing new for too long: it would need {}", needed(flown)),
        None => "; it was stopped".to_owned(),
        _ => String::new(),
    };
    let bound = if flown.offline_is_exact { "" } else { "at most " };
    let became = format!(
        "{} of {} visited, {home}, {crashes}{why}; {:.0} m flown in {}",
        flown.ways_visited,
        counted(flown.ways as u64, "way"),
        flown.way_m,
        counted(flown.revolutions, "revolution"),
    );
    let least = format!(
        "with the plan, along the middle of its passages: {bound}{:.0} m by the shortest tour, {:.0} m depth-first",
        flown.offline_m, flown.depth_first_m
    );
    [became, least, flown.map.summary()]
}
