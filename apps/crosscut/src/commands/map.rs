//! `crosscut map`: the junctions and dead ends of a flight and the passages between them, as a drawing or for other tools.

use crosscut_detector::Registry;
use crosscut_flight::{Mapper, NoPlace};

use crate::cli::MapArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::fly::{Flight, How, files_read, fly};
use crate::interrupt::stop_on_interrupt;
use crate::map_file::MapFile;
use crate::maps;
use crate::progress;
use crate::say::{say, show};

/// Runs the flight and writes its map.
pub(crate) fn map(args: &MapArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = args.config.resolve(registry)?;
    let read = files_read(&args.input, args.config.config.clone())?;
    let stop = stop_on_interrupt()?;
    let mut flight = Flight::open(&args.input.recordings.input, &args.input, &config)?;
    let mut file = args.out.as_deref().map(|out| MapFile::create(out, &read)).transpose()?;
    let mut mapper = Mapper::default();
    let mut no_place = NoPlace::default();
    let bar = progress::bar(flight.total_revolutions(), args.quiet);
    let how = How { registry, stop: &stop, bar: &bar, rate: None, has_poses: true };
    let flown = fly(flight, &config, &how, &mut [], &mut |frame, _| {
        mapper.add(frame);
        no_place.add(frame);
        if let Some(file) = &mut file {
            file.take(frame, &mapper, &no_place);
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    let mut diagnostics = Diagnostics::default();
    flown.report(None, &mut diagnostics);
    if flown.is_empty() {
        return Ok(diagnostics.outcome());
    }
    if let Some(file) = &mut file {
        file.finish(&mapper, &no_place)?;
    }
    let map = mapper.map();
    if args.json {
        show(format!("{}\n", maps::json(&map)))?;
    }
    if !args.quiet {
        say(map.summary());
    }
    if let Some(reason) = no_place.reason(&map) {
        diagnostics.note(reason);
    }
    Ok(diagnostics.outcome())
}
