//! `crosscut explore`: missions in closed loop through simulated mines.

mod args;
mod job;
mod outcome;
#[cfg(feature = "rerun")]
mod save;
mod table;

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crosscut_detector::{Config, Registry};
use crosscut_missions::{About, Flown, Journal, Moment, ResumeError, Setup, fly};
use crosscut_navigate::{PlannerKind, planners};
use crosscut_outfile::Keep;
use crosscut_pipeline::StopFlag;
use crosscut_simulator::{Agility, Family, Plan, Scene, World, families};
use indicatif::ProgressBar;
use serde_json::Value;

pub(crate) use self::args::ExploreArgs;
use self::job::{Job, Place};
#[cfg(feature = "rerun")]
use self::save::Saved;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError, chosen};
#[cfg(not(feature = "rerun"))]
use crate::gate::Saved;
use crate::input::text_file::of_plan;
use crate::interrupt::stop_on_interrupt;
use crate::output::{Document, files, progress, say, show};

/// Flies missions, or lists what there is.
pub(crate) fn explore(args: &ExploreArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    if args.list {
        return list();
    }
    let config = args.config.resolve(registry)?;
    let planner = chosen("planner", &args.planner, planners(), |planner| planner.name)?;
    let jobs = jobs(args)?;
    let of_one = [("--save", &args.save), ("--journal", &args.journal), ("--resume", &args.resume)];
    if let (Some((option, _)), true) = (of_one.iter().find(|(_, path)| path.is_some()), jobs.len() > 1) {
        return Err(UsageError(format!("{option} is for one mission: name it, with one --seed")).into());
    }
    let read: Vec<PathBuf> = args.plan.iter().chain(&args.config.config).chain(&args.resume).cloned().collect();
    let written: Vec<&Path> = args.json.iter().chain(&args.save).chain(&args.journal).map(PathBuf::as_path).collect();
    files::refuse(&written, &read)?;
    let stop = stop_on_interrupt()?;
    let mut json = args.json.as_deref().map(|path| Document::create(path, &read, Keep::ThroughKill)).transpose()?;
    let fleet = Fleet { config: &config, registry, planner: *planner, stop: &stop };
    let bar = progress::bar(None, args.quiet);
    let mut diagnostics = Diagnostics::default();
    let flown = if let [job] = &jobs[..] {
        vec![Some(fleet.fly_alone(job, args, &bar, &mut diagnostics)?)]
    } else {
        fleet.fly_all(&jobs, &bar)
    };
    bar.finish_and_clear();
    let missions: Vec<(&Job, &Flown)> =
        jobs.iter().zip(&flown).filter_map(|(job, flown)| Some((job, flown.as_ref()?))).collect();
    if let Some(out) = &mut json {
        let outcome = match &missions[..] {
            [(job, flown)] if jobs.len() == 1 => outcome::whole(job, flown),
            several => Value::Array(several.iter().map(|(job, flown)| outcome::figures(job, flown)).collect()),
        };
        out.write(&format!("{outcome}\n"))?;
    }
    if !args.quiet {
        match &missions[..] {
            [(_, flown)] if jobs.len() == 1 => say(outcome::words(flown)),
            several if args.json.as_deref() != Some(Path::new("-")) => show(table::table(several))?,
            _ => {}
        }
    }
    if let Some((job, failure)) = missions.iter().find_map(|(job, flown)| Some((job, flown.failure.as_ref()?))) {
        anyhow::bail!("mission {} of seed {}: {failure}", job.name, job.seed);
    }
    if stop.is_set() {
        diagnostics.interrupt();
    }
    Ok(diagnostics.outcome())
}

/// Selects every mission.
const ALL: &str = "all";

fn jobs(args: &ExploreArgs) -> anyhow::Result<Vec<Job>> {
    if let Some(path) = &args.plan {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let job = |seed, world| Job { name: name.clone().into_owned(), seed, place: Place::Plan(Box::new(world)) };
        let of_seed = |plan: &Plan, seed| plan.world(seed).map(|world| job(seed, world));
        return Ok(of_plan(path, |plan| args.seed.clone().map(|seed| of_seed(&plan, seed)).collect())?);
    }
    let chosen: Vec<&Family> = match &args.mission {
        Some(name) if name == ALL => families().iter().collect(),
        Some(name) => vec![
            chosen("mission", name, families(), |family| family.name)
                .map_err(|UsageError(refused)| UsageError(format!("{refused}; or `{ALL}` of them")))?,
        ],
        None => {
            let usage = "name a mission, `all` of them, or --plan PLAN.json; --list shows the missions";
            return Err(UsageError(usage.to_owned()).into());
        }
    };
    let of_family = |family: &'static Family| {
        args.seed.clone().map(move |seed| Job { name: family.name.to_owned(), seed, place: Place::Family(family) })
    };
    Ok(chosen.into_iter().flat_map(of_family).collect())
}

