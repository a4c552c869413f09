//! The streaming pipeline: the engine's stages, each in a thread of its own, over a whole source.
//!
//! Frames are dealt to the lanes in rotation and collected in the same rotation, so results keep the order of the
//! source whatever the number of lanes. Each frame has one owner at a time. The pool bounds
//! their number, and an empty pool holds ingest back.

use std::collections::VecDeque;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::{Builder, Scope};
use std::time::Instant;

use crossbeam_channel::{Receiver, Sender, bounded};
use crosscut_detector::{Config, Engine, Registry, Worker, elapsed_ns, panic_text};
use crosscut_flight::{Flight, LOOK_AHEAD};
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_stage::{Failure, FailureCause, Frame, Observer, Source, Step};

use crate::pace::Pace;
use crate::stop::StopFlag;
use crate::summary::{End, Summary};

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
    let params = config.params("flight");
    let look_ahead = if options.flight { params.get(LOOK_AHEAD) } else { 0 };
    let (workers, frames) = (config.workers(), config.in_flight() + look_ahead);
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
        let flight = options.flight.then(|| Flight::new(params, vehicle_width_m));
        let waiting = VecDeque::with_capacity(look_ahead + 1);
        let observers = to_observers;
        let collect = Collect { report, flight, look_ahead, waiting, lanes: from_lanes, results, observers, ended };
        let collect = Builder::new().name("report".into()).spawn_scoped(scope, move || collect.run())?;

        let mut summary = collect.join().expect("the report thread catches panics");
        summary.observer_errors = observing.join().expect("the observer thread catches panics");
        let stopped_early = ingest.join().expect("the ingest thread catches panics");
        if stopped_early && matches!(summary.end, End::Complete) {
            summary.end = End::Interrupted;
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
    /// A frame is finished once this many after it are there.
    look_ahead: usize,
    /// Frames that are not finished.
    waiting: VecDeque<Arrived>,
    lanes: Vec<Receiver<Arrived>>,
    results: &'a mut ResultsSink<'a>,
    observers: Sender<Frame>,
    ended: StopFlag,
}

impl Collect<'_> {
    fn run(mut self) -> Summary {
        let mut summary = Summary::default();
        let end = self.collect(&mut summary).and_then(|failed| {
            while !self.waiting.is_empty() {
                self.finish_next(&mut summary)?;
            }
            failed.map_or(Ok(()), |frame| Err(self.fail(frame)))
        });
        summary.end = end.err().unwrap_or(End::Complete);
        self.ended.set(); // ingest may be waiting for its next revolution to be due
        summary
    }

    /// Takes frames up to the last, or up to one that fails, which is returned.
    fn collect(&mut self, summary: &mut Summary) -> Result<Option<Frame>, End> {
        for lane in (0..self.lanes.len()).cycle() {
            let Ok(Arrived { mut frame, due }) = self.lanes[lane].recv() else { break };
            if self.report.work(&mut frame).is_err() {
                return Ok(Some(frame));
            }
            // Frames come from a pool: without a flight, nothing of an earlier one stays.
            frame.extra.clear();
            frame.timings.flight_ns = None;
            if self.fly(&mut frame, |flight, frame, _| flight.place(frame)).is_err() {
                return Ok(Some(frame));
            }
            self.waiting.push_back(Arrived { frame, due });
            if self.waiting.len() > self.look_ahead {
                self.finish_next(summary)?;
            }
        }
        Ok(None)
    }

    /// Finishes the frame that has waited longest: its results are written, then it goes to the observers.
    fn finish_next(&mut self, summary: &mut Summary) -> Result<(), End> {
        let Some(Arrived { mut frame, due }) = self.waiting.pop_front() else { return Ok(()) };
        let steady = |flight: &mut Flight, frame: &mut Frame, later: &VecDeque<Arrived>| {
            flight.steady(frame, later.iter().map(|later| &later.frame));
        };
        if self.fly(&mut frame, steady).is_err() {
            return Err(self.fail(frame));
        }
        self.write(&frame).map_err(End::ResultsLost)?;
        // A recorded scan is read before it is due, a live one after.
        let latency_ns = elapsed_ns(due).saturating_add(frame.timings.ns(Step::Ingest));
        frame.timings.latency_ns = Some(latency_ns);
        summary.add(&frame);
        self.observers.send(frame).ok(); // they only end when this does
        Ok(())
    }

    /// The failure of a frame, which observers see unless there is no revolution in it.
    fn fail(&mut self, frame: Frame) -> End {
        let failure = frame.failure.clone().expect("it failed");
        if failure.step != Step::Ingest {
            self.observers.send(frame).ok(); // they only end when this does
        }
        End::Failed(failure)
    }

    /// Adds what the flight shows, with the frames that wait behind this one, and to the time that takes. A failure is
    /// left in the frame.
    fn fly(
        &mut self,
        frame: &mut Frame,
        add: impl FnOnce(&mut Flight, &mut Frame, &VecDeque<Arrived>),
    ) -> Result<(), Failure> {
        let Some(flight) = &mut self.flight else { return Ok(()) };
        let (start, waiting) = (Instant::now(), &self.waiting);
        let flown = catch_unwind(AssertUnwindSafe(|| add(flight, frame, waiting)));
        let before_ns = frame.timings.flight_ns.unwrap_or(0);
        frame.timings.flight_ns = Some(before_ns.saturating_add(elapsed_ns(start)));
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

#[cfg(test)]
mod tests {
    use crosscut_detector::Preset;
    use crosscut_flight::{FlightAnswer, Here, HereKind, Way};
    use crosscut_stage::Point;

    use super::*;

    #[test]
    fn observers_see_the_frame_whose_steady_answer_panics() {
        let registry = Registry::standard();
        let config = Config::preset(Preset::Default, &registry).expect("a preset");
        let mut frame = Frame::default();
        frame.revolution.points_m.push(Point::origin());
        let ways = vec![Way { bearing_rad: 0.0, width_m: 1.0, opening: Some(0) }]; // there is no opening
        let here = Some(Here { kind: HereKind::DeadEnd, look_m: 1.0, ways, is_middle: true, confidence: 1.0 });
        FlightAnswer { here, ..FlightAnswer::default() }.put(&mut frame);
        let (observers, seen) = bounded(1);
        let [_, _, _, report] = Engine::new(&config, &registry).into();
        let mut collect = Collect {
            report,
            flight: Some(Flight::new(config.params("flight"), 0.6)),
            look_ahead: 0,
            waiting: VecDeque::from([Arrived { frame, due: Instant::now() }]),
            lanes: Vec::new(),
            results: &mut |_| Ok(()),
            observers,
            ended: StopFlag::default(),
        };
        let end = collect.finish_next(&mut Summary::default());
        assert!(matches!(end, Err(End::Failed(_))), "{end:?}");
        assert!(seen.try_recv().expect("a frame").failure.is_some());
    }
}
