//! Recordings shown again: the parts of a flight together, two flights side by side, a flight with what else its MCAP
//! recording holds.
//!
//! Messages are read from the files one by one, changed where they must be, and handed to the native viewer's standard
//! input or to a server; of the values no more than a revolution is kept here, whatever the size of the recording.

mod control;
mod differences;
mod error;
mod flight;
mod sensors;

use std::fs::File;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rerun::log::LogMsg;
use rerun::sink::LogSink as _;

pub use self::error::ShowError;
use self::flight::{Destination, Flight};
use crate::RecorderError;
use crate::layout::{self, Layout, Shown, Side};
use crate::schema::REPORT_JUNCTIONS;
use crate::serving::{self, Served};
use crate::viewer::Viewer;

/// Where two flights are put that are seen side by side.
const LEFT: &str = "left";
const RIGHT: &str = "right";

/// What to show.
#[derive(Clone, Debug, Default)]
pub struct Show {
    /// The parts of one flight. Those that lie beside a single one (FILE-2.rrd, FILE-3.rrd...) come with it.
    pub flight: Vec<PathBuf>,
    /// The parts of another flight, to see beside it.
    pub beside: Vec<PathBuf>,
    /// MCAP recordings of the same time: point clouds, cameras and transforms.
    pub sensors: Vec<PathBuf>,
    /// The page to open with. If none: the page that only this combination has, or that of the recording.
    pub layout: Option<Layout>,
    /// The revolution to open at, in a viewer; if none, the last.
    pub at: Option<u64>,
}

impl Show {
    /// Shows everything in the native viewer, and returns when it is closed. Gives what could not be shown.
    ///
    /// # Errors
    /// When a file is no recording, or there is no viewer.
    pub fn in_viewer(&self) -> Result<Vec<String>, ShowError> {
        let opened = self.open()?;
        let port = self.at.map(|_| free_port()).transpose()?;
        let mut viewer = Viewer::start("rerun", port)?;
        let mut damages = opened.send(&mut |message| viewer.take(&message))?;
        viewer.end();
        let recorded = opened.flight.recording.entities().get(REPORT_JUNCTIONS.path).and_then(|of| of.revolutions);
        if let (Some(at), Some(port), Some(recorded)) = (self.at, port, recorded) {
            damages.extend(take_to(at, recorded, port, || viewer.is_open()).err());
        }
        viewer.wait()?;
        Ok(damages)
    }

    /// Serves everything at `address` until `stopped` says so; `announce` is told where. Gives what could not be shown.
    ///
    /// # Errors
    /// When a file is no recording, or the address cannot be listened at.
    pub fn served(
        &self,
        address: SocketAddr,
        announce: impl FnOnce(&Served),
        stopped: impl Fn() -> bool,
    ) -> Result<Vec<String>, ShowError> {
        let opened = self.open()?;
        let server = serving::open(address)?;
        announce(&server.served);
        let damages = opened.send(&mut |message| {
            server.sink.send(message);
            !stopped()
        })?;
        while !stopped() {
            std::thread::sleep(Duration::from_millis(100));
        }
        Ok(damages)
    }

    /// Before there is a viewer: all files have to be there.
    fn open(&self) -> Result<Opened<'_>, ShowError> {
        for path in &self.sensors {
            let cannot = |error: std::io::Error| ShowError::Sensors { path: path.clone(), cause: error.to_string() };
            File::open(path).map_err(cannot)?;
        }
        let flight = Flight::open(&self.flight)?;
        let beside = if self.beside.is_empty() { None } else { Some(Flight::open(&self.beside)?) };
        Ok(Opened { show: self, flight, beside })
    }
}

struct Opened<'a> {
    show: &'a Show,
    flight: Flight,
    beside: Option<Flight>,
}

