//! Several configurations on one revolution.

use crosscut_detector::{Config, Engine, Registry, Worker};
use crosscut_spectral::{ZERO_TOLERANCE, recount};
use crosscut_stage::{Eigenvalues, Frame, Step, Value};

/// The sections whose settings a step depends on, beside those of the steps before it.
fn sections_of(step: Step) -> &'static [&'static str] {
    match step {
        Step::Ingest => &["csv", "ingest"],
        Step::Affinity => &["pipeline", "affinity", "vehicle"], // whose width affinities read
        Step::Spectral => &["spectral"],
        Step::Kmeans => &["kmeans"],
        Step::Report => &["report", "vehicle"],
    }
}

/// The settings of `config` that `step` itself depends on, as text: equal where it does the same.
pub fn settings_of_step(config: &Config, step: Step) -> String {
    let sections = sections_of(step);
    let is_of_step = |key: &str| key.split_once('.').is_some_and(|(section, _)| sections.contains(&section));
    let settings = config.settings().filter(|(key, _)| is_of_step(key));
    settings.map(|(key, value)| format!("{key}={value}\n")).collect()
}

/// A zero tolerance that no eigenvalue of a Laplacian exceeds: a decomposition by it has all eigenvectors.
const ALL_ARE_ZEROS: f64 = 2.0;

/// Runs the stages of several configurations on one revolution. Each stage runs once for all configurations that agree in
/// its settings and in those of the stages before it: W is made once for all zero tolerances, and so is a full
/// decomposition, of which each tolerance takes the eigenvectors of its zeros.
pub struct Variants {
    branches: Vec<Branch>,
}

/// A stage with settings of its own, and those that go on from its result.
struct Branch {
    settings: String,
    run: Run,
    next: Vec<Branch>,
    /// Of the last stage: the configurations that end here, by their place.
    configurations: Vec<usize>,
}

enum Run {
    Stage(Worker),
    /// Counts the zeros of a full decomposition, with a τ that is no larger than any before.
    Recount(f64),
}

impl Branch {
    fn new(settings: String, run: Run) -> Self {
        Self { settings, run, next: Vec::new(), configurations: Vec::new() }
    }
}

/// τ, if `config` chose a full decomposition, which has the spectrum by every τ.
fn recounted_tolerance(config: &Config, registry: &Registry) -> Option<f64> {
    let kind = config.kind(&registry.spectral);
    let counts_below_tolerance = kind.params.iter().any(|spec| spec.name == ZERO_TOLERANCE.spec.name);
    let is_full = kind.properties.eigenvalues == Eigenvalues::All;
    (is_full && counts_below_tolerance).then(|| config.params("spectral").get(ZERO_TOLERANCE))
}

impl Variants {
    /// The stages that `configs` chose. All configurations must share the ingest settings.
    pub fn new(configs: &[&Config], registry: &Registry) -> Self {
        let mut falling: Vec<_> = configs
            .iter()
            .enumerate()
            .map(|(at, config)| (at, *config, recounted_tolerance(config, registry)))
            .collect();
        // The largest τ of a decomposition comes first, as a recount leaves the columns of U that smaller ones need.
        let tolerance = |tolerance: Option<f64>| tolerance.unwrap_or(0.0);
        falling.sort_by(|(.., a), (.., b)| tolerance(*b).total_cmp(&tolerance(*a)));
        let mut branches = Vec::new();
        for (place, config, tolerance) in falling {
            let widest = match tolerance {
                Some(_) => &config.with("spectral", ZERO_TOLERANCE.spec.name, Value::Float(ALL_ARE_ZEROS)),
                None => config,
            };
            let [weigh, decompose, cluster, report] = Engine::new(widest, registry).into();
            let settings = |step| settings_of_step(widest, step);
            let weighs = branch(&mut branches, settings(Step::Affinity), || Run::Stage(weigh));
            let decomposes = branch(&mut weighs.next, settings(Step::Spectral), || Run::Stage(decompose));
            let mut level = &mut decomposes.next;
            if let Some(tolerance) = tolerance {
                level = &mut branch(level, tolerance.to_string(), || Run::Recount(tolerance)).next;
            }
            let clusters = branch(level, settings(Step::Kmeans), || Run::Stage(cluster));
            let reports = branch(&mut clusters.next, settings(Step::Report), || Run::Stage(report));
            reports.configurations.push(place);
        }
        Self { branches }
    }

    /// Gives `frame` with the answer of each configuration to `each`, with the configuration's place. Where a stage failed,
    /// the failure is in the frame. The times in the frame are those of the stages that led to the answer.
    pub fn process(&mut self, frame: &mut Frame, each: &mut impl FnMut(usize, &mut Frame)) {
        walk(&mut self.branches, frame, each);
    }
}

/// The branch of `level` with these settings, which is added if there is none.
fn branch(level: &mut Vec<Branch>, settings: String, run: impl FnOnce() -> Run) -> &mut Branch {
    let known = level.iter().position(|branch| branch.settings == settings);
    let at = known.unwrap_or_else(|| {
        level.push(Branch::new(settings, run()));
        level.len() - 1
    });
    &mut level[at]
}

