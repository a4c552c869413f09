//! `crosscut report`: a flight as one HTML page that needs no other file and no network.

mod course;
mod page;
mod places;

use std::io::Write as _;
use std::path::Path;

use anyhow::Context;
use crosscut_detector::{Config, Registry};
use crosscut_evaluate::Evaluation;
use crosscut_flight::Mapper;
use crosscut_ingest::{Recording, Truths, recordings_in};
use crosscut_pipeline::{End, StopFlag, StreamOptions, Summary, stream};
use crosscut_stage::Frame;

use self::course::Course;
use self::places::Places;
use crate::cli::ReportArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::interrupt::stop_on_interrupt;
use crate::say::say;
use crate::scoring::{NotCompared, TruthQueue, WithTruth};
use crate::{config, flight, outputs, progress};

/// What the page shows of a flight.
struct Flown {
    title: String,
    config: Config,
    summary: Summary,
    course: Course,
    mapper: Mapper,
    places: Places,
    /// Against the truth, if the recording has one.
    evaluation: Option<Evaluation>,
    lost: Vec<String>,
}

/// Runs the flight and writes its page.
pub(crate) fn report(args: &ReportArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = config::resolve(&args.config, registry)?;
    let mut read = recordings_in(&args.flight.input)?;
    read.extend(args.config.config.clone());
    let mut out = outputs::create(&args.out, &read)?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;
    let recording = flight::open(&args.flight, &config)?;
    let truths = match &args.flight.input[..] {
        [only] => Truths::open(only).ok().map(|truths| (truths, only.as_path())),
        _ => None,
    };
    let names = args.flight.input.iter().map(|path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy());
    let title = names.collect::<Vec<_>>().join(", ");
    let flown = fly(title, recording, truths, config, registry, &stop, args.quiet)?;
    let mut diagnostics = Diagnostics::default();
    diagnostics.ended(&flown.summary)?;
    if flown.summary.revolutions == 0 && matches!(flown.summary.end, End::Complete) {
        anyhow::bail!("no scan could be read");
    }
    let cannot = || format!("cannot write {}", args.out.display());
    out.write_all(page::html(&flown).as_bytes()).and_then(|()| out.flush()).with_context(cannot)?;
    if !args.quiet {
        say(flown.mapper.map().summary());
    }
    diagnostics.lost_all(&flown.lost);
    Ok(diagnostics.outcome())
}

fn fly(
    title: String,
    mut recording: Recording,
    truths: Option<(Truths, &Path)>,
    config: Config,
    registry: &Registry,
    stop: &StopFlag,
    quiet: bool,
) -> anyhow::Result<Flown> {
    let bar = progress::bar(recording.total_revolutions(), quiet);
    let (mut course, mut mapper, mut places) = (Course::default(), Mapper::default(), Places::default());
    let queue = TruthQueue::default();
    let (mut evaluation, mut not_compared) = (truths.is_some().then(Evaluation::default), NotCompared::default());
    let mut sink = |frame: &Frame| {
        bar.inc(1);
        course.take(frame);
        mapper.add(frame);
        places.take(frame);
        if let Some(evaluation) = &mut evaluation {
            match queue.compare(frame) {
                Ok((_, score)) => evaluation.add(&score),
                Err(reason) => not_compared.add(reason),
            }
        }
        Ok(())
    };
    let options = StreamOptions { stop: stop.clone(), flight: true, ..StreamOptions::default() };
    let (ran, recording, not_compared) = match truths {
        Some((truths, path)) => {
            let mut source = WithTruth { recording, truths, queue: &queue };
            let ran = stream(&mut source, &config, registry, &mut sink, &mut [], &options);
            (ran, source.recording, not_compared.messages(path))
        }
        None => (stream(&mut recording, &config, registry, &mut sink, &mut [], &options), recording, Vec::new()),
    };
    bar.finish_and_clear();
    let summary = ran.context("a thread could not be started")?;
    let lost = recording.losses().iter().map(ToString::to_string).chain(not_compared).collect();
    Ok(Flown { title, config, summary, course, mapper, places, evaluation, lost })
}
