//! Order, failure and shutdown of the streaming pipeline.

use std::io;

use crate::stages::{Count, STAGES, config, registry, run};
use crosscut_detector::{Config, Engine};
use crosscut_pipeline::{RunEnd, StopFlag, StreamOptions, stream};
use crosscut_stage::{FailureCause, Frame, Observer, ObserverError, Step};

fn settings(workers: usize, in_flight: usize, more: &str) -> Config {
    let (workers, in_flight) = (format!("pipeline.workers={workers}"), format!("pipeline.in_flight={in_flight}"));
    config(&[&workers, &in_flight, if more.is_empty() { "affinity.error_at_x=-1" } else { more }])
}

#[test]
fn results_keep_the_order_of_the_source_whatever_the_workers_and_the_pool() {
    for workers in [1, 2, 4] {
        for in_flight in [1, 2, 3, 16] {
            let (summary, written) = run(&mut Count::to(50), &settings(workers, in_flight, ""));
            assert!(written.iter().copied().eq(0..50), "{workers} workers, {in_flight} in flight: {written:?}");
            assert!(matches!(summary.end, RunEnd::Complete));
            assert_eq!((summary.revolutions, summary.noted), (50, 50));
        }
    }
}

#[test]
fn an_empty_source_ends_at_once() {
    let (summary, written) = run(&mut Count::to(0), &settings(2, 4, ""));
    assert!(written.is_empty() && matches!(summary.end, RunEnd::Complete));
}

#[test]
fn a_panic_in_any_stage_leaves_exactly_the_earlier_revolutions() {
    for (section, step) in STAGES {
        for workers in [1, 2, 4] {
            for at in [0, 1, 17] {
                let (summary, written) =
                    run(&mut Count::to(50), &settings(workers, 8, &format!("{section}.panic_at_x={at}")));
                assert!(written.iter().copied().eq(0..at), "{section}, {workers} workers: {written:?}");
                let RunEnd::Failed(failure) = summary.end else { panic!("{section}: {:?}", summary.end) };
                assert_eq!((failure.step, failure.seq), (step, at));
                assert_eq!(failure.cause, FailureCause::Panic(format!("told to panic at {at}")));
            }
        }
    }
}

#[test]
fn a_panic_in_the_report_leaves_exactly_the_earlier_revolutions() {
    // A cluster that there is not makes the report reach beyond its walls.
    let (summary, written) = run(&mut Count::to(50), &settings(2, 8, "kmeans.lie_at_x=17"));
    assert!(written.iter().copied().eq(0..17), "{written:?}");
    let RunEnd::Failed(failure) = summary.end else { panic!("{:?}", summary.end) };
    assert_eq!((failure.step, failure.seq), (Step::Report, 17));
    assert!(matches!(failure.cause, FailureCause::Panic(_)), "{}", failure.cause);
}

#[test]
fn an_error_in_any_stage_leaves_exactly_the_earlier_revolutions_and_says_where() {
    for (section, step) in STAGES {
        let (summary, written) = run(&mut Count::to(50), &settings(2, 8, &format!("{section}.error_at_x=9")));
        assert!(written.iter().copied().eq(0..9));
        let RunEnd::Failed(failure) = summary.end else { panic!("{:?}", summary.end) };
        assert_eq!(failure.to_string(), format!("{step} failed on revolution 9: told to fail at 9"));
    }
}

#[test]
fn a_source_that_errs_or_panics_keeps_what_it_gave_before() {
    let failing = [
        (Count { error_at: Some(5), ..Count::to(50) }, FailureCause::Error("the source was told to fail".into())),
        (Count { panic_at: Some(5), ..Count::to(50) }, FailureCause::Panic("the source was told to panic".into())),
    ];
    for (mut source, cause) in failing {
        let (summary, written) = run(&mut source, &settings(2, 8, ""));
        assert!(written.iter().copied().eq(0..5));
        let RunEnd::Failed(failure) = summary.end else { panic!("{:?}", summary.end) };
        assert_eq!((failure.step, failure.seq, failure.cause), (Step::Ingest, 5, cause));
    }
}

#[test]
fn results_that_cannot_be_written_end_the_run_and_say_so() {
    for panics in [false, true] {
        let mut written = 0;
        let mut sink = |_: &Frame| {
            assert!(written < 3 || !panics, "the sink was told to panic");
            written += 1;
            if written > 3 { Err(io::Error::other("disk full")) } else { Ok(()) }
        };
        let summary =
            stream(&mut Count::to(50), &settings(2, 8, ""), &registry(), &mut sink, &mut [], &StreamOptions::default())
                .expect("threads");
        let RunEnd::ResultsLost(error) = summary.end else { panic!("{:?}", summary.end) };
        assert!(error.to_string().contains(if panics { "told to panic" } else { "disk full" }));
        assert_eq!(summary.revolutions, 3);
    }
}

/// Remembers what it saw; gives up, or panics, at a given revolution.
struct Watcher {
    seen: std::sync::Arc<std::sync::Mutex<Vec<u64>>>,
    give_up_at: u64,
    panics: bool,
}

