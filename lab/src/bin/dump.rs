#![allow(missing_docs, clippy::all)]
use std::io::Write as _;
use std::path::PathBuf;
use anyhow::Context;
use crosscut_detector::{Preset, Settings};
use crosscut_evaluate::Score;
use crosscut_ingest::{ReadOptions, Recording, Truths, recordings_in};
use crosscut_report::ResultsLine;
use crosscut_report::confidence::Grounds;
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Frame, Source as _};
fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let file = args.next().context("file")?;
    let split = match args.next().context("dev|report|none")?.as_str() { "dev" => Some(Split::Dev), "report" => Some(Split::Report), _ => None };
    let mut out = std::io::BufWriter::new(std::fs::File::create(file)?);
    let mut engine = Settings::new(Preset::Default).engine()?;
    let sensor = Sensor::default();
    let mut frame = Frame::default();
    let mut line = |frame: &mut Frame, set: &str, family: &str, right: i32| -> anyhow::Result<()> {
        frame.notes.clear();
        let g = Grounds::of(&frame.revolution, &frame.affinity.verdicts, 0.6, frame.spectrum.margin_decades, &frame.junction);
        if let Some(g) = g {
            let j = &frame.junction;
            write!(out, "{set},{family},{right},{},{},{},{},{}", j.junctions, j.confidence.unwrap_or(-1.0), j.gaps.judged, j.gaps.seen, j.gaps.proved)?;
            let fewest = j.walls.iter().filter(|w| !w.island).map(|w| w.returns).min().unwrap_or(0);
            let doubt = frame.affinity.verdicts.iter().filter_map(|v| v.p).map(|p| p.min(1.0-p)).fold(0.0, |a,b| a+b);
            let doubtful = frame.affinity.verdicts.iter().filter_map(|v| v.p).filter(|p| *p > 0.05 && *p < 0.95).count();
            let nop = frame.affinity.verdicts.iter().filter(|v| v.p.is_none()).count();
            write!(out, ",{fewest},{doubt},{doubtful},{nop},{}", frame.revolution.points_m.len())?;
            for x in g.inputs(0.6) { write!(out, ",{x}")?; }
            writeln!(out)?;
        } else { writeln!(out, "{set},{family},{right},none")?; }
        Ok(())
    };
    if let Some(split) = split {
        for suite in suites() {
            for scene in suite.scenes(split) {
                sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
                engine.process(&mut frame)?;
                let right = Score::of(&scene.truth, &ResultsLine::of(&frame))?.right;
                line(&mut frame, "simulated", suite.name, right as i32)?;
            }
        }
    }
    for arg in args {
        for path in recordings_in(&[PathBuf::from(&arg)])? {
            let family = path.file_stem().unwrap().to_string_lossy().into_owned();
            let mut truths = Truths::open(&path).ok();
            let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor.clone())?;
            while recording.next(&mut frame.revolution, &mut frame.notes)? {
                let truth = match &mut truths { Some(t) => t.at(recording.last_log_time_ns())?, None => None };
                engine.process(&mut frame)?;
                let right = match truth { Some(t) => Score::of(&t, &ResultsLine::of(&frame))?.right as i32, None => -1 };
                line(&mut frame, &arg, &family, right)?;
            }
        }
    }
    Ok(())
}