/// What missions are flown with.
struct Fleet<'a> {
    config: &'a Config,
    registry: &'a Registry,
    planner: PlannerKind,
    stop: &'a StopFlag,
}

impl Fleet<'_> {
    /// One mission, with its journal and its recording. If it cannot be recorded, it is flown all the same.
    fn fly_alone(
        &self,
        job: &Job,
        args: &ExploreArgs,
        bar: &ProgressBar,
        diagnostics: &mut Diagnostics,
    ) -> anyhow::Result<Flown> {
        let world = job.world();
        let about = About::new(&job.name, job.seed, &world, &self.planner, self.config);
        let past =
            args.resume.as_deref().map(|path| about.past(path)).transpose().map_err(refused)?.unwrap_or_default();
        #[cfg(feature = "rerun")]
        let mut saved = Saved::open(args, &job.name, self.config, &world, diagnostics);
        #[cfg(not(feature = "rerun"))]
        let mut saved = if args.save.is_some() { return Err(crate::gate::without_rerun()) } else { None::<Saved> };
        let mut journal = args.journal.as_deref().map(|path| Journal::create(path, &about)).transpose()?;
        let flown = self.fly(&world, job.seed, &past, bar, &mut |moment| {
            if let Some(journal) = &mut journal {
                journal.add(moment);
            }
            if let Some(saved) = &mut saved {
                saved.add(moment);
            }
        });
        let lost = journal.and_then(|journal| journal.finish().err());
        diagnostics.lost_all(lost.map(|error| format!("{:#}", anyhow::Error::from(error))));
        diagnostics.lost_all(saved.and_then(|saved| saved.finish(&flown).err()));
        Ok(flown)
    }

    fn fly(
        &self,
        world: &World,
        seed: u64,
        past: &[Scene],
        bar: &ProgressBar,
        watch: &mut dyn FnMut(&Moment),
    ) -> Flown {
        let Self { config, registry, planner, .. } = *self;
        let setup = Setup { config, registry, planner, agility: Agility::default(), seed, past };
        fly(world, &setup, &mut |moment| {
            bar.inc(1);
            watch(moment);
            !self.stop.is_set()
        })
    }

    /// Flies the missions on all cores; `None` for those that an interrupt left out.
    fn fly_all(&self, jobs: &[Job], bar: &ProgressBar) -> Vec<Option<Flown>> {
        let flown: Vec<Mutex<Option<Flown>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some((job, slot)) = (!self.stop.is_set())
                .then(|| next.fetch_add(1, Ordering::Relaxed))
                .and_then(|number| jobs.get(number).zip(flown.get(number)))
            {
                let one = self.fly(&job.world(), job.seed, &[], bar, &mut |_| {});
                *slot.lock().expect("nobody panics while holding it") = Some(one);
            }
        };
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get).min(jobs.len());
        std::thread::scope(|scope| {
            for number in 1..threads {
                let named = std::thread::Builder::new().name(format!("mission-{number}"));
                if named.spawn_scoped(scope, work).is_err() {
                    break; // the threads that there are do all the work
                }
            }
            work();
        });
        flown.into_iter().map(|slot| slot.into_inner().expect("nobody panics while holding it")).collect()
    }
}

/// A journal of another mission is a mistake of whoever named it.
fn refused(error: ResumeError) -> anyhow::Error {
    match error {
        ResumeError::OtherMission { .. } => UsageError(error.to_string()).into(),
        ResumeError::Unreadable(error) => error.into(),
        ResumeError::NoFlight { .. } => error.into(),
    }
}

fn list() -> anyhow::Result<Outcome> {
    let mut text = String::from("missions, a different world for each seed (`all`: every one of them):\n");
    for family in families() {
        text += &format!("  {:<18}{}\n", family.name, family.doc);
    }
    text += "\nplanners (--planner NAME):\n";
    for planner in planners() {
        text += &format!("  {:<18}{}\n", planner.name, planner.doc);
    }
    show(text)?;
    Ok(Outcome::Done)
}
