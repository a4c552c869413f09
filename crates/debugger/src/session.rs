//! The session: a flight in memory, and where it stands.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crosscut_detector::{Config, ConfigError, Layer, Registry};
use crosscut_evaluate::settings_of_step;
use crosscut_messages::Truth;
use crosscut_stage::{Frame, Observer, ObserverError, Step, counted};

use crate::Refused;
use crate::side::{Answer, Given, Means, Scan, Side};
use crate::when::When;

/// Reads the flight with the settings of a configuration; the error says why it cannot.
pub type Reader = Box<dyn FnMut(&Config) -> Result<Vec<Scan>, String>>;

/// A flight that answers back.
pub struct Session {
    pub(crate) means: Means,
    /// The layers of the settings at the start.
    pub(crate) layers: Vec<Layer>,
    /// The settings at the start.
    pub(crate) start: Config,
    /// What was set since, `section.key` and its value; a later one wins.
    pub(crate) changes: Vec<[String; 2]>,
    reader: Reader,
    /// The place of the present revolution in the flight.
    pub(crate) at: usize,
    pub(crate) now: Side,
    pub(crate) held: Option<Side>,
    /// What `again` compares with: before the first change since the whole flight was answered.
    pub(crate) before: Option<(Given, Option<Vec<Answer>>)>,
    pub(crate) breaks: Vec<When>,
    /// How often what there is to see became another.
    pub(crate) version: u64,
    /// How often something was held.
    pub(crate) holds: u64,
}

impl Session {
    /// Reads the flight with the settings of `layers` and goes to its first revolution.
    ///
    /// # Errors
    /// When the settings are not allowed, the flight cannot be read, or has no scan.
    pub fn new(registry: Registry, layers: Vec<Layer>, mut reader: Reader) -> Result<Self, Refused> {
        let start = Config::resolve(&registry, &layers).map_err(refused)?;
        let flight = read(&mut reader, &start)?;
        let given = Given { config: start.clone(), flight: Arc::new(flight), injected: BTreeMap::new() };
        let means = Means { registry, stop: Arc::default() };
        let mut now = Side::new(given, &means);
        now.go_to(0);
        Ok(Self {
            means,
            layers,
            start,
            changes: Vec::new(),
            reader,
            at: 0,
            now,
            held: None,
            before: None,
            breaks: Vec::new(),
            version: 0,
            holds: 0,
        })
    }

    /// The present revolution with all that the stages made of it.
    pub fn frame(&self) -> &Frame {
        &self.now.frame
    }

    /// The same revolution by the held settings, if there are any and they have it.
    pub fn held_frame(&self) -> Option<&Frame> {
        self.held.as_ref().map(|held| &held.frame).filter(|held| held.revolution.seq == self.frame().revolution.seq)
    }

    /// The present settings.
    pub fn config(&self) -> &Config {
        &self.now.given.config
    }

    /// The held settings, if there are any.
    pub fn held_config(&self) -> Option<&Config> {
        self.held.as_ref().map(|held| &held.given.config)
    }

    /// Another number once something else is held.
    pub fn holds(&self) -> u64 {
        self.holds
    }

    /// The truth of the present revolution, if the recording has one.
    pub fn truth(&self) -> Option<&Truth> {
        self.now.given.flight[self.at].truth.as_ref()
    }

    /// The revolutions that have a truth, with it.
    pub fn truths(&self) -> impl Iterator<Item = (u64, &Truth)> {
        self.now.given.flight.iter().filter_map(|scan| Some((scan.revolution.seq, scan.truth.as_ref()?)))
    }

    /// Another number once the present revolution, its answer or what is held became another.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Number of revolutions of the flight.
    pub fn revolutions(&self) -> usize {
        self.now.given.flight.len()
    }

    /// The kinds of stages that there are. Those that are in use have to stay.
    pub fn registry_mut(&mut self) -> &mut Registry {
        &mut self.means.registry
    }

