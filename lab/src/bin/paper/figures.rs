//! The figures and their captions. Rules select the scenes; none is picked by hand.

use anyhow::Context;
use crosscut_detector::Preset;
use crosscut_evaluate::panel::{Panel, sheet};
use crosscut_messages::{Truth, TruthOpening};
use crosscut_simulator::{Scene, Split, Suite, scenarios, suites};
use crosscut_stage::wrap_angle_rad;

use crate::answers::{Answers, truth_panel};

/// Openings of a plain place are at least this far apart, as in the suites.
const APART_RAD: f64 = 54.0 * std::f64::consts::PI / 180.0;

/// Seeds of the flights through each mine.
const FLIGHTS: std::ops::RangeInclusive<u64> = 1..=4;

/// Panels with their caption.
pub(crate) struct Figure {
    name: &'static str,
    pub(crate) caption: String,
    columns: usize,
    panels: Vec<Panel>,
}

impl Figure {
    pub(crate) fn file(&self) -> String {
        format!("{}.svg", self.name)
    }

    pub(crate) fn svg(&self) -> String {
        sheet(&self.panels, self.columns)
    }
}

pub(crate) fn figures() -> anyhow::Result<Vec<Figure>> {
    Ok(vec![
        random()?,
        places(
            "tunnel",
            &[2, 2, 3],
            "a tunnel of 3.5 m x 3 m: two places without a branch that leads on, and a junction",
        )?,
        places("mine", &[3, 4], "a mine of 6 m x 4 m with wet walls: junctions of three and four walls")?,
        families()?,
    ])
}

/// Scenes without loss, a row per width, a column per number of branches.
fn random() -> anyhow::Result<Figure> {
    let mut answers = Answers::of(Preset::Paper)?;
    let scenes = ["clean6", "clean35", "narrow"].into_iter().map(|name| Ok(suite(name)?.scenes(Split::Dev).take(5)));
    let scenes: Vec<_> = scenes.collect::<anyhow::Result<_>>()?;
    let panels = scenes.into_iter().flatten().map(|scene| answers.panel(&scene)).collect::<anyhow::Result<_>>()?;
    let caption = "Random scenes, 360 beams, 15 m range, no beam lost, σ = 1.5, by preset `paper`; the paper's own \
        scenes are not public. Rows: 5.5-6.5 m, 3.2-3.8 m, 1.2-2.4 m wide, the first five development scenes of the \
        families `clean6`, `clean35`, `narrow`. Columns: 1 to 5 branches. Above each the answer, and the truth where \
        they differ; *other walls*: the count is right, the walls are not. Dashed: where the answer has a way on.";
    Ok(Figure { name: "random", caption: caption.to_owned(), columns: 5, panels })
}

/// Places of a flight that show these numbers of walls: a row for the truth, and one for each preset.
fn places(name: &'static str, walls: &[u32], what: &str) -> anyhow::Result<Figure> {
    let scenario = scenarios().iter().find(|scenario| scenario.name == name);
    let fly = scenario.with_context(|| format!("no scenario {name}"))?.fly;
    let flights: Vec<Vec<Scene>> = FLIGHTS.map(|seed| fly(seed).collect()).collect();
    let scenes = amid_longest_runs(&flights, walls).with_context(|| format!("no such places in the flights {name}"))?;
    let title = |scene: &Scene| format!("truth: {}", scene.truth.walls);
    let mut panels: Vec<Panel> = scenes.iter().map(|scene| truth_panel(title(scene), scene)).collect();
    for preset in [Preset::Paper, Preset::Default] {
        let mut answers = Answers::of(preset)?;
        for scene in &scenes {
            panels.push(answers.panel(scene)?);
        }
    }
    let caption = format!(
        "From flights `{name}` (seeds {} to {}) through {what}. The paper's own recordings are not public. Rows: truth, \
         preset `paper`, preset `default`. Of all stretches along which so many walls are in sight, no pillar, and no \
         two ways on less than 54° apart, the middle of the longest (of the two longest, where there are two).",
        FLIGHTS.start(),
        FLIGHTS.end()
    );
    Ok(Figure { name, caption, columns: walls.len(), panels })
}

/// For each number of walls, the middle of the longest run of plain scans with that number; no run is used twice.
fn amid_longest_runs<'a>(flights: &'a [Vec<Scene>], walls: &[u32]) -> Option<Vec<&'a Scene>> {
    let view = |scene: &Scene| is_plain(&scene.truth).then_some(scene.truth.walls);
    let mut runs: Vec<&[Scene]> =
        flights.iter().flat_map(|flight| flight.chunk_by(|a, b| view(a) == view(b))).collect();
    let longest_of = |walls: &u32| {
        let showing = runs.iter().enumerate().filter(|(_, run)| view(&run[0]) == Some(*walls));
        // Of equally long runs the first is taken.
        let (at, _) = showing.rev().max_by_key(|(_, run)| run.len())?;
        let run = runs.remove(at);
        Some(&run[run.len() / 2])
    };
    walls.iter().map(longest_of).collect()
}

/// Whether a scan has no pillar and no two openings almost in line, as a distant branch would give.
fn is_plain(truth: &Truth) -> bool {
    let apart = |a: &TruthOpening, b: &TruthOpening| wrap_angle_rad(a.bearing_rad - b.bearing_rad).abs() >= APART_RAD;
    let ways = &truth.openings;
    truth.islands == 0 && ways.iter().enumerate().all(|(i, a)| ways[..i].iter().all(|b| apart(a, b)))
}

/// One scene of every family with its truth.
fn families() -> anyhow::Result<Figure> {
    let first = |suite: &Suite| {
        let scene = suite.scenes(Split::Dev).find(|scene| scene.truth.walls == 3);
        Ok(truth_panel(suite.name.to_owned(), &scene.with_context(|| format!("no three walls in {}", suite.name))?))
    };
    let caption = "One scene of every family, with its true walls and ways on: the first development scene with three \
        walls. Grey: dust, floor or roof. A dashed line is the bearing of a way on; the bar across it, 8 m away, is as \
        long as the way is wide.";
    let panels = suites().iter().map(first).collect::<anyhow::Result<_>>()?;
    Ok(Figure { name: "families", caption: caption.to_owned(), columns: 4, panels })
}

fn suite(name: &str) -> anyhow::Result<&'static Suite> {
    suites().iter().find(|suite| suite.name == name).with_context(|| format!("no suite {name}"))
}
