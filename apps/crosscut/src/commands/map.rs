//! `crosscut map`: the junctions and dead ends of a flight and the passages between them, as a drawing or for other tools.

use anyhow::Context;
use crosscut_detector::Registry;
use crosscut_flight::Mapper;
use crosscut_ingest::recordings_in;
use crosscut_pipeline::{StopFlag, StreamOptions, stream};
use crosscut_stage::Frame;

use crate::cli::MapArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::Outcome;
use crate::interrupt::stop_on_interrupt;
use crate::say::say;
use crate::{config, flight, maps, outputs, progress};

/// Runs the flight and writes its map.
pub(crate) fn map(args: &MapArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let config = config::resolve(&args.config, registry)?;
    let read = recordings_in(&args.flight.input)?;
    let mut out = outputs::create(&args.out, &read)?;
    let stop = StopFlag::default();
    stop_on_interrupt(stop.clone())?;
    let mut recording = flight::open(&args.flight, &config)?;
    let bar = progress::bar(recording.total_revolutions(), args.quiet);
    let mut mapper = Mapper::default();
    let mut sink = |frame: &Frame| {
        bar.inc(1);
        mapper.add(frame);
        Ok(())
    };
    let options = StreamOptions { stop, flight: true, ..StreamOptions::default() };
    let ran = stream(&mut recording, &config, registry, &mut sink, &mut [], &options);
    bar.finish_and_clear();
    let summary = ran.context("a thread could not be started")?;
    let mut diagnostics = Diagnostics::default();
    diagnostics.ended(&summary)?;
    let cannot = || format!("cannot write {}", args.out.display());
    out.write_all(maps::text(&args.out, &mapper).as_bytes()).and_then(|()| out.flush()).with_context(cannot)?;
    let map = mapper.map();
    if !args.quiet {
        say(map.summary());
    }
    if map.nodes.is_empty() {
        diagnostics.note("no junction or dead end was found; a place is known once the scans have seen all around it");
    }
    diagnostics.lost_all(recording.losses());
    Ok(diagnostics.outcome())
}
