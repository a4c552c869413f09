//! Where two flights that are shown side by side differ: lines, a strip, a list and a summary; and the second one in the colours of
//! the first: each wall in that of the wall that shares the most beams.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crosscut_rrd::{Latest, Recording, Value};
use crosscut_stage::Wall;
use rerun::external::re_log_types::StoreId;
use rerun::log::LogMsg;
use rerun::{
    MediaType, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, Scalars, SeriesLines, StateChange,
    StateConfiguration, TextDocument, TextLog, TextLogLevel,
};

use super::RIGHT;
use super::error::ShowError;
use crate::RecorderError;
use crate::colors::{NO_WALL, REPORTED, TRUTH, ZEROS, as_others, color, name_of};
use crate::layout::differs::{DIFFERS, DIFFERS_CONFIDENCE, DIFFERS_LOG, DIFFERS_SUMMARY, DIFFERS_WALLS};
use crate::schema::{
    AFFINITY_DEGREES, COLORS, Entity, KMEANS_LABELS, REPORT_CONFIDENCE, REPORT_JUNCTIONS, REPORT_LABELS,
    REPORT_SUMMARY, REPORT_WALLS, REPORT_WHY, SCAN_COUNT, SPECTRAL_K, TRUTH_WALLS,
};
use crate::tracks::LastSeen;
use crate::walls::Walls;
use crate::why::source_in;

/// The summary names this many settings at most.
const SHOWN_SETTINGS: usize = 4;
/// A preset's name is a title up to this many letters.
const SHORT: usize = 24;
/// The stages before the report, in their order: what each made, and what tells whether two made the same.
const MADE: [([&str; 2], Entity); 4] = [
    (["ingest", "returns"], SCAN_COUNT),
    (["affinity", "W"], AFFINITY_DEGREES),
    (["spectral", "k"], SPECTRAL_K),
    (["kmeans", "clusters"], KMEANS_LABELS),
];
/// Texts that name the colours of walls.
const TEXTS: [Entity; 2] = [REPORT_WHY, REPORT_SUMMARY];

/// What is not shown of the second flight as it was recorded, because it has other colours.
pub(super) fn is_recolored(entity: &str) -> bool {
    entity == COLORS.path || TEXTS.iter().any(|text| text.path == entity)
}

/// What two flights are called in titles: their presets where these tell them apart, else their files.
pub(super) fn titles(files: &[String; 2], recordings: [&Recording; 2]) -> [String; 2] {
    let preset = |recording: &Recording| {
        let first = recording.rows(REPORT_WHY.path).ok()?.next()?.ok()?;
        let text = text_of(&first.value(REPORT_WHY.values).ok()?)?;
        Some(source_in(&text)?.split_once(", preset ")?.1.to_owned())
    };
    match recordings.map(preset) {
        [Some(a), Some(b)] if a != b && a.len() <= SHORT && b.len() <= SHORT => [a, b],
        _ => files.clone(),
    }
}

/// The values of a recording at one revolution after the other.
struct Values<'a>(&'a Recording, BTreeMap<&'static str, Latest<'a>>);