    /// A flag that stops the command at work. Whoever sets it takes it back before the next command.
    pub fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.means.stop)
    }

    /// Shows every frame of the flight with the present settings to an observer, in order, and ends that. The frames have
    /// poses and places. Returns how many were shown before somebody asked to stop.
    ///
    /// # Errors
    /// Of the observer.
    pub fn show_all(&mut self, observer: &mut dyn Observer) -> Result<usize, ObserverError> {
        self.now.show_all(observer, &self.means)
    }

    /// The flight in a sentence.
    pub fn greeting(&self) -> String {
        let flight = &self.now.given.flight;
        let truth = if flight.iter().any(|scan| scan.truth.is_some()) { ", with their truth" } else { "" };
        let last_s = self.seconds(flight.len() - 1);
        format!("{} over {last_s:.1} s{truth}; `help` lists the commands", counted(flight.len() as u64, "revolution"))
    }

    /// Takes other settings, unless they are not allowed or the flight cannot be read with them.
    pub(crate) fn configure(&mut self, changes: Vec<[String; 2]>) -> Result<(), Refused> {
        let settings: Vec<String> = changes.iter().map(|[key, value]| format!("{key}={value}")).collect();
        let mut layers = self.layers.clone();
        layers.push(Layer::settings("set", &settings).map_err(refused)?);
        let config = Config::resolve(&self.means.registry, &layers).map_err(refused)?;
        let is_read_alike = settings_of_step(&config, Step::Ingest) == settings_of_step(self.config(), Step::Ingest)
            && (self.config().takes_cloud() || !config.takes_cloud());
        let flight =
            if is_read_alike { Arc::clone(&self.now.given.flight) } else { Arc::new(read(&mut self.reader, &config)?) };
        let injected = self.now.given.injected.clone();
        self.changes = changes;
        self.give(Given { config, flight, injected });
        Ok(())
    }

    /// Answers the present revolution as `given` from now on.
    pub(crate) fn give(&mut self, given: Given) {
        let seq = self.frame().revolution.seq;
        let after = Side::new(given, &self.means);
        let before = std::mem::replace(&mut self.now, after);
        if self.before.is_none() {
            self.before = Some((before.given.clone(), before.known_answers()));
        }
        // A setting of ingest may leave scans out.
        let flight = &self.now.given.flight;
        self.at = flight.partition_point(|scan| scan.revolution.seq < seq).min(flight.len() - 1);
        self.go_to(self.at);
    }

    /// Goes to a place of the flight.
    pub(crate) fn go_to(&mut self, at: usize) {
        self.at = at;
        self.version += 1;
        self.now.go_to(at);
        let seq = self.frame().revolution.seq;
        if let Some(held) = &mut self.held
            && let Some(at) = held.place_of(seq)
        {
            held.go_to(at);
        }
    }

    /// Seconds of a place of the flight, after its first scan.
    pub(crate) fn seconds(&self, at: usize) -> f64 {
        let stamp = |at: usize| i128::from(self.now.given.flight[at].revolution.stamp_ns);
        (stamp(at) - stamp(0)) as f64 / 1e9
    }

    /// Where it stands, in a line.
    pub fn here(&self) -> String {
        let frame = self.frame();
        let (seq, s) = (frame.revolution.seq, self.seconds(self.at));
        format!("{seq} at {s:.2} s: {}", answer_in_words(frame))
    }
}

fn read(reader: &mut Reader, config: &Config) -> Result<Vec<Scan>, Refused> {
    let flight = reader(config).map_err(Refused::Failed)?;
    if flight.is_empty() { Err(Refused::Failed("no scan could be read".to_owned())) } else { Ok(flight) }
}

pub(crate) fn refused(error: ConfigError) -> Refused {
    Refused::Usage(error.to_string())
}

/// "3 walls, tee, k = 3, confidence 0.97", with the ways on first where these are counted; or why there is no answer.
pub(crate) fn answer_in_words(frame: &Frame) -> String {
    if let Some(failure) = &frame.failure {
        return failure.to_string();
    }
    let junction = &frame.junction;
    let confidence = junction.confidence.map_or_else(String::new, |confidence| format!(", confidence {confidence:.2}"));
    let walls = counted(junction.junctions as u64, "wall");
    let place = junction.place.to_string().replace('_', " ");
    let ways = junction.ways.as_ref().map_or_else(String::new, |ways| counted(ways.len() as u64, "way") + " on, ");
    format!("{ways}{walls}, {place}, k = {}{confidence}", frame.spectrum.k)
}
