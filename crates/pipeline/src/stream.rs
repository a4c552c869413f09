//! The streaming pipeline: the engine's stages, each in a thread of its own, over a whole source.
//!
//! Frames are dealt to the lanes in rotation and collected in the same rotation, so results keep the order of the
//! source whatever the number of lanes. Each frame has one owner at a time. The pool bounds
//! their number, and an empty pool holds ingest back.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::{Builder, Scope};
use std::time::Instant;

use crossbeam_channel::{Receiver, Sender, bounded};
use crosscut_detector::{Config, Engine, Registry, Worker, elapsed_ns, panic_text};
use crosscut_flight::Flight;
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_stage::{Failure, FailureCause, Frame, Observer, Source, Step};

use crate::pace::Pace;
use crate::stop::StopFlag;
use crate::summary::{RunEnd, Summary};

/// Where results go: called once per revolution, in order, on the report thread.
pub type ResultsSink<'a> = dyn FnMut(&Frame) -> io::Result<()> + Send + 'a;

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct StreamOptions {
    /// Revolutions are released at this multiple of the sensor's pace, above 0; `None`: as fast as the stages are.
    pub rate: Option<f64>,
    /// Asks the run to stop.
    pub stop: StopFlag,
    /// The revolutions are those of a flight: each frame gets its pose, its place and the steady answer.
    pub flight: bool,
}

/// Runs every revolution of `source` through the stages of `config`, and gives each in order to `results`, then to the
/// observers.
///
/// The number of workers (`pipeline.workers`) never changes a result. When a stage fails, every revolution before the
/// failed one is written and observed, then the run ends. It also ends when it is asked to stop, or when results cannot be
/// written. An observer that fails sees no further frame. All threads are joined before this returns.
///
/// # Errors
/// When the rate is not above 0, or a thread cannot be started.
pub fn stream(
    source: &mut dyn Source,
    config: &Config,
    registry: &Registry,
    results: &mut ResultsSink,
    observers: &mut [Box<dyn Observer>],
    options: &StreamOptions,
) -> io::Result<Summary> {
    if let Some(rate) = options.rate.filter(|rate| rate.is_nan() || *rate <= 0.0) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("the rate must be above 0, not {rate}")));
    }
    let (workers, frames) = (config.workers(), config.in_flight());
    let (pool_in, pool_out) = bounded(frames);
    for _ in 0..frames {
        pool_in.send(Frame::default()).expect("the pool holds them all, and its other end is here");
    }

    std::thread::scope(|scope| {
        let (mut to_lanes, mut from_lanes, mut last) = (Vec::new(), Vec::new(), None);
        for lane in 0..workers {
            let [weigh, decompose, cluster, report] = Engine::for_many(config, registry, frames, workers).into();
            let (to_lane, mut flow) = bounded(1);
            for worker in [weigh, decompose, cluster] {
                flow = spawn_worker(scope, worker, lane, flow)?;
            }
            to_lanes.push(to_lane);
            from_lanes.push(flow);
            last = Some(report);
        }
        let report = last.expect("there is at least one worker");

        let ended = StopFlag::default();
        let ingest = Ingest { source, options: options.clone(), ended: ended.clone(), pool: pool_out, lanes: to_lanes };
        let ingest = Builder::new().name("ingest".into()).spawn_scoped(scope, move || ingest.run())?;

        let (to_observers, finished) = bounded(frames);
        let observing = Observing { observers, finished, pool: pool_in };
        let observing = Builder::new().name("observers".into()).spawn_scoped(scope, move || observing.run())?;

        let vehicle_width_m = config.params("vehicle").get(VEHICLE_WIDTH_M);
        let flight = options.flight.then(|| Flight::new(config.params("flight"), vehicle_width_m));
        let observers = to_observers;
        let collect = Collect { report, flight, lanes: from_lanes, results, observers, ended };
        let collect = Builder::new().name("report".into()).spawn_scoped(scope, move || collect.run())?;

        let mut summary = collect.join().expect("the report thread catches panics");
        summary.observer_errors = observing.join().expect("the observer thread catches panics");
        let stopped_early = ingest.join().expect("the ingest thread catches panics");
        if stopped_early && matches!(summary.end, RunEnd::Complete) {
            summary.end = RunEnd::Interrupted;
        }
        Ok(summary)
    })
}