impl Observer for Watcher {
    fn observe(&mut self, frame: &Frame) -> Result<(), ObserverError> {
        let seq = frame.revolution.seq;
        self.seen.lock().expect("one thread").push(seq);
        assert!(!self.panics || seq != self.give_up_at, "the observer was told to panic");
        if seq == self.give_up_at { Err(ObserverError(format!("gave up at {seq}"))) } else { Ok(()) }
    }

    fn finish(&mut self) -> Result<(), ObserverError> {
        self.seen.lock().expect("one thread").push(u64::MAX);
        Ok(())
    }
}

#[test]
fn an_observer_that_fails_is_left_out_and_disturbs_neither_results_nor_the_others() {
    let seen: Vec<_> = (0..3).map(|_| std::sync::Arc::default()).collect();
    let watcher = |i: usize, give_up_at, panics| -> Box<dyn Observer> {
        Box::new(Watcher { seen: std::sync::Arc::clone(&seen[i]), give_up_at, panics })
    };
    let mut observers = [watcher(0, 7, false), watcher(1, 3, true), watcher(2, 999, false)];
    let mut written = 0;
    let mut sink = |_: &Frame| {
        written += 1;
        Ok(())
    };
    let options = StreamOptions::default();
    let summary = stream(&mut Count::to(20), &settings(2, 4, ""), &registry(), &mut sink, &mut observers, &options)
        .expect("threads");
    assert!(matches!(summary.end, RunEnd::Complete), "results are complete");
    assert_eq!(written, 20);
    assert_eq!(summary.observer_errors, ["an observer panicked: the observer was told to panic", "gave up at 7"]);
    let saw = |i: usize| seen[i].lock().expect("one thread").clone();
    assert!(saw(0).into_iter().eq(0..=7), "not called again, not even to finish");
    assert!(saw(1).into_iter().eq(0..=3));
    assert!(saw(2).into_iter().eq((0..20).chain([u64::MAX])), "every frame in order, then the end");
}

#[test]
fn a_revolution_that_failed_is_seen_after_all_others_unless_it_could_not_even_be_read() {
    let saw = |source: &mut Count, setting: &str| {
        let seen: std::sync::Arc<std::sync::Mutex<Vec<u64>>> = std::sync::Arc::default();
        let watcher = Watcher { seen: std::sync::Arc::clone(&seen), give_up_at: 999, panics: false };
        let mut observers: [Box<dyn Observer>; 1] = [Box::new(watcher)];
        let options = StreamOptions::default();
        let ran = stream(source, &settings(2, 8, setting), &registry(), &mut |_| Ok(()), &mut observers, &options);
        assert!(matches!(ran.expect("threads").end, RunEnd::Failed(_)));
        seen.lock().expect("one thread").clone()
    };
    assert!(saw(&mut Count::to(50), "spectral.error_at_x=9").into_iter().eq((0..=9).chain([u64::MAX])));
    let mut unreadable = Count { error_at: Some(5), ..Count::to(50) };
    assert!(saw(&mut unreadable, "").into_iter().eq((0..5).chain([u64::MAX])));
}

#[test]
fn stopping_finishes_what_is_in_flight_and_writes_no_gap() {
    let stop = StopFlag::default();
    let mut written = Vec::new();
    let mut sink = |frame: &Frame| {
        written.push(frame.revolution.seq);
        if written.len() == 10 {
            stop.set();
        }
        Ok(())
    };
    let options = StreamOptions { stop: stop.clone(), ..StreamOptions::default() };
    let summary = stream(&mut Count::to(u64::MAX), &settings(4, 8, ""), &registry(), &mut sink, &mut [], &options)
        .expect("threads");
    assert!(matches!(summary.end, RunEnd::Interrupted));
    assert!(written.len() >= 10 && written.iter().copied().eq(0..written.len() as u64), "{written:?}");
}

/// Asks the run to stop when everything has been seen.
struct LateStop(StopFlag);

impl Observer for LateStop {
    fn observe(&mut self, _: &Frame) -> Result<(), ObserverError> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), ObserverError> {
        self.0.set();
        Ok(())
    }
}

#[test]
fn a_run_that_was_read_to_its_end_is_complete_however_late_it_was_asked_to_stop() {
    for in_flight in [1, 8] {
        let stop = StopFlag::default();
        let options = StreamOptions { stop: stop.clone(), ..StreamOptions::default() };
        let mut stop_at_last = |frame: &Frame| {
            if frame.revolution.seq == 9 {
                stop.set();
            }
            Ok(())
        };
        let config = settings(1, in_flight, "");
        let summary = stream(&mut Count::to(10), &config, &registry(), &mut stop_at_last, &mut [], &options);
        let summary = summary.expect("threads");
        assert!(
            matches!(summary.end, RunEnd::Complete) && summary.revolutions == 10,
            "{in_flight} in flight: {summary:?}"
        );
    }
    let stop = StopFlag::default();
    let options = StreamOptions { stop: stop.clone(), ..StreamOptions::default() };
    let mut observers: [Box<dyn Observer>; 1] = [Box::new(LateStop(stop))];
    let summary =
        stream(&mut Count::to(10), &settings(2, 4, ""), &registry(), &mut |_| Ok(()), &mut observers, &options);
    assert!(matches!(summary.expect("threads").end, RunEnd::Complete), "observers were finishing");
}

