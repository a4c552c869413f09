//! `crosscut info`: the contents of a recording, and how ingest reads its first scan.

use std::io::Write;

use anyhow::Context;
use comfy_table::{Cell, CellAlignment, Table, presets};
use crosscut_ingest::{Description, Parts, ScanDescription, Sensor, TopicDescription, describe, parts_in};
use crosscut_pipeline::Registry;
use crosscut_stage::counted;

use crate::cli::InfoArgs;
use crate::config;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::say::printable;

/// Prints the description of every recording. One that cannot be read does not keep the others from being described.
pub(crate) fn info(args: &InfoArgs) -> anyhow::Result<Outcome> {
    let config = config::resolve(&args.config, &Registry::standard())?;
    let sensor = Sensor::new(config.params("ingest"));
    let (mut diagnostics, mut described) = (Diagnostics::default(), 0);
    let Parts { files, missing } = parts_in(&args.input)?;
    for part in &files {
        match describe(part, &sensor, args.read_as) {
            Ok(description) => {
                let between = if described > 0 { "\n" } else { "" };
                let text = format!("{between}{}", text(&description));
                std::io::stdout().write_all(printable(&text).as_bytes()).context("standard output")?;
                diagnostics.lost_all(&description.losses);
                described += 1;
            }
            Err(error) if files.len() == 1 => return Err(error.into()),
            Err(error) => match error.as_loss(args.input.contains(part)) {
                Some(loss) => diagnostics.lost(loss),
                None => diagnostics.error(format_args!("{:#}", anyhow::Error::new(error))),
            },
        }
    }
    diagnostics.lost_all(missing);
    Ok(if described > 0 { diagnostics.outcome() } else { Outcome::Failed })
}

fn text(recording: &Description) -> String {
    let or = |text: &str, default: &str| if text.is_empty() { default.to_owned() } else { text.to_owned() };
    let mut lines = vec![
        format!("{}, {}", recording.path.display(), size(recording.bytes)),
        format!(
            "profile   {}, written by {}",
            or(&recording.profile, "none"),
            or(&recording.library, "an unnamed program")
        ),
        format!("index     {}", index(recording)),
    ];
    if let Some(duration_s) = recording.duration_s() {
        lines.push(format!("duration  {duration_s:.1} s"));
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

fn index(recording: &Description) -> String {
    let compressions = recording.compressions.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
    match recording.indexed_chunks {
        Some(chunks) => format!("{}, compression: {compressions}", counted(chunks as u64, "chunk")),
        None => "none: messages come in the order of the file".to_owned(),
    }
}

fn topics(topics: &[TopicDescription]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(["topic", "type", "encoding", "messages", "Hz"]);
    for topic in topics {
        let count = topic.info.messages.map_or_else(|| "?".to_owned(), |count| count.to_string());
        let rate = topic.rate_hz.map_or_else(String::new, |rate| format!("{rate:.1}"));
        let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
        table.add_row([
            Cell::new(&topic.info.name),
            Cell::new(if topic.info.type_name.is_empty() { "(no schema)" } else { &topic.info.type_name }),
            Cell::new(&topic.info.encoding),
            right(count),
            right(rate),
        ]);
    }
    table.trim_fmt()
}

fn first_scan(topic: &str, scan: &ScanDescription) -> String {
    let [range_min_m, range_max_m] = scan.range_m;
    // Drivers that know no limit state the largest number.
    let range_max = if range_max_m < 1e6 { format!("{range_max_m} m") } else { "no limit".to_owned() };
    let around = if scan.full_turn { ", all the way round" } else { "" };
    let [view_deg, step_deg] = [scan.field_of_view_rad, scan.step_rad].map(f64::to_degrees);
    let view =
        if view_deg > 0.0 { format!("view {view_deg:.1}°{around}, {step_deg:.3}° a beam") } else { "no view".into() };
    let mut text = format!(
        "first scan of {topic}, frame {:?}: {}, {}\n  {view}, range {range_min_m} m to {range_max}",
        scan.frame_id,
        counted(scan.beams as u64, "beam"),
        counted(scan.returns as u64, "return"),
    );
    for note in &scan.notes {
        text += &format!("\n  {note}");
    }
    text
}
