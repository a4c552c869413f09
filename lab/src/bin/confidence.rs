//! Generator of a page of the docs: how well the confidence of preset `default` is calibrated. Fits the confidence to right
//! and wrong answers on the development scenes and on places of another generator, close calls among them, and fails if the
//! program has another fit.
//!
//! ```text
//! tests/foreign/run places target/places/fit --count 100 --seed 101
//! tests/foreign/run places target/places/effects-dev --count 20 --seed 113 --effects
//! tests/foreign/run places target/places/close-dev --count 100 --seed 121 --close
//! lab/run confidence target/docs/confidence.md target/places/fit target/places/effects-dev target/places/close-dev
//! ```

use std::path::PathBuf;

use anyhow::{Context, bail};
use crosscut_detector::{Engine, Preset, Settings};
use crosscut_evaluate::tables;
use crosscut_evaluate::{Score, Scoreboard};
use crosscut_ingest::{ReadOptions, Recording, Truths, recordings_in};
use crosscut_lab::markdown;
use crosscut_messages::Truth;
use crosscut_report::ResultsLine;
use crosscut_report::confidence::{BETA, Grounds};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Frame, Source as _};
use nalgebra::{SMatrix, SVector};

const N: usize = Grounds::INPUTS;
/// As in preset `default`.
const VEHICLE_WIDTH_M: f64 = 0.6;
const NEWTON_STEPS: usize = 30;
/// Weight of a place with an effect of real lidars relative to a scene: each place is there with every effect. With equal
/// weights, less than half of the answers in rough walls would be sure.
const WEIGHT_OF_EFFECTS: f64 = 1.0 / 3.0;
/// Weight of a place that may be a close call: a vehicle meets more of them than the scenes have, which leave them out.
const WEIGHT_OF_CLOSE: f64 = 2.0;

const PAGE: &str = "\
# What the confidence of preset `default` means

On the development scenes and places of another generator, on which it is fitted; on others: `docs/results.md`. How it is
made and why: `docs/openings.md`. `lab/make confidence` makes this page; β stands in `crates/report/src/confidence.rs`.
";

/// An answer that has grounds.
struct Answer {
    family: String,
    x: SVector<f64, N>,
    score: Score,
    weight: f64,
}

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let file = args.next().context("name a file to write to")?;
    let mut folder = |of: &str| args.next().map(PathBuf::from).with_context(|| format!("name a folder of {of}"));
    let answers = answers([folder("places")?, folder("places with effects")?, folder("close calls")?])?;
    let beta = fitted(&answers).map(|beta| (100.0 * beta).round() / 100.0);
    if <[f64; N]>::from(beta) != BETA {
        bail!("β of crates/report/src/confidence.rs is not fitted to these answers: {BETA:?} instead of {beta:?}");
    }
    let mut scoreboard = Scoreboard::new(vec!["default".to_owned()]);
    answers.iter().for_each(|answer| scoreboard.add(&answer.family, 0, &answer.score));
    let [one, wrong, opening, gap, apart, islands, margin] = BETA;
    let mut page = format!(
        "{PAGE}\nβ = ({one}, {wrong}, {opening}, {gap}, {apart}, {islands}, {margin}) \
         for x = (1, -ln e, ln(o/w), ln(g/w), φ, i, m)\n"
    );
    for table in tables::details(&scoreboard).iter().filter(|table| table.title.contains("confidence")) {
        page += &format!("\n## {}\n\n{}", table.title, markdown(table));
    }
    std::fs::write(&file, page).with_context(|| format!("cannot write {file}"))
}

/// Answers to the development scenes of every family, and to the scenes of recordings, which have truth.
fn answers(folders: [PathBuf; 3]) -> anyhow::Result<Vec<Answer>> {
    let mut program = Program::new()?;
    let mut answers = Vec::new();
    for suite in suites() {
        for scene in suite.scenes(Split::Dev) {
            let Program { frame, sensor, .. } = &mut program;
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            answers.extend(program.answer(suite.name, &scene.truth, 1.0)?);
        }
    }
    let mut recordings = Vec::new();
    for (folder, weight) in folders.into_iter().zip([1.0, WEIGHT_OF_EFFECTS, WEIGHT_OF_CLOSE]) {
        recordings.extend(recordings_in(&[folder])?.into_iter().map(|path| (path, weight)));
    }
    for (path, weight) in recordings {
        let family = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let mut truths = Truths::open(&path)?;
        let mut recording = Recording::open(&[path], &ReadOptions::default(), program.sensor.clone())?;
        while recording.next(&mut program.frame.revolution, &mut program.frame.notes)? {
            let truth = truths.at(recording.last_log_time_ns())?.context("a scan without truth")?;
            answers.extend(program.answer(&family, &truth, weight)?);
        }
    }
    Ok(answers)
}

/// Preset `default`.
struct Program {
    engine: Engine,
    sensor: Sensor,
    frame: Frame,
}

impl Program {
    fn new() -> anyhow::Result<Self> {
        let engine = Settings::new(Preset::Default).engine()?;
        let sensor = Sensor::default();
        Ok(Self { engine, sensor, frame: Frame::default() })
    }

    /// The answer to the revolution of the frame, if it has grounds.
    fn answer(&mut self, family: &str, truth: &Truth, weight: f64) -> anyhow::Result<Option<Answer>> {
        let Self { engine, frame, .. } = self;
        engine.process(frame)?;
        let score = Score::of(truth, &ResultsLine::of(frame))?;
        frame.notes.clear();
        let margin_decades = frame.spectrum.margin_decades;
        let grounds =
            Grounds::of(&frame.revolution, &frame.affinity.verdicts, VEHICLE_WIDTH_M, margin_decades, &frame.junction);
        let answer = |grounds: Grounds| Answer {
            family: family.to_owned(),
            x: grounds.inputs(VEHICLE_WIDTH_M).into(),
            score,
            weight,
        };
        Ok(grounds.map(answer))
    }
}

/// P(right) = 1 / (1 + exp(-β·x)).
fn probability(beta: &SVector<f64, N>, x: &SVector<f64, N>) -> f64 {
    1.0 / (1.0 + (-beta.dot(x)).exp())
}

/// β of the greatest likelihood, by Newton's method: β += (Σ p(1-p)·x·xᵀ)⁻¹ Σ (right - p)·x.
fn fitted(answers: &[Answer]) -> SVector<f64, N> {
    let mut beta = SVector::zeros();
    for _ in 0..NEWTON_STEPS {
        let (mut gradient, mut hessian) = (SVector::<f64, N>::zeros(), SMatrix::<f64, N, N>::zeros());
        for answer in answers {
            let p = probability(&beta, &answer.x);
            gradient += answer.x * (answer.weight * (f64::from(u8::from(answer.score.right)) - p));
            hessian += answer.x * answer.x.transpose() * (answer.weight * p * (1.0 - p));
        }
        let Some(step) = hessian.cholesky().map(|factor| factor.solve(&gradient)) else { break };
        beta += step;
    }
    beta
}
