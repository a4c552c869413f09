//! Where two flights that are shown side by side differ: lines, a strip, a list and a summary.

use std::fmt::Write as _;

use rerun::external::re_log_types::StoreId;
use rerun::log::LogMsg;
use rerun::{
    RecordingStreamBuilder, RecordingStreamResult, Scalars, SeriesLines, StateChange, StateConfiguration, TextDocument,
    TextLog, TextLogLevel,
};

use super::flight::Facts;
use super::made::Made;
use crate::colors::{REPORTED, TRUTH, ZEROS, color};
use crate::layout::differs::{DIFFERS, DIFFERS_CONFIDENCE, DIFFERS_LOG, DIFFERS_SUMMARY, DIFFERS_WALLS};

/// The summary names this many settings at most.
const SHOWN_SETTINGS: usize = 4;
/// A preset's name is a title up to this many letters.
const SHORT: usize = 24;

/// What two flights are called in titles: their presets where these tell them apart, else their files.
pub(super) fn titles(files: &[String; 2], facts: [&Facts; 2]) -> [String; 2] {
    let preset = |facts: &Facts| Some(facts.source.as_ref()?.split_once(", preset ")?.1.to_owned());
    match facts.map(preset) {
        [Some(a), Some(b)] if a != b && a.len() <= SHORT && b.len() <= SHORT => [a, b],
        _ => files.clone(),
    }
}

