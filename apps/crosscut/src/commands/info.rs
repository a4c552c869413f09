//! `crosscut info`: the contents of a recording, and how ingest reads its first scan.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use clap::Args;
use crosscut_detector::Registry;
use crosscut_evaluate::tables::Table;
use crosscut_ingest::{CsvGeometry, Description, ReadOptions, ScanDescription, TopicDescription, TopicInfo, describe};
use crosscut_outfile::Keep;
use crosscut_stage::{NOTES_PAGE, counted};
use serde_json::{Value, json};

use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::input::{ConfigArgs, RecordingsArgs, each_of};
use crate::interrupt::stop_on_interrupt;
use crate::output::typeset::plain;
use crate::output::{Document, looking, show};

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Explain the notes with this code instead (N082), or `all` of them.
    #[arg(long, value_name = "CODE", exclusive = true)]
    note: Option<String>,
    #[command(flatten)]
    recordings: RecordingsArgs,
    #[command(flatten)]
    config: ConfigArgs,
    /// Write all that is found as JSON instead, one object per recording; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Prints the description of every recording. One that cannot be read does not keep the others from being described.
pub(crate) fn info(args: &InfoArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    if let Some(code) = &args.note {
        return explain(code);
    }
    #[cfg(feature = "rerun")]
    if let (Some(recording), None) = (crate::input::recorded::only(&args.recordings.input)?, &args.json) {
        return super::rrd::describe(recording);
    }
    stop_on_interrupt()?; // which ends a wait for standard input
    let config = args.config.resolve(registry)?;
    let sensor = config.sensor();
    let csv = CsvGeometry::new(config.params("csv"));
    let options = ReadOptions { read_as: args.recordings.read_as, csv, ..ReadOptions::default() };
    let mut json =
        args.json.as_ref().map(|path| Document::create(path, &args.recordings.input, Keep::ThroughKill)).transpose()?;
    let (mut diagnostics, mut described) = (Diagnostics::default(), Vec::new());
    let files = each_of(&args.recordings.input, &mut diagnostics)?;
    let mut alike = Alike::default();
    let (mut scan_topics, mut unknown_topics) = (BTreeMap::new(), BTreeSet::new());
    for part in &files {
        match describe(part, &sensor, &options) {
            Ok(description) => {
                if json.is_none() && !alike.takes(&description) {
                    let before = if described.is_empty() { "" } else { "\n" };
                    show(format!("{}{before}{}", alike.told(), text(&description)))?;
                }
                diagnostics.lost_all(&description.losses);
                for topic in description.topics.iter().filter(|topic| topic.first_scan.is_some()) {
                    *scan_topics.entry(topic.info.name.clone()).or_default() += topic.info.messages.unwrap_or(1);
                }
                let unknown = description.topics.iter().filter(|topic| topic.info.type_name.is_empty());
                unknown_topics.extend(unknown.map(|topic| topic.info.name.clone()));
                described.push(object(&description));
            }
            Err(error) if files.len() == 1 => return Err(error.into()),
            Err(error) => match error.as_loss(args.recordings.input.contains(part)) {
                Some(loss) => diagnostics.lost(loss),
                None => diagnostics.error(format_args!("{:#}", anyhow::Error::new(error))),
            },
        }
    }
    let next = run_line(args, &scan_topics);
    let is_described = !described.is_empty();
    if let Some(out) = &mut json {
        out.write(&format!(
            "{}\n",
            json!({"recordings": described, "next": next, "problems": diagnostics.problems()})
        ))?;
    } else {
        show(alike.told())?;
        if let Some(line) = next {
            show(format!("\nnext: {line}\n"))?;
        } else if !unknown_topics.is_empty() && args.recordings.read_as.is_none() {
            let names = unknown_topics.into_iter().collect::<Vec<_>>().join(", ");
            show(format!("\nno schema states the type of {names}; for laser scans add: --as LaserScan\n"))?;
        }
    }
    Ok(if is_described { diagnostics.outcome() } else { Outcome::Failed })
}

/// Prints what notes with this code mean.
fn explain(code: &str) -> anyhow::Result<Outcome> {
    if code == "all" {
        show(NOTES_PAGE)?;
        return Ok(Outcome::Done);
    }
    let number = code.trim_start_matches(['n', 'N']).parse::<u16>(); // 82 and n82 are N082
    let code = &number.map_or_else(|_| code.to_owned(), |number| format!("N{number:03}"));
    let rows = || NOTES_PAGE.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    let [heads, row] = ["code", code].map(|name| rows().find(|row| row.len() > 2 && row[1].eq_ignore_ascii_case(name)));
    let unknown = || UsageError(format!("there is no note {code:?}; `crosscut info --note all` lists them"));
    let cells = heads.unwrap_or_default().into_iter().zip(row.ok_or_else(unknown)?);
    show(
        cells.filter(|(head, _)| !head.is_empty()).map(|(head, cell)| format!("{head}: {cell}\n")).collect::<String>(),
    )?;
    Ok(Outcome::Done)
}

/// The command that runs what was described, on the scan topic with the most messages if there are several.
fn run_line(args: &InfoArgs, scan_topics: &BTreeMap<String, u64>) -> Option<String> {
    let (topic, _) = scan_topics.iter().max_by_key(|(_, messages)| **messages)?;
    let mut words = vec!["crosscut".to_owned(), "run".to_owned()];
    words.extend(args.recordings.input.iter().map(|input| input.display().to_string()));
    if scan_topics.len() > 1 {
        words.extend(["--topic".to_owned(), topic.clone()]);
    }
    words.extend(args.recordings.read_as.iter().flat_map(|read_as| ["--as".to_owned(), read_as.name().to_owned()]));
    words.extend(looking::options(args.config.preset.as_deref(), args.config.config.as_deref(), &args.config.set));
    Some(looking::line(words.into_iter()))
}

