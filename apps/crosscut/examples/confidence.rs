//! Fits the confidence of a scene to what preset `default` gets right and wrong on the development scenes. If the program
//! has that fit, writes a page that shows how well its confidence means what it says.
//!
//! `cargo run --release -p crosscut --no-default-features --example confidence -- docs/confidence.md`

use anyhow::{Context, bail};
use crosscut_evaluate::tables::{self, Table};
use crosscut_evaluate::{Score, Scoreboard};
use crosscut_ingest::Sensor;
use crosscut_pipeline::{Config, Engine, Registry};
use crosscut_report::ResultsLine;
use crosscut_report::confidence::{BETA, Grounds};
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Frame, Params};
use nalgebra::{SMatrix, SVector};

const N: usize = Grounds::INPUTS;
/// As in preset `default`.
const VEHICLE_WIDTH_M: f64 = 0.6;
const NEWTON_STEPS: usize = 30;

const PAGE: &str = "\
# What the confidence of preset `default` means

On the development scenes, on which it is fitted; on the report scenes: [evaluation-tables.md](evaluation-tables.md). How it
is made and why: [openings.md](openings.md). `cargo run --release -p crosscut --no-default-features --example confidence --
docs/confidence.md` makes this page; the numbers of β stand in `crates/report/src/confidence.rs`.
";

/// An answer that has grounds.
struct Answer {
    family: &'static str,
    x: SVector<f64, N>,
    score: Score,
}

fn main() -> anyhow::Result<()> {
    let file = std::env::args().nth(1).context("say a file to write to")?;
    let answers = answers()?;
    let beta = fitted(&answers).map(|beta| (100.0 * beta).round() / 100.0);
    if <[f64; N]>::from(beta) != BETA {
        bail!("β of crates/report/src/confidence.rs is not fitted to these answers: {BETA:?} instead of {beta:?}");
    }
    let mut scoreboard = Scoreboard::new(vec!["default".to_owned()]);
    answers.iter().for_each(|answer| scoreboard.add(answer.family, 0, &answer.score));
    let [one, opening, gap, unseen, ratio, apart, islands, margin] = BETA;
    let mut page = format!(
        "{PAGE}\nβ = ({one}, {opening}, {gap}, {unseen}, {ratio}, {apart}, {islands}, {margin}) \
         for x = (1, ln(o/w), ln(g/w), ln(u/1°), ln r, φ, i, m)\n"
    );
    for table in tables::details(&scoreboard).iter().filter(|table| table.title.contains("confidence")) {
        page += &markdown(table);
    }
    std::fs::write(&file, page).with_context(|| format!("cannot write {file}"))
}

fn markdown(table: &Table) -> String {
    let row = |cells: &Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rows: String = table.rows.iter().map(row).collect();
    format!("\n## {}\n\n{}|{}\n{rows}", table.title, row(&table.header), "---|".repeat(table.header.len()))
}

fn answers() -> anyhow::Result<Vec<Answer>> {
    let registry = Registry::standard();
    let mut engine = Engine::new(&Config::preset("default", &registry)?, &registry);
    let sensor = Sensor::new(&Params::defaults(crosscut_ingest::PARAMS));
    let mut frame = Frame::default();
    let mut answers = Vec::new();
    for suite in suites() {
        for scene in suite.scenes(Split::Dev) {
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame)?;
            let score = Score::of(&scene.truth, &ResultsLine::of(&frame))?;
            let margin_decades = frame.spectrum.margin_decades;
            if let Some(grounds) = Grounds::of(&frame.revolution, VEHICLE_WIDTH_M, margin_decades, &frame.junction) {
                answers.push(Answer { family: suite.name, x: grounds.inputs(VEHICLE_WIDTH_M).into(), score });
            }
        }
    }
    Ok(answers)
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
            gradient += answer.x * (f64::from(u8::from(answer.score.right)) - p);
            hessian += answer.x * answer.x.transpose() * (p * (1.0 - p));
        }
        let Some(step) = hessian.cholesky().map(|factor| factor.solve(&gradient)) else { break };
        beta += step;
    }
    beta
}