/// A stretch of the flight where the counts differ in the same way.
struct Stretch {
    first: i64,
    last: i64,
    stamp_ns: i64,
    walls: [f64; 2],
    truth: Option<f64>,
    /// The first stage that made something else, and of what.
    from: [&'static str; 2],
}

impl Stretch {
    /// "95 to 99: paper 4 walls, default 3; truth 3: paper is wrong; from W on".
    fn words(&self, [a, b]: &[String; 2]) -> String {
        let [of_a, of_b] = self.walls;
        let [_, from] = self.from;
        let span = if self.first == self.last {
            format!("{}", self.first)
        } else {
            format!("{} to {}", self.first, self.last)
        };
        if of_a == of_b {
            return format!("{span}: both {of_a} walls, grouped otherwise; from {from} on");
        }
        let wrong = |truth: f64| match (of_a == truth, of_b == truth) {
            (true, false) => format!("{b} is wrong"),
            (false, true) => format!("{a} is wrong"),
            _ => "both are wrong".to_owned(),
        };
        let truth = self.truth.map_or_else(String::new, |truth| format!("; truth {truth}: {}", wrong(truth)));
        format!("{span}: {a} {of_a} walls, {b} {of_b}{truth}; from {from} on")
    }
}

/// The entities of the page that shows what differs.
pub(super) fn messages(
    store: &StoreId,
    names: &[String; 2],
    files: &[String; 2],
    facts: [&Facts; 2],
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (rec, storage) = RecordingStreamBuilder::from_store_id(store).send_properties(false).memory()?;
    let (stretches, common) = stretches(facts);
    let summary = summary(names, files, facts, &stretches, common);
    if common == 0 {
        rec.log_static(DIFFERS_SUMMARY, &TextDocument::from_markdown(summary.as_str()))?;
    }
    log_looks(&rec, names)?;
    let [a, b] = facts;
    let (mut before, mut said) = (None, None);
    for &[stamp_ns, seq] in &a.revolutions {
        let Some(walls) = a.walls.get(&seq).zip(b.walls.get(&seq)) else { continue };
        rec.set_time_sequence("revolution", seq);
        rec.set_timestamp_nanos_since_epoch("stamp", stamp_ns);
        let truth = truth_at(facts, seq).unwrap_or(f64::NAN);
        rec.log(DIFFERS_WALLS, &Scalars::new([*walls.0, *walls.1, truth]))?;
        let confidence = [a, b].map(|of| of.confidence.get(&seq).copied().unwrap_or(f64::NAN));
        rec.log(DIFFERS_CONFIDENCE, &Scalars::new(confidence))?;
        let is_same_grouping = groups_alike(facts, seq);
        let state = match (walls.0 == walls.1, is_same_grouping) {
            (true, true) => SAME.to_owned(),
            (true, false) => format!("{} | {}, grouped otherwise", walls.0, walls.1),
            (false, _) => format!("{} | {}", walls.0, walls.1),
        };
        let here = if state == SAME { None } else { here(facts, seq, names) };
        let text = here.map_or_else(|| summary.clone(), |here| format!("**Here: {here}.**\n\n{summary}"));
        if said.as_ref() != Some(&text) {
            rec.log(DIFFERS_SUMMARY, &TextDocument::from_markdown(text.as_str()))?;
            said = Some(text);
        }
        if before.as_ref() != Some(&state) {
            rec.log(DIFFERS, &StateChange::single(state.as_str()))?;
            before = Some(state);
        }
    }
    for stretch in &stretches {
        rec.set_time_sequence("revolution", stretch.first);
        rec.set_timestamp_nanos_since_epoch("stamp", stretch.stamp_ns);
        rec.log(DIFFERS_LOG, &TextLog::new(stretch.words(names)).with_level(TextLogLevel::WARN))?;
    }
    let mut messages = storage.take();
    messages.retain(|message| matches!(message, LogMsg::ArrowMsg(..)));
    Ok(messages)
}

/// The state where both counts are the same.
const SAME: &str = "same";

fn log_looks(rec: &rerun::RecordingStream, [a, b]: &[String; 2]) -> RecordingStreamResult<()> {
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

/// The truth of a revolution: the last one that either flight was told.
fn truth_at(facts: [&Facts; 2], seq: i64) -> Option<f64> {
    facts.iter().find_map(|of| of.truth.range(..=seq).next_back().map(|(_, truth)| *truth))
}

/// The first stage that made something else of a revolution, and of what.
fn part_at(facts: [&Facts; 2], seq: i64) -> [&'static str; 2] {
    let [a, b] = made_at(facts, seq);
    a.parts_from(&b)
}

fn made_at(facts: [&Facts; 2], seq: i64) -> [Made; 2] {
    facts.map(|of| of.made.get(&seq).cloned().unwrap_or_default())
}

/// Whether both have the same walls of a revolution.
fn groups_alike(facts: [&Facts; 2], seq: i64) -> bool {
    let [a, b] = made_at(facts, seq);
    a.grouping.is_as(&b.grouping)
}

/// Why the walls of a revolution differ, in words.
fn here(facts: [&Facts; 2], seq: i64, [a, b]: &[String; 2]) -> Option<String> {
    let [of_a, of_b] = made_at(facts, seq);
    of_a.grouping.words(&of_b.grouping, [a, b])
}

/// "They part at affinity (W) in 40, at report (walls) in 16; k is another one in 40." The stages come in the order in which
/// they run.
fn parting(facts: [&Facts; 2], differing: &[i64]) -> String {
    let mut stages: Vec<([&str; 2], usize)> =
        ["ingest", "affinity", "spectral", "kmeans", "report"].map(|stage| ([stage, ""], 0)).to_vec();
    for seq in differing {
        let from = part_at(facts, *seq);
        if let Some((stage, times)) = stages.iter_mut().find(|(stage, _)| stage[0] == from[0]) {
            (*stage, *times) = (from, *times + 1);
        }
    }
    let several = |times: usize| if times == differing.len() { "all".to_owned() } else { times.to_string() };
    let named: Vec<String> = stages
        .iter()
        .filter(|(_, times)| *times > 0)
        .map(|([stage, of], times)| format!("at **{stage}** ({of}) in {}", several(*times)))
        .collect();
    let has_other_k = |seq: &i64| {
        let [a, b] = made_at(facts, *seq);
        !a.has_k_of(&b)
    };
    let other_k = differing.iter().filter(|seq| has_other_k(seq)).count();
    let k = if other_k == 0 { "the same".to_owned() } else { format!("another one in {}", several(other_k)) };
    format!("They part {}; k is {k}.", named.join(", "))
}

/// Where the counts differ, and how many revolutions both flights have.
fn stretches(facts: [&Facts; 2]) -> (Vec<Stretch>, usize) {
    let [a, b] = facts;
    let (mut stretches, mut common, mut before): (Vec<Stretch>, usize, i64) = (Vec::new(), 0, i64::MIN);
    for &[stamp_ns, seq] in &a.revolutions {
        let Some((&of_a, &of_b)) = a.walls.get(&seq).zip(b.walls.get(&seq)) else { continue };
        common += 1;
        let previous = std::mem::replace(&mut before, seq);
        if of_a == of_b && groups_alike(facts, seq) {
            continue;
        }
        let (walls, truth, from) = ([of_a, of_b], truth_at(facts, seq), part_at(facts, seq));
        let is_alike = |last: &Stretch| last.walls == walls && last.truth == truth && last.from == from;
        match stretches.last_mut() {
            Some(last) if last.last == previous && is_alike(last) => last.last = seq,
            _ => stretches.push(Stretch { first: seq, last: seq, stamp_ns, walls, truth, from }),
        }
    }
    (stretches, common)
}

/// How often they differ, who is right by the truth, and which settings differ.
fn summary(
    names: &[String; 2],
    files: &[String; 2],
    facts: [&Facts; 2],
    stretches: &[Stretch],
    common: usize,
) -> String {
    let ([a, b], [left, right]) = (names, files);
    let of_stretches = |by_count: bool| -> Vec<i64> {
        let of = stretches.iter().filter(|of| !by_count || of.walls[0] != of.walls[1]);
        let spans: Vec<_> = of.map(|of| of.first..=of.last).collect();
        facts[0].walls.keys().copied().filter(|seq| spans.iter().any(|span| span.contains(seq))).collect()
    };
    let (all, differing) = (of_stretches(false).len(), of_stretches(true));
    let mut text = match (common, differing.len()) {
        (0, _) => "**No revolution is in both recordings.**".to_owned(),
        (_, 0) => format!("**{a} and {b} count the same walls in all {common} revolutions.**"),
        (_, several) => format!("**{a} and {b} differ in {several} of {common} revolutions.**"),
    };
    let right_of =
        |of: &Facts| differing.iter().filter(|seq| of.walls.get(seq).copied() == truth_at(facts, **seq)).count();
    if !differing.is_empty() && facts.iter().any(|of| !of.truth.is_empty()) {
        let [of_a, of_b] = facts.map(right_of);
        let _ = write!(text, " There {a} is right in {of_a}, {b} in {of_b}.");
    }
    if all > differing.len() {
        let _ = write!(text, " In {} the count is the same, grouped otherwise.", all - differing.len());
    }
    if !differing.is_empty() {
        let _ = write!(text, " {}", parting(facts, &differing));
    }
    let _ = write!(text, " Left: {left}.rrd, right: {right}.rrd.");
    let settings = settings_that_differ(facts.map(|of| of.config_toml.as_str()));
    if !settings.is_empty() {
        let more = settings.len().saturating_sub(SHOWN_SETTINGS);
        let more = if more > 0 { format!(", and {more} more (tab Config)") } else { String::new() };
        let shown = &settings[..settings.len().min(SHOWN_SETTINGS)];
        let _ = write!(text, "\n\nSettings: {}{more}", shown.join(", "));
    }
    text
}

/// "affinity.kind \"rbf\" | \"passage\"" for each setting that both have with other values.
fn settings_that_differ(configs: [&str; 2]) -> Vec<String> {
    let [a, b] = configs.map(settings);
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

    fn facts(walls: &[f64], truth: Option<f64>) -> Facts {
        let by_seq = || (0..).zip(walls.iter().copied());
        Facts {
            revolutions: by_seq().map(|(seq, _)| [seq * 100, seq]).collect(),
            walls: by_seq().collect(),
            truth: truth.map(|truth| (0, truth)).into_iter().collect(),
            source: Some(format!("tee.mcap, preset {}", walls.len())),
            ..Facts::default()
        }
    }

    #[test]
    fn revolutions_that_differ_alike_are_one_stretch() {
        let [a, b] = [facts(&[2.0, 3.0, 4.0, 4.0, 3.0, 4.0], Some(3.0)), facts(&[2.0, 3.0, 3.0, 3.0, 3.0], Some(3.0))];
        let (stretches, common) = stretches([&a, &b]);
        assert_eq!(common, 5);
        let files = ["a".to_owned(), "b".to_owned()];
        assert_eq!(titles(&files, [&a, &b]), ["6", "5"], "presets");
        assert_eq!(titles(&files, [&a, &a]), files);
        let words: Vec<String> = stretches.iter().map(|stretch| stretch.words(&files)).collect();
        assert_eq!(words, ["2 to 3: a 4 walls, b 3; truth 3: a is wrong; from walls on"]);
        let text = summary(&files, &files, [&a, &b], &stretches, common);
        let expected = "**a and b differ in 2 of 5 revolutions.** There a is right in 0, b in 2. They part at **report** (walls) in \
                        all; k is the same.";
        assert!(text.starts_with(expected), "{text}");
    }

    #[test]
    fn settings_with_other_values_are_named_with_both() {
        let a = "# crosscut\n[affinity]\nkind = \"rbf\" # or\nsigma = 1\n# passage_m = 0.6  # follows vehicle.width_m\n[report]\nmin = 2\n";
        let b = "[affinity]\n# at most 2 = few\nkind = \"passage\"\npassage_m = 1.2  # --set\n[report]\nmin = 2\n";
        let expected = ["`affinity.kind` \"rbf\" | \"passage\"", "`affinity.passage_m` 0.6 | 1.2"];
        assert_eq!(settings_that_differ([a, b]), expected);
    }
}
