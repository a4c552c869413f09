//! `crosscut report`: a flight as one HTML page that needs no other file and no network.

mod course;
mod page;
mod places;

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};
use crosscut_detector::Registry;
use crosscut_evaluate::Evaluation;
use crosscut_flight::{MapDrawing, Mapper, NoPlace};
use crosscut_outfile::Keep;
use crosscut_stage::Frame;

use self::course::Course;
use self::places::Places;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::fly::{How, fly};
use crate::input::{ConfigArgs, Flight, InputArgs, Judged, files_read};
use crate::interrupt::stop_on_interrupt;
use crate::output::{Document, Look, progress, say};
use crate::values::has_extension;

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    config: ConfigArgs,
    /// The page. It needs no other file and no network.
    #[arg(short, long, value_name = "FILE.html", value_parser = PathBufValueParser::new().try_map(html_path))]
    out: PathBuf,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    quiet: bool,
}

fn html_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    let is_html = has_extension(&path, "html") || has_extension(&path, "htm");
    if is_html { Ok(path) } else { Err("the page is an HTML file: FILE.html") }
}

/// What the page shows of the revolutions of a flight.
#[derive(Default)]
struct Shown {
    course: Course,
    mapper: Mapper,
    no_place: NoPlace,
    seen: MapDrawing,
    places: Places,
    /// Against the truth, if the recording has one.
    evaluation: Evaluation,
}

impl Shown {
    fn take(&mut self, frame: &Frame, judged: Option<&Judged>) {
        self.course.take(frame);
        self.mapper.add(frame);
        self.no_place.add(frame);
        self.seen.add(frame, &self.mapper);
        self.places.take(frame);
        if let Some(judged) = judged {
            self.evaluation.add(&judged.score);
        }
    }
}

/// Runs the flight and writes its page.
pub(crate) fn report(args: &ReportArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = args.config.resolve(registry)?;
    let read = files_read(&args.input, args.config.config.clone())?;
    let stop = stop_on_interrupt()?;
    let mut out = Document::create(&args.out, &read, Keep::ThroughKill)?;
    let input = &args.input.recordings.input;
    let mut flight = Flight::open_with_truths(input, &args.input, &config)?;
    let has_truth = flight.has_truths();
    let bar = progress::bar(flight.total_revolutions(), args.quiet);
    let how = How { registry, stop: &stop, bar: &bar, rate: None, has_poses: true };
    let mut shown = Shown::default();
    let flown = fly(flight, &config, &how, &mut [], &mut |frame, judged| {
        shown.take(frame, judged);
        Ok(())
    })?;
    bar.finish_and_clear();
    if !flown.is_empty() {
        let names = input.iter().map(|path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy());
        let title = names.collect::<Vec<_>>().join(", ");
        let look = Look::with(&args.input, &args.config);
        let page = page::html(&title, (args.config.preset(), &config), &flown, &shown, has_truth, &look);
        out.write(&page)?;
        if !args.quiet {
            let map = shown.mapper.map();
            say(shown.no_place.reason(&map).unwrap_or_else(|| map.summary()));
        }
    }
    let mut diagnostics = Diagnostics::default();
    flown.report(None, &mut diagnostics);
    Ok(diagnostics.outcome())
}
