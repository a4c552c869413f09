//! Draws the first wrong answers of preset `default` on a recording with truth, each beside the truth. `lab/make simulated` runs it.
//!
//! ```text
//! lab/run wrong RECORDING OUT.svg
//! ```

use std::path::PathBuf;

use anyhow::Context;
use crosscut_detector::{Engine, Preset, Settings};
use crosscut_evaluate::Score;
use crosscut_evaluate::panel::{Panel, sheet};
use crosscut_ingest::{ReadOptions, Recording, Truths};
use crosscut_report::ResultsLine;
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Source as _, counted};

/// The first scenes up to this number are drawn.
const MOST_SCENES: usize = 8;
/// Panels in a row of the drawing: two scenes, each with truth and answer.
const COLUMNS: usize = 4;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().context("name a recording")?);
    let out = args.next().context("name a file to write to")?;
    let mut engine = Settings::new(Preset::Default).engine()?;
    let mut truths = Truths::open(&path)?;
    let mut recording = Recording::open(&[path], &ReadOptions::default(), Sensor::default())?;
    let (mut frame, mut panels) = (Frame::default(), Vec::new());
    while panels.len() < 2 * MOST_SCENES && recording.next(&mut frame.revolution, &mut frame.notes)? {
        let truth = truths.at(recording.last_log_time_ns())?.context("a scan without truth")?;
        engine.process(&mut frame)?;
        let score = Score::of(&truth, &ResultsLine::of(&frame))?;
        if !score.right {
            let walls = |count: usize| counted(count as u64, "wall");
            let name = format!("scene {}: {}", frame.revolution.seq, walls(score.true_walls));
            let answer = if score.right_count() { "other walls".to_owned() } else { walls(score.reported_walls) };
            panels.push(Panel::of_truth(name, &frame.revolution, &truth));
            panels.push(Panel::of_answer(format!("answer: {answer}"), &frame));
        }
        frame.notes.clear();
    }
    std::fs::write(&out, sheet(&panels, COLUMNS)).with_context(|| format!("cannot write {out}"))
}
