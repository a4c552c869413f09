//! A flight with one configuration: its present revolution, and the answers of the whole flight.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;

use crosscut_detector::{Config, Engine, Registry};
use crosscut_evaluate::Agreement;
use crosscut_flight::{Flight, FlightAnswer};
use crosscut_messages::Truth;
use crosscut_report::{ResultsLine, VEHICLE_WIDTH_M};
use crosscut_stage::{Frame, Junction, Notes, Observer, ObserverError, Revolution};

use crate::{Injected, Refused};

/// A scan of the flight.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// Its returns.
    pub revolution: Revolution,
    /// What was dropped or repaired when it was read.
    pub notes: Notes,
    /// Its truth, if the recording has one.
    pub truth: Option<Truth>,
}

/// The answer for one revolution of the flight.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) line: ResultsLine,
    /// Why there is none; the line is then empty.
    pub(crate) failure: Option<String>,
    /// Of which the flight makes its places.
    junction: Junction,
}

/// What decides answers.
#[derive(Clone)]
pub(crate) struct Given {
    pub(crate) config: Config,
    pub(crate) flight: Arc<Vec<Scan>>,
    /// By `seq`.
    pub(crate) injected: BTreeMap<u64, Injected>,
}

/// What answers are made with.
pub(crate) struct Means {
    /// The kinds of stages.
    pub(crate) registry: Registry,
    /// Whether somebody asked to stop.
    pub(crate) stop: Arc<AtomicBool>,
}

impl Means {
    /// Refuses to go on once somebody asked to stop.
    pub(crate) fn go_on(&self) -> Result<(), Refused> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Refused::Failed("stopped; everything is as before".to_owned()));
        }
        Ok(())
    }
}

/// Given settings with what they answer.
pub(crate) struct Side {
    pub(crate) given: Given,
    engine: Engine,
    /// The present revolution.
    pub(crate) frame: Frame,
    /// Of every revolution; `None` until they are asked for.
    answers: Option<Vec<Answer>>,
    /// What the flight adds to every revolution; `None` until it is asked for.
    flown: Option<Vec<FlightAnswer>>,
}

impl Given {
    /// Fills the frame with a scan and what the stages make of it.
    fn process(&self, engine: &mut Engine, scan: &Scan, frame: &mut Frame) {
        frame.revolution.clone_from(&scan.revolution);
        frame.notes.clone_from(&scan.notes);
        frame.extra.clear();
        match self.injected.get(&scan.revolution.seq) {
            Some(injected) => injected.process(engine, frame).ok(), // a failure travels in the frame
            None => engine.process(frame).ok(),
        };
    }

    /// The answers of the whole flight, on all cores; refused when somebody asks to stop.
    pub(crate) fn answer(&self, means: &Means) -> Result<Vec<Answer>, Refused> {
        let workers = std::thread::available_parallelism().map_or(1, usize::from).clamp(1, self.flight.len().max(1));
        let share = self.flight.len().div_ceil(workers).max(1);
        std::thread::scope(|scope| {
            let mut threads = Vec::new();
            for (at, scans) in self.flight.chunks(share).enumerate() {
                let mut engine = Engine::for_many(&self.config, &means.registry, workers, workers);
                let work = move || {
                    let mut frame = Frame::default();
                    let answer = |scan| {
                        means.go_on()?;
                        self.process(&mut engine, scan, &mut frame);
                        Ok(Answer::of(&frame))
                    };
                    scans.iter().map(answer).collect::<Result<Vec<_>, Refused>>()
                };
                let thread = Builder::new().name(format!("again-{at}")).spawn_scoped(scope, work);
                threads.push(thread.expect("the system starts threads"));
            }
            let mut answers = Vec::with_capacity(self.flight.len());
            for thread in threads {
                answers.extend(thread.join().expect("engines catch panics")?);
            }
            Ok(answers)
        })
    }
}