impl<'a> Values<'a> {
    fn latest(&mut self, entity: Entity) -> &mut Latest<'a> {
        self.1.entry(entity.path).or_insert_with(|| self.0.latest(entity))
    }

    /// What was logged at this revolution; none where it cannot be read.
    fn at(&mut self, entity: Entity, seq: i64) -> Option<Value> {
        self.latest(entity).only_at(seq).ok().flatten().cloned()
    }

    fn number(&mut self, entity: Entity, seq: i64) -> Option<f64> {
        self.at(entity, seq)?.to_f64().first().copied()
    }

    fn text(&mut self, entity: Entity, seq: i64) -> String {
        self.at(entity, seq).as_ref().and_then(text_of).unwrap_or_default()
    }

    /// The true number of walls that was told last.
    fn truth(&mut self, seq: i64) -> Option<f64> {
        self.latest(TRUTH_WALLS).at(seq).ok().flatten()?.to_f64().first().copied()
    }

    /// The wall of each beam, or return, of so many walls.
    fn places(&mut self, seq: i64, walls: usize) -> Vec<Option<u32>> {
        let labels = self.at(REPORT_LABELS, seq).map_or_else(Vec::new, |value| value.to_f64());
        labels.into_iter().map(|label| (0.0..walls as f64).contains(&label).then_some(label as u32)).collect()
    }

    /// The walls, and the class of each.
    fn walls(&mut self, seq: i64) -> (Vec<Wall>, Vec<u16>) {
        let rows = self.at(REPORT_WALLS, seq).map_or_else(Vec::new, |value| value.to_f64());
        let wall = |row: &[f64]| {
            let [id, returns, from_rad, to_rad, island, class]: [f64; 6] = row.try_into().unwrap_or_default();
            let bearing_rad = [from_rad, to_rad];
            (Wall { id: id as u32, returns: returns as usize, bearing_rad, island: island > 0.0 }, class as u16)
        };
        rows.chunks_exact(6).map(wall).unzip()
    }
}

fn text_of(value: &Value) -> Option<String> {
    if let Value::Texts(texts) = value { texts.first().cloned() } else { None }
}

/// A revolution that both flights have.
struct Both {
    seq: i64,
    stamp_ns: i64,
    walls: [f64; 2],
    confidence: [f64; 2],
    truth: Option<f64>,
    /// Of walls that differ: the first stage that made something else, and of what; and why they differ, in words.
    from: Option<[&'static str; 2]>,
    here: String,
    has_other_k: bool,
}

impl Both {
    fn counts_differ(&self) -> bool {
        self.walls[0] != self.walls[1]
    }

    /// Whether it differs in the same way.
    fn is_like(&self, other: &Self) -> bool {
        self.walls == other.walls && self.truth == other.truth && self.from == other.from
    }