impl Opened<'_> {
    /// Hands over everything, the layout last. Gives what could not be read.
    fn send(&self, take: &mut dyn FnMut(LogMsg) -> bool) -> Result<Vec<String>, ShowError> {
        let Self { show, flight, beside } = self;
        let (store, first, extent) = (flight.store(), show.layout, flight.extent());
        let own_layout = first.is_none() && beside.is_none() && show.sensors.is_empty();
        let at = |below: Option<&str>, without| Destination {
            store: store.clone(),
            below: below.map(Into::into),
            own_layout,
            without,
        };
        if let Some(beside) = beside {
            flight.send(&at(Some(LEFT), |_| false), take)?;
            beside.send(&at(Some(RIGHT), differences::is_recolored), take)?;
            let files = names([&show.flight[0], &show.beside[0]]);
            let recordings = [&flight.recording, &beside.recording];
            let names = differences::titles(&files, recordings);
            differences::messages(store, &names, &files, recordings)?.into_iter().all(&mut *take);
            let [left, right] = &names;
            let left = Side { below: LEFT, name: left, extent };
            let right = Side { below: RIGHT, name: right, extent: beside.extent() };
            lay_out(&Shown::Beside { first, sides: [left, right] }, take)?;
            return Ok(flight.damages().chain(beside.damages()).collect());
        }
        flight.send(&at(None, |_| false), take)?;
        if !show.sensors.is_empty() {
            let (revolutions, mut pictures) = (flight.revolutions(), Vec::new());
            for path in &show.sensors {
                pictures.extend(sensors::send(path, store, &revolutions, take)?);
            }
            sensors::tie(store, &flight.recording)?.into_iter().all(&mut *take);
            lay_out(&Shown::Sensors { first, extent, root: sensors::ROOT, pictures: &pictures }, take)?;
        } else if let Some(first) = first {
            lay_out(&Shown::Flight { first, extent }, take)?;
        }
        Ok(flight.damages().collect())
    }
}

/// Takes the viewer that listens at `port` to a revolution. The error says in words why it is not shown.
fn take_to(at: u64, [first, last]: [i64; 2], port: u16, is_open: impl FnMut() -> bool) -> Result<(), String> {
    match i64::try_from(at).ok().filter(|at| (first..=last).contains(at)) {
        None => Err(format!("there is no revolution {at}: the recording has {first} to {last}")),
        Some(at) => control::go_to(port, at, last, is_open)
            .map_err(|cause| format!("the viewer does not open at revolution {at}: {cause}")),
    }
}

/// A port that nobody listens at.
fn free_port() -> Result<u16, RecorderError> {
    let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|listener| listener.local_addr());
    taken.map(|address| address.port()).map_err(|error| RecorderError::Viewer(error.to_string()))
}

fn lay_out(shown: &Shown, take: &mut dyn FnMut(LogMsg) -> bool) -> Result<(), ShowError> {
    let messages = layout::messages(shown).map_err(RecorderError::from)?;
    messages.into_iter().all(take);
    Ok(())
}

/// What two files are called in titles: their names without the ending, with as many of their folders as tell them
/// apart.
fn names(paths: [&Path; 2]) -> [String; 2] {
    let parts = |path: &Path| -> Vec<String> {
        path.with_extension("").iter().map(|part| part.to_string_lossy().into_owned()).collect()
    };
    let [a, b] = paths.map(parts);
    let alike = a.iter().rev().zip(b.iter().rev()).take_while(|(a, b)| a == b).count();
    [a, b].map(|parts| parts[parts.len().saturating_sub(alike + 1)..].join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_files_are_told_apart_by_their_names_or_else_by_their_folders() {
        let names = |a: &str, b: &str| names([Path::new(a), Path::new(b)]);
        assert_eq!(names("out/paper.rrd", "default.rrd"), ["paper", "default"]);
        assert_eq!(names("old/out/tee.rrd", "new/out/tee.rrd"), ["old/out/tee", "new/out/tee"]);
        assert_eq!(names("tee.rrd", "new/tee.rrd"), ["tee", "new/tee"]);
        assert_eq!(names("tee.rrd", "tee.rrd"), ["tee", "tee"]);
    }
}