impl Answer {
    fn of(frame: &Frame) -> Self {
        match &frame.failure {
            None => Self { line: ResultsLine::of(frame), failure: None, junction: frame.junction.clone() },
            Some(failure) => {
                let revolution = frame.revolution.clone();
                let nothing = Frame { revolution, ..Frame::default() };
                let (line, failure) = (ResultsLine::of(&nothing), Some(failure.to_string()));
                Self { line, failure, junction: Junction::default() }
            }
        }
    }
}

impl Answer {
    /// Whether both have the same walls and ways on and name the place alike, or fail alike.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let agreement = Agreement::of(&self.line, &other.line);
        self.failure == other.failure
            && self.line.place == other.line.place
            && agreement.is_ok_and(|agreement| agreement.is_same())
    }
}

impl Side {
    /// Without a present revolution.
    pub(crate) fn new(given: Given, means: &Means) -> Self {
        let engine = Engine::new(&given.config, &means.registry);
        Self { given, engine, frame: Frame::default(), answers: None, flown: None }
    }

    /// Answers the revolution at this place of the flight.
    pub(crate) fn go_to(&mut self, at: usize) {
        let Self { given, engine, frame, .. } = self;
        given.process(engine, &given.flight[at], frame);
    }

    /// The place of a revolution in the flight.
    pub(crate) fn place_of(&self, seq: u64) -> Option<usize> {
        self.given.flight.binary_search_by_key(&seq, |scan| scan.revolution.seq).ok()
    }

    /// The answers of the whole flight; refused when somebody asks to stop.
    pub(crate) fn answers(&mut self, means: &Means) -> Result<&[Answer], Refused> {
        if self.answers.is_none() {
            self.answers = Some(self.given.answer(means)?);
        }
        Ok(self.answered())
    }

    /// The answers of the whole flight, once they were asked for.
    pub(crate) fn answered(&self) -> &[Answer] {
        self.answers.as_deref().unwrap_or_default()
    }

    /// Those that are known already.
    pub(crate) fn answered_if_known(&self) -> Option<&[Answer]> {
        self.answers.as_deref()
    }

    /// Those that are known already.
    pub(crate) fn known_answers(self) -> Option<Vec<Answer>> {
        self.answers
    }

    /// Sets the answers that were just computed.
    pub(crate) fn set_answers(&mut self, answers: Vec<Answer>) {
        self.answers = Some(answers);
    }

    /// What the flight adds to every revolution; refused when somebody asks to stop.
    pub(crate) fn flown(&mut self, means: &Means) -> Result<&[FlightAnswer], Refused> {
        if self.flown.is_none() {
            self.answers(means)?;
            let (mut flight, mut frame) = (self.flight(), Frame::default());
            let answers = self.answers.as_deref().unwrap_or_default();
            let flown = self.given.flight.iter().zip(answers).map(|(scan, answer)| {
                means.go_on()?;
                frame.revolution.clone_from(&scan.revolution);
                frame.junction.clone_from(&answer.junction);
                flight.add(&mut frame);
                Ok(FlightAnswer::of(&frame).clone())
            });
            self.flown = Some(flown.collect::<Result<_, Refused>>()?);
        }
        Ok(self.flown.as_deref().unwrap_or_default())
    }

    fn flight(&self) -> Flight {
        let config = &self.given.config;
        Flight::new(config.params("flight"), config.params("vehicle").get(VEHICLE_WIDTH_M))
    }

    /// Shows every frame of the flight, with its pose and place, to an observer, and ends that; of a flight that somebody asks
    /// to stop, those before. Returns how many.
    pub(crate) fn show_all(&mut self, observer: &mut dyn Observer, means: &Means) -> Result<usize, ObserverError> {
        let (mut flight, mut frame, mut shown) = (self.flight(), Frame::default(), 0);
        for scan in self.given.flight.iter().take_while(|_| means.go_on().is_ok()) {
            self.given.process(&mut self.engine, scan, &mut frame);
            if frame.failure.is_none() {
                flight.add(&mut frame);
            }
            observer.observe(&frame)?;
            shown += 1;
        }
        observer.finish()?;
        Ok(shown)
    }
}