/// A frame on its way through the stages.
struct Arrived {
    frame: Frame,
    /// When its scan arrived: its time at the sensor's pace, else when it was read.
    due: Instant,
}

/// Starts a thread that runs one stage on every frame that comes; the frames come out of the returned channel.
fn spawn_worker<'scope>(
    scope: &'scope Scope<'scope, '_>,
    mut worker: Worker,
    lane: usize,
    frames: Receiver<Arrived>,
) -> io::Result<Receiver<Arrived>> {
    let (out, worked) = bounded(1);
    Builder::new().name(format!("{}-{lane}", worker.step())).spawn_scoped(scope, move || {
        for mut arrived in frames {
            worker.work(&mut arrived.frame).ok(); // a failure travels in its frame
            if out.send(arrived).is_err() {
                return;
            }
        }
    })?;
    Ok(worked)
}

/// The ingest thread: fills frames from the pool and deals them to the lanes in rotation.
struct Ingest<'a> {
    source: &'a mut dyn Source,
    options: StreamOptions,
    /// Set when no more revolutions are wanted.
    ended: StopFlag,
    pool: Receiver<Frame>,
    lanes: Vec<Sender<Arrived>>,
}

impl Ingest<'_> {
    /// Whether it was asked to stop while revolutions were left.
    fn run(mut self) -> bool {
        let mut pace = self.options.rate.map(Pace::new);
        let mut seq = 0;
        for lane in (0..self.lanes.len()).cycle() {
            let Ok(mut frame) = self.pool.recv() else { return false };
            if !self.fill(&mut frame, seq) {
                return false;
            }
            // Only now is it known whether there was something left.
            if self.options.stop.is_set() {
                return true;
            }
            seq = frame.revolution.seq + 1;
            let due = match &mut pace {
                Some(pace) => {
                    pace.wait_for(frame.revolution.stamp_ns, || self.options.stop.is_set() || self.ended.is_set())
                }
                None => Instant::now(),
            };
            let last = frame.failure.is_some();
            if self.lanes[lane].send(Arrived { frame, due }).is_err() || last {
                return false;
            }
        }
        false
    }

    /// The next revolution; `false` at the end. An error of the source becomes the failure of revolution `seq`.
    fn fill(&mut self, frame: &mut Frame, seq: u64) -> bool {
        let start = Instant::now();
        frame.notes.clear();
        frame.failure = None;
        frame.timings.latency_ns = None;
        let cause = match catch_unwind(AssertUnwindSafe(|| self.source.next(&mut frame.revolution, &mut frame.notes))) {
            Ok(Ok(more)) => {
                frame.timings.set_ns(Step::Ingest, elapsed_ns(start));
                frame.notes.begin_stages();
                return more;
            }
            Ok(Err(error)) => FailureCause::Error(error.to_string()),
            Err(panic) => FailureCause::Panic(panic_text(panic.as_ref())),
        };
        frame.failure = Some(Failure { step: Step::Ingest, seq, cause });
        true
    }
}

/// The report thread: collects the lanes in rotation, runs the last stage and the flight, writes results, passes frames on.
struct Collect<'a> {
    report: Worker,
    flight: Option<Flight>,
    lanes: Vec<Receiver<Arrived>>,
    results: &'a mut ResultsSink<'a>,
    observers: Sender<Frame>,
    ended: StopFlag,
}