#[test]
fn playing_at_a_rate_takes_the_time_that_the_stamps_say() {
    // Stamps are 1 ms apart: 41 revolutions at half the pace are released over 80 ms. Only the lower bound is sure.
    let options = StreamOptions { rate: Some(0.5), ..StreamOptions::default() };
    let start = std::time::Instant::now();
    stream(&mut Count::to(41), &settings(1, 4, ""), &registry(), &mut |_| Ok(()), &mut [], &options).expect("threads");
    assert!(start.elapsed().as_millis() >= 80);
}

#[test]
fn a_rate_that_is_not_above_0_is_refused() {
    for rate in [0.0, -1.0, f64::NAN] {
        let options = StreamOptions { rate: Some(rate), ..StreamOptions::default() };
        let (mut source, config) = (Count::to(2), settings(1, 4, ""));
        let refused = stream(&mut source, &config, &registry(), &mut |_| Ok(()), &mut [], &options);
        assert_eq!(refused.expect_err("must be refused").kind(), io::ErrorKind::InvalidInput, "{rate}");
    }
}

#[test]
fn a_run_that_has_ended_does_not_wait_for_the_next_revolution_to_be_due() {
    // Stamps are 1 ms apart: the second revolution is due after 1000 s.
    let options = StreamOptions { rate: Some(1e-6), ..StreamOptions::default() };
    let mut sink = |_: &Frame| Err(io::Error::other("disk full"));
    let start = std::time::Instant::now();
    let summary = stream(&mut Count::to(2), &settings(1, 4, ""), &registry(), &mut sink, &mut [], &options);
    assert!(matches!(summary.expect("threads").end, RunEnd::ResultsLost(_)));
    assert!(start.elapsed().as_secs() < 500);
}

#[test]
fn the_engine_alone_does_the_same_steps_and_recovers_after_a_failure() {
    let mut engine = Engine::new(&settings(1, 1, "spectral.panic_at_x=1"), &registry());
    let mut source = Count::to(3);
    let mut frame = Frame::default();
    for seq in 0..3 {
        frame.notes.clear();
        assert!(crosscut_stage::Source::next(&mut source, &mut frame.revolution, &mut frame.notes).expect("a source"));
        let processed = engine.process(&mut frame);
        assert_eq!(processed.is_err(), seq == 1, "{processed:?}");
        assert_eq!(frame.failure, processed.err());
    }
    assert_eq!(frame.junction.junctions, 1);
}

#[test]
fn an_affinity_that_nothing_was_calibrated_for_has_no_confidence() {
    let answer = |settings: &[&str]| {
        let mut frame = Frame::default();
        frame.revolution.points_m = vec![crosscut_stage::Point::origin()];
        let mut engine = Engine::new(&config(settings), &registry());
        engine.process(&mut frame).expect("nothing fails at x = 0");
        (frame.junction.confidence, frame.notes.iter().any(|note| note.contains("nothing was calibrated")))
    };
    assert_eq!(answer(&["affinity.kind=failing"]), (None, true));
    let shipped = ["affinity.kind=rbf", "spectral.kind=faer", "kmeans.kind=components"];
    let (confidence, noted) = answer(&shipped);
    assert!(confidence.is_some() && !noted);
}

#[test]
fn a_size_that_does_not_fit_is_refused_with_the_size_it_would_need() {
    let mut engine = Engine::new(&config(&["pipeline.memory_mb=1"]), &registry());
    let mut frame = Frame::default();
    frame.revolution.points_m.resize(400, crosscut_stage::Point::origin());
    let failure = engine.process(&mut frame).expect_err("400 x 400 x 8 bytes are more than 1 MB");
    assert_eq!(failure.step, Step::Affinity);
    let text = failure.to_string();
    assert!(text.contains("400 returns would need 9 MB") && text.contains("pipeline.memory_mb is 1"), "{text}");
}

#[test]
fn a_solver_too_large_for_a_sparse_w_is_refused_with_smaller_ones() {
    let mut engine =
        Engine::new(&config(&["affinity.kind=passage", "spectral.kind=faer", "pipeline.memory_mb=1"]), &registry());
    let mut frame = Frame::default();
    frame.revolution.points_m.resize(400, crosscut_stage::Point::origin());
    let failure = engine.process(&mut frame).expect_err("the eigenvectors alone are more than 1 MB");
    assert_eq!(failure.step, Step::Affinity);
    assert!(failure.to_string().contains("spectral.kind = \"blocks\""), "{failure}");
}