    /// "3 | 4", in the strip.
    fn state(&self) -> String {
        let [a, b] = self.walls;
        match self.from {
            None => SAME.to_owned(),
            Some(_) => format!("{a} | {b}{}", if a == b { ", grouped otherwise" } else { "" }),
        }
    }
}

/// "95 to 99: paper 4 walls, default 3; truth 3: paper is wrong; from W on", of revolutions that differ in the same way.
fn stretch(of: &[Both], [a, b]: &[String; 2]) -> Option<String> {
    let (Both { seq, walls: [of_a, of_b], truth, from, .. }, last) = (of.first()?, of.last()?.seq);
    let [_, from] = (*from)?;
    let span = if *seq == last { format!("{seq}") } else { format!("{seq} to {last}") };
    if of_a == of_b {
        return Some(format!("{span}: both {of_a} walls, grouped otherwise; from {from} on"));
    }
    let wrong = |truth: f64| match (*of_a == truth, *of_b == truth) {
        (true, false) => format!("{b} is wrong"),
        (false, true) => format!("{a} is wrong"),
        _ => "both are wrong".to_owned(),
    };
    let truth = truth.map_or_else(String::new, |truth| format!("; truth {truth}: {}", wrong(truth)));
    Some(format!("{span}: {a} {of_a} walls, {b} {of_b}{truth}; from {from} on"))
}

/// The entities of the page that shows what differs, and those of the second flight that name or show colours.
pub(super) fn messages(
    store: &StoreId,
    names: &[String; 2],
    files: &[String; 2],
    recordings: [&Recording; 2],
) -> Result<Vec<LogMsg>, ShowError> {
    let scratch = RecordingStreamBuilder::from_store_id(store).send_properties(false).memory();
    let (rec, storage) = scratch.map_err(RecorderError::from)?;
    let both = compared(&rec, names, recordings)?;
    let summary = summary(names, files, recordings, &both);
    log(&rec, names, &both, &summary).map_err(RecorderError::from)?;
    let mut messages = storage.take();
    messages.retain(|message| matches!(message, LogMsg::ArrowMsg(..)));
    Ok(messages)
}

/// The revolutions that both flights have. On the way, the second one is logged in the colours of the first.
fn compared(rec: &RecordingStream, names: &[String; 2], recordings: [&Recording; 2]) -> Result<Vec<Both>, ShowError> {
    let [mut a, mut b] = recordings.map(|recording| Values(recording, BTreeMap::new()));
    let (mut compared, mut context) = (Vec::new(), None);
    for row in recordings[1].rows(REPORT_JUNCTIONS.path)? {
        let Ok(row) = row else { continue }; // the damage is told elsewhere
        let (seq, stamp_ns) = (row.revolution, row.stamp_ns.unwrap_or(0));
        set_time(rec, seq, stamp_ns);
        let (walls, classes) = a.walls(seq);
        let left = Walls::new(&a.places(seq, walls.len()), &walls, |id| class_of(&classes, id));
        let (walls, before) = b.walls(seq);
        let places = b.places(seq, walls.len());
        let classes = LastSeen(left.seen.clone()).match_walls(&places, walls.len());
        let right = Walls::new(&places, &walls, |id| class_of(&classes, id));
        let texts = [a.text(REPORT_WHY, seq), b.text(REPORT_WHY, seq)];
        let recolored: Vec<[u16; 2]> = before.into_iter().zip(classes).map(|(old, new)| [old, new]).collect();
        for (entity, text) in TEXTS.iter().zip([&texts[1], &b.text(REPORT_SUMMARY, seq)]) {
            let text = TextDocument::from_markdown(renamed(text, &recolored));
            rec.log(format!("{RIGHT}{}", entity.path), &text).map_err(RecorderError::from)?;
        }
        if context.as_ref() != Some(&recolored) {
            rec.log(RIGHT, &as_others(&recolored)).map_err(RecorderError::from)?;
            context = Some(recolored);
        }
        let counts = [&mut a, &mut b].map(|of| of.number(REPORT_JUNCTIONS, seq));
        let [Some(of_a), Some(of_b)] = counts else { continue };
        let (mut from, mut here, mut has_other_k) = (None, String::new(), false);
        if of_a != of_b || !left.is_as(&right) {
            let made = MADE.map(|(stage, entity)| (stage, is_other([&mut a, &mut b].map(|of| made(of, entity, seq)))));
            from = Some(made.iter().find(|(_, is_other)| *is_other).map_or(["report", "walls"], |(stage, _)| *stage));
            has_other_k = made[2].1;
            here = why_differ([&left, &right], names, &texts);
        }
        let confidence = [&mut a, &mut b].map(|of| of.number(REPORT_CONFIDENCE, seq).unwrap_or(f64::NAN));
        let truth = a.truth(seq).or_else(|| b.truth(seq));
        compared.push(Both { seq, stamp_ns, walls: [of_a, of_b], confidence, truth, from, here, has_other_k });
    }
    Ok(compared)
}

fn class_of(classes: &[u16], id: u32) -> u16 {
    classes.get(id as usize).copied().unwrap_or(NO_WALL)
}

/// What a stage made; clusters in the order in which they first appear, so that the same ones have the same numbers.
fn made(of: &mut Values, entity: Entity, seq: i64) -> Option<Vec<f64>> {
    let mut numbers = of.at(entity, seq)?.to_f64();
    if entity == KMEANS_LABELS {
        let mut new = BTreeMap::new();
        for label in numbers.iter_mut().filter(|label| **label >= 0.0) {
            let next = new.len() as f64;
            *label = *new.entry(*label as u32).or_insert(next);
        }
    }
    Some(numbers)
}

/// Whether a stage made something else. What either does not have counts as the same.
fn is_other([a, b]: [Option<Vec<f64>>; 2]) -> bool {
    a.zip(b).is_some_and(|(a, b)| a != b)
}

/// Why the walls of a revolution differ: which count in one flight alone, and by which edge they are part of another wall there.
fn why_differ(walls: [&Walls; 2], names: &[String; 2], texts: &[String; 2]) -> String {
    let alone = [[0, 1], [1, 0]].into_iter().flat_map(|[own, other]| {
        let is = format!("is counted by {} alone; by {} it is", names[own], names[other]);
        let told = move |of: crate::walls::Alone| {
            let is_in = |beam: usize| walls[own].seen.get(beam) == Some(&Some(of.class));
            let edge = of.part_of.and_then(|wall| weakest_edge(&texts[other], wall));
            let edge = edge.filter(|(_, [i, j])| is_in(*i) != is_in(*j));
            of.words + &edge.map_or_else(String::new, |(edge, _)| format!(", whose weakest edge is {edge}"))
        };
        walls[own].alone(walls[other], &is).into_iter().map(told)
    });
    let alone: Vec<String> = alone.collect();
    if alone.is_empty() { walls[0].most_other(walls[1], names).unwrap_or_default() } else { alone.join("; ") }
}

/// The weakest edge of a wall in words, and its beams, by the line "- **wall 3 (blue)**, 2 returns: weakest edge inside 4.4e-3 (beams 341,
/// 342: 1.90 m); ..." of `/report/why`.
fn weakest_edge(text: &str, wall: u32) -> Option<(&str, [usize; 2])> {
    let line = text.lines().find(|line| line.starts_with(&format!("- **wall {wall} (")))?;
    let edge = line.split_once("weakest edge inside ")?.1.split_once(';')?.0;
    let (i, j) = edge.split_once("beams ")?.1.split_once(':')?.0.split_once(", ")?;
    Some((edge, [i.parse().ok()?, j.parse().ok()?]))
}

/// The text with the new name of each colour in "3 (vermilion)" and "| 3 | vermilion |".
fn renamed(text: &str, recolored: &[[u16; 2]]) -> String {
    let names: BTreeMap<&str, &str> = recolored.iter().map(|[old, new]| (name_of(*old), name_of(*new))).collect();
    let ends = |c: char| matches!(c, '(' | ')' | '|');
    let mut before = "";
    let parts = text.split_inclusive(ends).map(|part| {
        let word = part.trim_end_matches(ends);
        let name = word.trim();
        let is_of_wall = part.ends_with(if before.ends_with('(') { ')' } else { '|' }) && !before.is_empty();
        before = part;
        names.get(name).filter(|_| is_of_wall).map_or_else(|| part.to_owned(), |new| part.replacen(name, new, 1))
    });
    parts.collect()
}

fn set_time(rec: &RecordingStream, seq: i64, stamp_ns: i64) {
    rec.set_time_sequence("revolution", seq);
    rec.set_timestamp_nanos_since_epoch("stamp", stamp_ns);
}

/// The lines, the strip, the words and the list.
fn log(rec: &RecordingStream, names: &[String; 2], both: &[Both], summary: &str) -> RecordingStreamResult<()> {
    let never = if both.is_empty() { TextDocument::new(summary) } else { TextDocument::update_fields() };
    rec.log_static(DIFFERS_SUMMARY, &never.with_media_type(MediaType::MARKDOWN))?;
    log_looks(rec, names)?;
    let (mut before, mut said) = (None, None);
    for of in both {
        set_time(rec, of.seq, of.stamp_ns);
        let [a, b] = of.walls;
        rec.log(DIFFERS_WALLS, &Scalars::new([a, b, of.truth.unwrap_or(f64::NAN)]))?;
        rec.log(DIFFERS_CONFIDENCE, &Scalars::new(of.confidence))?;
        if before.replace(of.state()) != Some(of.state()) {
            rec.log(DIFFERS, &StateChange::single(of.state()))?;
        }
        if said.replace(&of.here) != Some(&of.here) {
            let here = if of.here.is_empty() { String::new() } else { format!("**Here: {}.**\n\n", of.here) };
            rec.log(DIFFERS_SUMMARY, &TextDocument::new(here + summary))?;
        }
    }
    for (stretch, first) in both.chunk_by(Both::is_like).filter_map(|of| Some((stretch(of, names)?, of.first()?))) {
        set_time(rec, first.seq, first.stamp_ns);
        rec.log(DIFFERS_LOG, &TextLog::new(stretch).with_level(TextLogLevel::WARN))?;
    }
    Ok(())
}

/// The state where both counts are the same.
const SAME: &str = "same";

fn log_looks(rec: &RecordingStream, [a, b]: &[String; 2]) -> RecordingStreamResult<()> {
    let lines = |colors: &[u32], names: &[&str]| {
        let widths = [4.0, 2.0, 1.0];
        SeriesLines::new()
            .with_names(names.iter().copied())
            .with_colors(colors.iter().map(|rgba| color(*rgba)))
            .with_widths(widths[..names.len()].iter().copied())
            .with_interpolation_mode(rerun::components::InterpolationMode::StepAfter)
    };
    rec.log_static(DIFFERS_WALLS, &lines(&[REPORTED, ZEROS, TRUTH], &[a.as_str(), b, "truth"]))?;
    rec.log_static(DIFFERS_CONFIDENCE, &lines(&[REPORTED, ZEROS], &[a.as_str(), b]))?;
    let same = StateConfiguration::new().with_values([SAME]).with_colors([color(0x4A4A_4AFF)]);
    rec.log_static(DIFFERS, &same)
}

/// "They part at affinity (W) in 40, at report (walls) in 16; k is another one in 40.", of revolutions with other counts.
fn parting(differing: &[&Both]) -> String {
    let several = |times: usize| if times == differing.len() { "all".to_owned() } else { times.to_string() };
    let stages = MADE.iter().map(|(stage, _)| *stage).chain([["report", "walls"]]);
    let times = stages.map(|stage| (stage, differing.iter().filter(|of| of.from == Some(stage)).count()));
    let named = times.filter(|(_, times)| *times > 0);
    let named = named.map(|([stage, of], times)| format!("at **{stage}** ({of}) in {}", several(times)));
    let named = named.collect::<Vec<_>>().join(", ");
    let k = match differing.iter().filter(|of| of.has_other_k).count() {
        0 => "the same".to_owned(),
        times => format!("another one in {}", several(times)),
    };
    format!("They part {named}; k is {k}.")
}

/// How often they differ, who is right by the truth, and which settings differ.
fn summary(names: &[String; 2], files: &[String; 2], recordings: [&Recording; 2], both: &[Both]) -> String {
    let ([a, b], [left, right]) = (names, files);
    let differing: Vec<&Both> = both.iter().filter(|of| of.counts_differ()).collect();
    let grouped = both.iter().filter(|of| of.from.is_some()).count() - differing.len();
    let mut text = match (both.len(), differing.len()) {
        (0, _) => "**No revolution is in both recordings.**".to_owned(),
        (common, 0) => format!("**{a} and {b} count the same walls in all {common} revolutions.**"),
        (common, several) => format!("**{a} and {b} differ in {several} of {common} revolutions.**"),
    };
    if differing.iter().any(|of| of.truth.is_some()) {
        let right = |side: usize| differing.iter().filter(|of| Some(of.walls[side]) == of.truth).count();
        let _ = write!(text, " There {a} is right in {}, {b} in {}.", right(0), right(1));
    }
    if grouped > 0 {
        let _ = write!(text, " In {grouped} the count is the same, grouped otherwise.");
    }
    if !differing.is_empty() {
        let _ = write!(text, " {}", parting(&differing));
    }
    let _ = write!(text, " Left: {left}.rrd, right: {right}.rrd.");
    let settings = settings_that_differ(&recordings.map(|recording| recording.config_toml().unwrap_or_default()));
    if !settings.is_empty() {
        let more = settings.len().saturating_sub(SHOWN_SETTINGS);
        let more = if more > 0 { format!(", and {more} more (tab Config)") } else { String::new() };
        let shown = &settings[..settings.len().min(SHOWN_SETTINGS)];
        let _ = write!(text, "\n\nSettings: {}{more}", shown.join(", "));
    }
    text
}

/// "affinity.kind \"rbf\" | \"passage\"" for each setting that both have with other values.
fn settings_that_differ(configs: &[String; 2]) -> Vec<String> {
    let [a, b] = configs.each_ref().map(|toml| settings(toml));
    let of_b = |name: &str| b.iter().find(|(of, _)| of == name).map(|(_, value)| value);
    a.iter()
        .filter_map(|(name, value)| {
            let other = of_b(name).filter(|other| *other != value)?;
            Some(format!("`{name}` {value} | {other}"))
        })
        .collect()
}

/// Names with their sections, and values, of a configuration with a setting a line. A setting that follows another one stands
/// in a comment, with the value that it has.
fn settings(toml: &str) -> Vec<(String, String)> {
    let mut section = "";
    let mut settings = Vec::new();
    for line in toml.lines().map(|line| line.split(" #").next().unwrap_or_default().trim()) {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name;
        } else if let Some((key, value)) = line.strip_prefix("# ").unwrap_or(line).split_once(" = ")
            && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        {
            settings.push((format!("{section}.{key}"), value.trim().to_owned()));
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn revolutions_that_differ_alike_are_one_stretch() {
        let both: Vec<Both> = [[2.0, 2.0], [3.0, 3.0], [4.0, 3.0], [4.0, 3.0], [3.0, 3.0]]
            .into_iter()
            .zip(0..)
            .map(|(walls, seq)| Both {
                seq,
                stamp_ns: 0,
                walls,
                confidence: [0.5; 2],
                truth: Some(3.0),
                from: (walls[0] != walls[1]).then_some(["report", "walls"]),
                here: String::new(),
                has_other_k: false,
            })
            .collect();
        let names = ["a".to_owned(), "b".to_owned()];
        let words: Vec<String> = both.chunk_by(Both::is_like).filter_map(|of| stretch(of, &names)).collect();
        assert_eq!(words, ["2 to 3: a 4 walls, b 3; truth 3: a is wrong; from walls on"]);
        let differing: Vec<&Both> = both.iter().filter(|of| of.counts_differ()).collect();
        assert_eq!(parting(&differing), "They part at **report** (walls) in all; k is the same.");
    }

    #[test]
    fn settings_with_other_values_are_named_with_both() {
        let a = "# crosscut\n[affinity]\nkind = \"rbf\" # or\nsigma = 1\n# passage_m = 0.6  # follows vehicle.width_m\n[report]\nmin = 2\n";
        let b = "[affinity]\n# at most 2 = few\nkind = \"passage\"\npassage_m = 1.2  # --set\n[report]\nmin = 2\n";
        let expected = ["`affinity.kind` \"rbf\" | \"passage\"", "`affinity.passage_m` 0.6 | 1.2"];
        assert_eq!(settings_that_differ(&[a.to_owned(), b.to_owned()]), expected);
    }

    #[test]
    fn the_edge_of_a_wall_is_read_and_colours_of_walls_are_renamed_and_no_other_words() {
        let text = "- **wall 0 (blue)**, 70 returns: weakest edge inside 1.5e-7 (beams 39, 45: 3.30 m); no edge";
        assert_eq!(weakest_edge(text, 0), Some(("1.5e-7 (beams 39, 45: 3.30 m)", [39, 45])));
        assert_eq!(weakest_edge(text, 1), None);
        let text = "if wall 1 (orange) and wall 11 (blue) were one; blue is drawn (islands)\n| 2 (island) | green | 4 |\n| 3 | blue | 5 |";
        let expected = "if wall 1 (green) and wall 11 (orange) were one; blue is drawn (islands)\n| 2 (island) | blue | 4 |\n| 3 | orange | 5 |";
        assert_eq!(renamed(text, &[[0, 1], [1, 2], [2, 0]]), expected);
    }
}
