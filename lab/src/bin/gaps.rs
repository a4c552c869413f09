//! Writes what is measured at the gaps of the development scenes and of recordings with truth, a line of CSV for each, for
//! `lab/fit_odds.py`. `lab/make odds` runs both.
//!
//! ```text
//! lab/run gaps target/docs/gaps.csv RECORDING...
//! ```

use std::f64::consts::TAU;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_affinity::passage::{self, MEASURES, measured_gaps};
use crosscut_detector::{Engine, Preset, Settings};
use crosscut_evaluate::Score;
use crosscut_ingest::{ReadOptions, Recording, Truths, recordings_in};
use crosscut_messages::Truth;
use crosscut_report::{ResultsLine, odds};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, suites};
use crosscut_stage::{Beam, Frame, Params, Revolution, Source as _, Verdict};

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let file = args.next().context("name a file to write to")?;
    let recordings: Vec<PathBuf> = args.map(PathBuf::from).collect();
    let mut gaps = Gaps::new(&file)?;
    for suite in suites() {
        for scene in suite.scenes(Split::Dev) {
            let Gaps { sensor, frame, .. } = &mut gaps;
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            gaps.add("simulator", suite.name, &scene.truth)?;
        }
    }
    for path in recordings_in(&recordings)? {
        let name =
            |part: Option<&Path>| part.and_then(Path::file_stem).unwrap_or_default().to_string_lossy().into_owned();
        let (set, family) = (name(path.parent()), name(Some(&path)));
        let mut truths = Truths::open(&path)?;
        let mut recording = Recording::open(&[path], &ReadOptions::default(), gaps.sensor.clone())?;
        while recording.next(&mut gaps.frame.revolution, &mut gaps.frame.notes)? {
            let truth = truths.at(recording.last_log_time_ns())?.context("a scan without truth")?;
            gaps.add(&set, &family, &truth)?;
        }
    }
    gaps.out.flush().with_context(|| format!("cannot write {file}"))
}

/// Preset `default`, and the file that the gaps are written to.
struct Gaps {
    engine: Engine,
    params: Params,
    sensor: Sensor,
    frame: Frame,
    scene: u32,
    out: BufWriter<File>,
}

impl Gaps {
    fn new(file: &str) -> anyhow::Result<Self> {
        let mut out = BufWriter::new(File::create(file).with_context(|| format!("cannot write {file}"))?);
        writeln!(out, "set,family,scene,right,is_opening,truth,{}", MEASURES.join(","))?;
        let (engine, params) = (Settings::new(Preset::Default).engine()?, Params::defaults(passage::KIND.params));
        Ok(Self { engine, params, sensor: Sensor::default(), frame: Frame::default(), scene: 0, out })
    }

    /// Writes the gaps between walls of the scene in the frame.
    fn add(&mut self, set: &str, family: &str, truth: &Truth) -> anyhow::Result<()> {
        let Self { engine, params, frame, scene, out, .. } = self;
        engine.process(frame)?;
        let right = u8::from(Score::of(truth, &ResultsLine::of(frame))?.right);
        frame.notes.clear();
        *scene += 1;
        let revolution = &frame.revolution;
        for (verdict, measures) in measured_gaps(revolution, params)? {
            let Some(is_opening) = odds::has_opening(&verdict, &frame.junction) else { continue };
            let truth = is_truly_opening(&verdict, revolution, truth)
                .map_or("", |is_opening| if is_opening { "1" } else { "0" });
            write!(out, "{set},{family},{scene},{right},{},{truth}", u8::from(is_opening))?;
            for measure in measures.unwrap_or([f64::NAN; MEASURES.len()]) {
                write!(out, ",{measure:.4}")?;
            }
            writeln!(out)?;
        }
        Ok(())
    }
}

/// Whether a vehicle can pass at a gap: its two returns are of two true walls, or of the only wall of a place whose
/// opening lies between them. `None` where a return is of no wall or of an island.
fn is_truly_opening(verdict: &Verdict, revolution: &Revolution, truth: &Truth) -> Option<bool> {
    let sweep = revolution.beams()?;
    let beam = |number: u32| sweep.beams.iter().position(|beam| *beam == Beam::Return(number));
    let [from, to] = [beam(verdict.returns[0])?, beam(verdict.returns[1])?];
    let (walls, labels) = (true_walls(truth), [from, to].map(|beam| truth.labels[beam]));
    labels.iter().all(|label| walls.contains(label)).then_some(())?;
    let turn_rad = |to_rad: f64| (to_rad - sweep.bearings_rad[from]).rem_euclid(TAU);
    let holds_opening = || truth.openings.iter().any(|o| turn_rad(o.bearing_rad) < turn_rad(sweep.bearings_rad[to]));
    Some(labels[0] != labels[1] || (truth.walls == 1 && holds_opening()))
}

/// The labels of the walls. Islands have labels too; they are short, so they have the fewest returns.
fn true_walls(truth: &Truth) -> Vec<i32> {
    let returns = |label: i32| truth.labels.iter().filter(|&&other| other == label).count();
    let mut labels: Vec<i32> = (0..(truth.walls + truth.islands).cast_signed()).collect();
    labels.sort_by_key(|&label| std::cmp::Reverse(returns(label)));
    labels.truncate(truth.walls as usize);
    labels
}