/// Single clouds or scans after one like them: a folder of them would fill pages.
#[derive(Default)]
struct Alike {
    /// Format and topics of the last file, if it holds a message each.
    kind: Option<(&'static str, Vec<TopicInfo>)>,
    more: u64,
    last: PathBuf,
}

impl Alike {
    /// Whether the file is like the one before, so that it is only counted.
    fn takes(&mut self, file: &Description) -> bool {
        let topics: Vec<_> = file.topics.iter().map(|topic| topic.info.clone()).collect();
        let is_single = file.losses.is_empty() && topics.iter().all(|info| info.messages == Some(1));
        let kind = is_single.then_some((file.format, topics));
        let is_alike = kind.is_some() && kind == self.kind;
        if is_alike {
            self.more += 1;
            self.last.clone_from(&file.path);
        } else {
            self.kind = kind;
        }
        is_alike
    }

    /// How many were counted since the last report.
    fn told(&mut self) -> String {
        match std::mem::take(&mut self.more) {
            0 => String::new(),
            more => format!("\n{} more like it, to {}\n", counted(more, "file"), self.last.display()),
        }
    }
}

/// What [`text`] says, in units that its names state.
fn object(recording: &Description) -> Value {
    let topic = |topic: &TopicDescription| {
        let scan = topic.first_scan.as_ref().map(|scan| {
            json!({
                "frame_id": scan.frame_id, "beams": scan.beams, "returns": scan.returns, "missing": scan.missing,
                "step_rad": scan.step_rad, "field_of_view_rad": scan.field_of_view_rad, "full_turn": scan.full_turn,
                "range_m": scan.range_m, "notes": scan.notes,
            })
        });
        let info = &topic.info;
        json!({
            "name": info.name, "type": info.type_name, "encoding": info.encoding, "messages": info.messages,
            "rate_hz": topic.rate_hz, "first_scan": scan,
        })
    };
    let properties: serde_json::Map<_, _> =
        recording.properties.iter().map(|(name, value)| ((*name).to_owned(), Value::from(value.as_str()))).collect();
    json!({
        "path": recording.path.display().to_string(), "bytes": recording.bytes, "format": recording.format,
        "properties": properties, "duration_s": recording.duration_s(), "log_time_ns": recording.log_time_ns,
        "topics": recording.topics.iter().map(topic).collect::<Vec<_>>(),
        "losses": recording.losses.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

fn text(recording: &Description) -> String {
    let mut lines = vec![
        format!("{}, {}", recording.path.display(), size(recording.bytes)),
        format!("{:<10}{}", "format", recording.format),
    ];
    let stated = recording.properties.iter().filter(|(_, value)| !value.is_empty());
    lines.extend(stated.map(|(name, value)| format!("{name:<10}{value}")));
    if let Some(duration_s) = recording.duration_s() {
        lines.push(format!("duration  {duration_s:.1} s"));
    }
    if recording.has_odd_times {
        lines.push("times     some times of recording cannot be right, and are left out here".to_owned());
    }
    if !recording.topics.is_empty() {
        lines.push(String::new());
        lines.push(topics(&recording.topics));
    }
    for topic in &recording.topics {
        if topic.first_scan.is_none() && topic.info.has_scans() && topic.info.messages != Some(0) {
            lines.push(format!("\nno selected scan on {} can be read", topic.info.name));
        }
        if let Some(scan) = &topic.first_scan {
            lines.push(String::new());
            lines.push(first_scan(&topic.info.name, scan));
        }
    }
    lines.join("\n") + "\n"
}

fn size(bytes: u64) -> String {
    if bytes < 1_000_000 { format!("{:.1} kB", bytes as f64 / 1e3) } else { format!("{:.1} MB", bytes as f64 / 1e6) }
}

fn topics(topics: &[TopicDescription]) -> String {
    let row = |topic: &TopicDescription| {
        let info = &topic.info;
        let kind = if info.type_name.is_empty() { "(no schema)" } else { &info.type_name };
        let count = info.messages.map_or_else(|| "?".to_owned(), |count| count.to_string());
        let rate = topic.rate_hz.map_or_else(String::new, |rate| format!("{rate:.1}"));
        vec![info.name.clone(), kind.to_owned(), info.encoding.clone(), count, rate]
    };
    let header = ["topic", "type", "encoding", "messages", "Hz"].map(str::to_owned).to_vec();
    plain(&Table { title: String::new(), header, rows: topics.iter().map(row).collect() })
}

fn first_scan(topic: &str, scan: &ScanDescription) -> String {
    let [range_min_m, range_max_m] = scan.range_m;
    // Drivers that know no limit state the largest number.
    let range_max = if range_max_m < 1e6 { format!("{range_max_m} m") } else { "no limit".to_owned() };
    let around = if scan.full_turn { ", all the way round" } else { "" };
    let [view_deg, step_deg] = [scan.field_of_view_rad, scan.step_rad].map(f64::to_degrees);
    let view =
        if view_deg > 0.0 { format!("view {view_deg:.1}°{around}, {step_deg:.3}° a beam") } else { "no view".into() };
    let returns = counted(scan.returns as u64, "return");
    let mut text = format!("first scan of {topic}, frame {:?}: ", scan.frame_id);
    text += &match scan.beams {
        0 => format!("{returns} without beams, so nothing is known where there are none"),
        beams => format!(
            "{}, {returns}\n  {view}, range {range_min_m} m to {range_max}, {:.0} % of beams without a return",
            counted(beams as u64, "beam"),
            100.0 * scan.missing,
        ),
    };
    for note in &scan.notes {
        text += &format!("\n  {note}");
    }
    text
}