fn walk(branches: &mut [Branch], frame: &mut Frame, each: &mut impl FnMut(usize, &mut Frame)) {
    let notes = frame.notes.clone();
    let failure = frame.failure.take();
    for branch in branches {
        frame.notes.clone_from(&notes);
        frame.failure.clone_from(&failure);
        match &mut branch.run {
            Run::Stage(worker) => {
                worker.work(frame).ok(); // a failure travels in the frame
            }
            Run::Recount(_) if frame.failure.is_some() => {}
            Run::Recount(tolerance) => {
                let is_enough = recount(&mut frame.spectrum, *tolerance);
                assert!(is_enough, "the largest τ comes first");
            }
        }
        branch.configurations.iter().for_each(|place| each(*place, frame));
        walk(&mut branch.next, frame, each);
    }
    frame.failure = failure;
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use crosscut_stage::Point;

    use super::*;
    use crosscut_detector::{Layer, Preset};

    fn config(registry: &Registry, settings: &[&str]) -> Config {
        let settings: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
        let layers = [Preset::Paper.into(), Layer::settings("--set", &settings).expect("settings")];
        Config::resolve(registry, &layers).expect("known settings")
    }

    fn frame() -> Frame {
        let mut frame = Frame::default();
        let rows = [-3.0, 3.0].into_iter().flat_map(|y| (0..20).map(move |i| Point::new(0.2 * f64::from(i), y, 0.0)));
        frame.revolution.points_m.extend(rows);
        frame
    }

    #[test]
    fn each_configuration_has_the_answer_that_it_gives_alone() {
        let registry = Registry::standard();
        let settings: [&[&str]; 8] = [
            &[],
            &["spectral.kind=faer", "spectral.zero_tolerance=1e-3"],
            &["spectral.kind=faer", "spectral.zero_tolerance=0.7"],
            &["spectral.kind=faer", "spectral.zero_tolerance=1e-9", "kmeans.seed=7"],
            &["spectral.zero_tolerance=0.9"],
            &["affinity.sigma_per_m2=0.001"],
            &["kmeans.seed=7"],
            &["affinity.kind=threshold"],
        ];
        let configs: Vec<Config> = settings.iter().map(|settings| config(&registry, settings)).collect();
        let mut variants = Variants::new(&configs.iter().collect::<Vec<_>>(), &registry);
        for _ in 0..2 {
            let mut answers = vec![None; configs.len()];
            let mut shared = frame();
            variants.process(&mut shared, &mut |place, frame| {
                answers[place] = Some((frame.junction.clone(), frame.spectrum.clone(), frame.notes.clone()));
            });
            for (config, answer) in configs.iter().zip(answers) {
                let mut alone = frame();
                Engine::new(config, &registry).process(&mut alone).expect("an answer");
                let (junction, spectrum, notes) = answer.expect("given");
                assert_eq!(junction.junctions, alone.junction.junctions);
                assert_eq!((spectrum.k, spectrum.tolerance), (alone.spectrum.k, alone.spectrum.tolerance));
                assert_eq!(spectrum.margin_decades, alone.spectrum.margin_decades);
                assert_eq!((spectrum.eigenvalues, spectrum.u), (alone.spectrum.eigenvalues, alone.spectrum.u));
                assert!(notes.iter().eq(alone.notes.iter()));
            }
        }
    }

    #[test]
    fn a_sweep_over_the_zero_tolerance_decomposes_once() {
        let registry = Registry::standard();
        let with = |settings: &[&str]| config(&registry, settings);
        let configs = [
            with(&["spectral.kind=faer", "spectral.zero_tolerance=1e-9"]),
            with(&["spectral.kind=faer", "spectral.zero_tolerance=1e-3"]),
            with(&["spectral.zero_tolerance=1e-9"]),
            with(&["spectral.zero_tolerance=1e-3"]),
        ];
        let variants = Variants::new(&configs.iter().collect::<Vec<_>>(), &registry);
        assert_eq!(variants.branches.len(), 1, "one W");
        let spectral = &variants.branches[0].next;
        let counts: Vec<usize> = spectral.iter().map(|branch| branch.next.len()).collect();
        assert_eq!(counts, [2, 1, 1], "`slicing` finds no more eigenvectors than its tolerance asks for");
    }

    #[test]
    fn a_stage_runs_once_for_all_that_share_it_and_fails_alone() {
        let runs = Arc::new(AtomicUsize::new(0));
        let worker = |fails: bool| {
            let runs = runs.clone();
            Worker::new(Step::Affinity, move |_| {
                runs.fetch_add(1, Ordering::Relaxed);
                if fails { Err(crosscut_stage::StageError::TooLarge("no".to_owned())) } else { Ok(()) }
            })
        };
        let new = |fails| Branch::new(String::new(), Run::Stage(worker(fails)));
        let leaf = |place, fails| Branch { configurations: vec![place], ..new(fails) };
        let trunk = |next, fails| Branch { next, ..new(fails) };
        let branches = vec![trunk(vec![leaf(0, true), leaf(1, false)], false), trunk(vec![leaf(2, false)], true)];
        let mut variants = Variants { branches };
        let (mut frame, mut failed) = (Frame::default(), Vec::new());
        variants.process(&mut frame, &mut |place, frame| failed.push((place, frame.failure.is_some())));
        assert_eq!(failed, [(0, true), (1, false), (2, true)]);
        assert_eq!(runs.load(Ordering::Relaxed), 4, "what follows a failure does not run");
        assert!(frame.failure.is_none());
    }
}