impl Collect<'_> {
    fn run(mut self) -> Summary {
        let mut summary = Summary::default();
        summary.end = self.collect(&mut summary).err().unwrap_or(RunEnd::Complete);
        self.ended.set(); // ingest may be waiting for its next revolution to be due
        summary
    }

    /// Takes frames up to the last, or up to one that fails.
    fn collect(&mut self, summary: &mut Summary) -> Result<(), RunEnd> {
        for lane in (0..self.lanes.len()).cycle() {
            let Ok(arrived) = self.lanes[lane].recv() else { break };
            self.finish(arrived, summary)?;
        }
        Ok(())
    }

    /// Finishes a frame: its results are written, then it goes to the observers.
    fn finish(&mut self, Arrived { mut frame, due }: Arrived, summary: &mut Summary) -> Result<(), RunEnd> {
        // Frames come from a pool: without a flight, nothing of an earlier one stays.
        frame.extra.clear();
        frame.timings.flight_ns = None;
        if self.report.work(&mut frame).and_then(|()| self.fly(&mut frame)).is_err() {
            return Err(self.fail(frame));
        }
        self.write(&frame).map_err(RunEnd::ResultsLost)?;
        // A recorded scan is read before it is due, a live one after.
        let latency_ns = elapsed_ns(due).saturating_add(frame.timings.ns(Step::Ingest));
        frame.timings.latency_ns = Some(latency_ns);
        summary.add(&frame);
        self.observers.send(frame).ok(); // they only end when this does
        Ok(())
    }

    /// The failure of a frame, which observers see unless there is no revolution in it.
    fn fail(&mut self, frame: Frame) -> RunEnd {
        let failure = frame.failure.clone().expect("it failed");
        if failure.step != Step::Ingest {
            self.observers.send(frame).ok(); // they only end when this does
        }
        RunEnd::Failed(failure)
    }

    /// Adds what the flight shows, and the time that takes. A failure is left in the frame.
    fn fly(&mut self, frame: &mut Frame) -> Result<(), Failure> {
        let Some(flight) = &mut self.flight else { return Ok(()) };
        let start = Instant::now();
        let flown = catch_unwind(AssertUnwindSafe(|| flight.add(frame)));
        frame.timings.flight_ns = Some(elapsed_ns(start));
        flown.map_err(|panic| {
            let cause = FailureCause::Panic(format!("in the flight: {}", panic_text(panic.as_ref())));
            frame.failure.insert(Failure { step: Step::Report, seq: frame.revolution.seq, cause }).clone()
        })
    }

    fn write(&mut self, frame: &Frame) -> io::Result<()> {
        catch_unwind(AssertUnwindSafe(|| (self.results)(frame)))
            .unwrap_or_else(|panic| Err(io::Error::other(format!("it panicked: {}", panic_text(panic.as_ref())))))
    }
}

/// The observer thread: gives each frame to every observer, then returns it to the pool.
struct Observing<'a> {
    observers: &'a mut [Box<dyn Observer>],
    finished: Receiver<Frame>,
    pool: Sender<Frame>,
}

impl Observing<'_> {
    /// The errors of the observers that failed.
    fn run(self) -> Vec<String> {
        let mut errors = Vec::new();
        let mut active: Vec<_> = self.observers.iter_mut().collect();
        for frame in self.finished {
            active.retain_mut(|observer| keep(&mut errors, || observer.observe(&frame)));
            // The other end is gone once ingest has ended. The frame is not needed then.
            let _ = self.pool.send(frame);
        }
        active.retain_mut(|observer| keep(&mut errors, || observer.finish()));
        errors
    }
}

/// Whether the observer takes further frames; if not, its error goes to `errors`.
fn keep(errors: &mut Vec<String>, act: impl FnOnce() -> Result<(), crosscut_stage::ObserverError>) -> bool {
    let error = match catch_unwind(AssertUnwindSafe(act)) {
        Ok(Ok(())) => return true,
        Ok(Err(error)) => error.to_string(),
        Err(panic) => format!("an observer panicked: {}", panic_text(panic.as_ref())),
    };
    errors.push(error);
    false
}
