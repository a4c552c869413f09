//! Several configurations on one revolution.

use crosscut_stage::{Frame, Step};

use crate::engine::Worker;
use crate::{Config, Engine, Registry};

/// The sections whose settings a step depends on, beside those of the steps before it.
fn sections_of(step: Step) -> &'static [&'static str] {
    match step {
        Step::Ingest => &["csv", "ingest"],
        Step::Affinity => &["pipeline", "affinity"],
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

/// Runs the stages of several configurations on one revolution. Each stage runs once for all configurations that agree in
/// its settings and in those of the stages before it: W is made once for all zero tolerances.
pub struct Variants {
    branches: Vec<Branch>,
}

/// A stage with settings of its own, and those that go on from its result.
struct Branch {
    settings: String,
    worker: Worker,
    next: Vec<Branch>,
    /// Of the last stage: the configurations that end here, by their place.
    configurations: Vec<usize>,
}

impl Variants {
    /// The stages that `configs` chose. How scans are read is not theirs: they are to agree in that.
    pub fn new(configs: &[&Config], registry: &Registry) -> Self {
        let mut branches = Vec::new();
        for (place, config) in configs.iter().enumerate() {
            let Engine { weigh, decompose, cluster, report } = Engine::new(config, registry);
            let mut level: &mut Vec<Branch> = &mut branches;
            let mut last = None;
            for worker in [weigh, decompose, cluster, report] {
                let settings = settings_of_step(config, worker.step);
                let known = level.iter().position(|branch| branch.settings == settings);
                let at = known.unwrap_or_else(|| {
                    level.push(Branch { settings, worker, next: Vec::new(), configurations: Vec::new() });
                    level.len() - 1
                });
                let branch = &mut level[at];
                last = Some(&mut branch.configurations);
                level = &mut branch.next;
            }
            last.expect("there are four stages").push(place);
        }
        Self { branches }
    }

    /// Gives `frame` with the answer of each configuration to `each`, with the configuration's place. Where a stage failed,
    /// the failure is in the frame. The times in the frame are those of the stages that led to the answer.
    pub fn process(&mut self, frame: &mut Frame, each: &mut impl FnMut(usize, &Frame)) {
        walk(&mut self.branches, frame, each);
    }
}

fn walk(branches: &mut [Branch], frame: &mut Frame, each: &mut impl FnMut(usize, &Frame)) {
    let notes = frame.notes.clone();
    let failure = frame.failure.take();
    for branch in branches {
        frame.notes.clone_from(&notes);
        frame.failure.clone_from(&failure);
        branch.worker.work(frame).ok(); // a failure travels in the frame
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
    use crate::{Layer, Preset};

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
        let settings: [&[&str]; 5] = [
            &[],
            &["spectral.zero_tolerance=1e-3"],
            &["affinity.sigma_per_m2=0.001"],
            &["kmeans.seed=7"],
            &["affinity.kind=dbscan"],
        ];
        let configs: Vec<Config> = settings.iter().map(|settings| config(&registry, settings)).collect();
        let mut variants = Variants::new(&configs.iter().collect::<Vec<_>>(), &registry);
        for _ in 0..2 {
            let mut answers = vec![None; configs.len()];
            let mut shared = frame();
            variants.process(&mut shared, &mut |place, frame| {
                answers[place] =
                    Some((frame.junction.clone(), frame.spectrum.eigenvalues.clone(), frame.notes.clone()));
            });
            for (config, answer) in configs.iter().zip(answers) {
                let mut alone = frame();
                Engine::new(config, &registry).process(&mut alone).expect("an answer");
                let (junction, eigenvalues, notes) = answer.expect("given");
                assert_eq!((junction.junctions, eigenvalues), (alone.junction.junctions, alone.spectrum.eigenvalues));
                assert!(notes.iter().eq(alone.notes.iter()));
            }
        }
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
        let leaf = |place, fails| Branch {
            settings: String::new(),
            worker: worker(fails),
            next: Vec::new(),
            configurations: vec![place],
        };
        let trunk =
            |next, fails| Branch { settings: String::new(), worker: worker(fails), next, configurations: Vec::new() };
        let branches = vec![trunk(vec![leaf(0, true), leaf(1, false)], false), trunk(vec![leaf(2, false)], true)];
        let mut variants = Variants { branches };
        let (mut frame, mut failed) = (Frame::default(), Vec::new());
        variants.process(&mut frame, &mut |place, frame| failed.push((place, frame.failure.is_some())));
        assert_eq!(failed, [(0, true), (1, false), (2, true)]);
        assert_eq!(runs.load(Ordering::Relaxed), 4, "what follows a failure does not run");
        assert!(frame.failure.is_none());
    }
}
