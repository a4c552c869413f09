//! Stages and sources that fail and panic on command.

use std::io;

use crosscut_detector::{Config, Layer, Registry};
use crosscut_pipeline::{StreamOptions, Summary, stream};
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{
    Affinity, AffinityStage, Frame, Kind, KmeansStage, Notes, Number, ParamSpec, Partition, Point, Revolution, Source,
    SourceError, SpectralStage, Spectrum, StageError, Step,
};

/// The x at which a stage names a cluster that there is not, errs, or panics; -1: never.
const LIE_AT_X: Number = Number::new("lie_at_x", "", -1.0).from(-1.0).to(1e9);
pub(crate) const ERROR_AT_X: Number = Number::new("error_at_x", "", -1.0).from(-1.0).to(1e9);
const PANIC_AT_X: Number = Number::new("panic_at_x", "", -1.0).from(-1.0).to(1e9);
const AT: &[ParamSpec] = &[LIE_AT_X.spec, ERROR_AT_X.spec, PANIC_AT_X.spec];

/// Errs or panics on the revolution whose first point has this x, which each stage hands on in its own part.
struct Failing {
    error_at_x: f64,
    panic_at_x: f64,
    lie_at_x: f64,
}

impl Failing {
    fn new(params: &crosscut_stage::Params) -> Self {
        Self { error_at_x: params.get(ERROR_AT_X), panic_at_x: params.get(PANIC_AT_X), lie_at_x: params.get(LIE_AT_X) }
    }

    fn act(&self, x: f64) -> Result<(), StageError> {
        assert!(x != self.panic_at_x, "told to panic at {x}");
        if x == self.error_at_x { Err(StageError::Unsupported(format!("told to fail at {x}"))) } else { Ok(()) }
    }
}

impl AffinityStage for Failing {
    fn weigh(&mut self, r: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        let x = r.points_m[0].x;
        // Uneven work, so that lanes overtake each other if nothing keeps the order.
        std::thread::sleep(std::time::Duration::from_micros(u64::from(r.seq.is_multiple_of(7)) * 500));
        self.act(x)?;
        out.weights.make_dense(1)[(0, 0)] = x; // and so its degree
        notes.add(N101, format!("affinity of {x}"));
        Ok(())
    }
}

impl SpectralStage for Failing {
    fn spectrum(&mut self, a: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        self.act(a.degrees[0])?;
        out.eigenvalues = vec![a.degrees[0]];
        Ok(())
    }
}

impl KmeansStage for Failing {
    fn partition(&mut self, s: &Spectrum, out: &mut Partition, _: &mut Notes) -> Result<(), StageError> {
        self.act(s.eigenvalues[0])?;
        out.clusters = 1;
        out.labels = vec![Some(u32::from(s.eigenvalues[0] == self.lie_at_x))];
        Ok(())
    }
}

/// The standard registry, with a failing stage of each kind in front.
pub(crate) fn registry() -> Registry {
    let mut registry = Registry::standard();
    let doc = "fails when told to";
    registry.affinity.insert(0, Kind::affinity("failing", doc, |p| Box::new(Failing::new(p))).params(AT));
    registry.spectral.insert(0, Kind::spectral("failing", doc, |p| Box::new(Failing::new(p))).params(AT));
    registry.kmeans.insert(0, Kind::kmeans("failing", doc, |p| Box::new(Failing::new(p))).params(AT));
    registry
}

/// The failing stages with these settings.
pub(crate) fn config(settings: &[&str]) -> Config {
    let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
    let layers = [Layer::settings("--set", &settings).expect("settings")];
    Config::resolve(&registry(), &layers).expect("a configuration")
}

/// `length` revolutions of one return, at x = seq; errs or panics at `fails`.
pub(crate) struct Count {
    pub(crate) length: u64,
    pub(crate) next: u64,
    pub(crate) error_at: Option<u64>,
    pub(crate) panic_at: Option<u64>,
}

impl Count {
    pub(crate) fn to(length: u64) -> Self {
        Self { length, next: 0, error_at: None, panic_at: None }
    }
}

impl Source for Count {
    fn next(&mut self, out: &mut Revolution, _: &mut Notes) -> Result<bool, SourceError> {
        assert!(self.panic_at != Some(self.next), "the source was told to panic");
        if self.error_at == Some(self.next) {
            return Err(SourceError("the source was told to fail".into()));
        }
        if self.next == self.length {
            return Ok(false);
        }
        out.seq = self.next;
        out.stamp_ns = self.next * 1_000_000;
        out.points_m.clear();
        out.points_m.push(Point::new(self.next as f64, 0.0, 0.0));
        self.next += 1;
        Ok(true)
    }
}

/// What came out: the summary and the sequence numbers that were written.
pub(crate) fn run(source: &mut Count, config: &Config) -> (Summary, Vec<u64>) {
    let mut written = Vec::new();
    let mut sink = |frame: &Frame| -> io::Result<()> {
        assert_eq!(frame.affinity.degrees, [frame.revolution.seq as f64], "a frame mixes two revolutions");
        let of_affinity = frame.notes.iter().filter(|note| note.starts_with("affinity of"));
        assert!(of_affinity.eq([format!("affinity of {}", frame.revolution.seq as f64).as_str()]));
        written.push(frame.revolution.seq);
        Ok(())
    };
    let summary = stream(source, config, &registry(), &mut sink, &mut [], &StreamOptions::default()).expect("threads");
    (summary, written)
}

/// `(section, step)` of the three stages that lanes run.
pub(crate) const STAGES: [(&str, Step); 3] =
    [("affinity", Step::Affinity), ("spectral", Step::Spectral), ("kmeans", Step::Kmeans)];
