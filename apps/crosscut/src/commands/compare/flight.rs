//! One flight by every configuration: each scan is read once for all that read scans alike, and their answers are compared.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use crosscut_detector::{Config, Registry, elapsed_ns, panic_text};
use crosscut_evaluate::flights::{FlightFigures, FlightScore};
use crosscut_evaluate::tolerance::Tolerances;
use crosscut_evaluate::verdict::Surer;
use crosscut_evaluate::{Agreement, Differences, Evaluation, Score, Variants, flips, settings_of_step};
use crosscut_flight::{Flight as Follower, Mapper};
use crosscut_ingest::truth_map;
use crosscut_messages::{Truth, TruthMap};
use crosscut_pipeline::{RunEnd, StopFlag, Summary};
use crosscut_report::{CONFIDENCE, ResultsLine, VEHICLE_WIDTH_M};
use crosscut_stage::{Failure, FailureCause, Frame, SURE, Step, Timings, counted};

use crate::diagnostics::Diagnostics;
use crate::fly::Flown;
use crate::input::configurations::Configuration;
use crate::input::{Flight, Judge};

/// A flight, and what every configuration makes of it.
pub(super) struct Compared {
    /// Its name, that of its file.
    pub(super) name: String,
    /// Its files; none if it cannot be read again.
    pub(super) parts: Vec<PathBuf>,
    pub(super) flown: Flown,
    pub(super) has_truth: bool,
    /// Stamp of the first scan that was compared.
    pub(super) first_stamp_ns: u64,
    /// The answers of each configuration.
    pub(super) answers: Vec<Answers>,
    /// Differences of every configuration but the first from the first.
    pub(super) differences: Vec<Differences>,
    /// Which of the two is surer where they differ, for the same configurations.
    pub(super) surer: Vec<Surer>,
    /// Why the map of the mine cannot be read.
    bad_map: Option<String>,
}

/// What is counted of the answers of a configuration.
#[derive(Default)]
pub(super) struct Answers {
    /// The number of walls in each revolution that was answered.
    walls: Vec<usize>,
    /// Revolutions whose count differs from their neighbours.
    pub(super) flips: usize,
    /// The sum of those that are known, how many they are, and how many of these are sure.
    confidence: (f64, u64, u64),
    pub(super) evaluation: Evaluation,
    /// The `seq` of each revolution that was compared with its truth, and whether it is right.
    pub(super) right: Vec<(u64, bool)>,
    pub(super) timings: Vec<(u64, Timings)>,
    /// The zero tolerances by which counts would be right.
    pub(super) tolerances: Tolerances,
    /// How many revolutions have no answer, and why the first has none.
    failed: Option<(u64, Failure)>,
    /// The figures of the flight, if its mine is known.
    pub(super) flight: Option<FlightFigures>,
}

impl Answers {
    fn add(&mut self, frame: &Frame, judged: Option<(&Truth, &Score)>) {
        if let Some(failure) = &frame.failure {
            self.failed.get_or_insert_with(|| (0, failure.clone())).0 += 1;
            return;
        }
        self.walls.push(frame.junction.junctions);
        if let Some(confidence) = frame.junction.confidence {
            let (sum, known, sure) = self.confidence;
            self.confidence = (sum + confidence, known + 1, sure + u64::from(confidence >= SURE));
        }
        self.timings.push((frame.revolution.seq, frame.timings));
        if let Some((truth, score)) = judged {
            self.tolerances.add(&frame.spectrum.eigenvalues, truth.walls as usize);
            self.evaluation.add(score);
            self.right.push((frame.revolution.seq, score.right));
        }
    }

    /// Adds what is counted of another flight.
    pub(super) fn merge(&mut self, other: &Self) {
        self.walls.extend(&other.walls);
        self.flips += other.flips;
        let ((sum, known, sure), more) = (self.confidence, other.confidence);
        self.confidence = (sum + more.0, known + more.1, sure + more.2);
        self.evaluation.merge(&other.evaluation);
    }

    /// Revolutions with an answer.
    pub(super) fn revolutions(&self) -> usize {
        self.walls.len()
    }

    /// Revolutions without an answer.
    pub(super) fn without(&self) -> u64 {
        self.failed.as_ref().map_or(0, |(count, _)| *count)
    }

    pub(super) fn mean_walls(&self) -> Option<f64> {
        let revolutions = self.walls.len();
        (revolutions > 0).then(|| self.walls.iter().sum::<usize>() as f64 / revolutions as f64)
    }

    pub(super) fn mean_confidence(&self) -> Option<f64> {
        let (sum, known, _) = self.confidence;
        (known > 0).then(|| sum / known as f64)
    }

    /// The share of the answers that are sure.
    pub(super) fn sure(&self) -> Option<f64> {
        let (_, known, sure) = self.confidence;
        (known > 0).then(|| sure as f64 / self.walls.len() as f64)
    }
}

/// The scans of a flight as some of the configurations read them, and the stages of these.
pub(super) struct Reader {
    flight: Flight,
    judge: Judge,
    variants: Variants,
    /// The places of the configurations.
    places: Vec<usize>,
    frame: Frame,
    /// What the next scan is compared with; `None` at the end.
    next: Option<Option<Truth>>,
    returns: usize,
}

/// A reader for each way in which the configurations read scans. `open` opens the flight for one of them.
pub(super) fn readers(
    configurations: &[Configuration],
    registry: &Registry,
    mut open: impl FnMut(&Config) -> anyhow::Result<Flight>,
) -> anyhow::Result<Vec<Reader>> {
    let mut readings: Vec<(String, Vec<usize>)> = Vec::new();
    for (place, Configuration { config, .. }) in configurations.iter().enumerate() {
        let reading = settings_of_step(config, Step::Ingest);
        match readings.iter_mut().find(|(known, _)| *known == reading) {
            Some((_, places)) => places.push(place),
            None => readings.push((reading, vec![place])),
        }
    }
    let reader = |(_, places): (String, Vec<usize>)| {
        let flight = open(reading(configurations, &configurations[places[0]].config))?;
        Ok(Reader::new(flight, places, configurations, registry))
    };
    readings.into_iter().map(reader).collect()
}

/// The configuration by which all are read that read scans as `config` does: if any takes clouds, one of these. Others pass them over.
pub(super) fn reading<'a>(configurations: &'a [Configuration], config: &'a Config) -> &'a Config {
    let is_alike = |of: &&Config| settings_of_step(of, Step::Ingest) == settings_of_step(config, Step::Ingest);
    configurations.iter().map(|of| &of.config).filter(is_alike).find(|of| of.takes_cloud()).unwrap_or(config)
}

/// The one reader of a flight that comes as it is made: it is read once, as the first configuration reads scans.
pub(super) fn only_reader(
    configurations: &[Configuration],
    registry: &Registry,
    flight: Flight,
    diagnostics: &mut Diagnostics,
) -> Reader {
    let reading = |of: &Configuration| settings_of_step(&of.config, Step::Ingest);
    let first = reading(&configurations[0]);
    for of in &configurations[1..] {
        let other = reading(of);
        let unused: Vec<&str> = other.lines().filter(|line| !first.lines().any(|known| known == *line)).collect();
        if !unused.is_empty() {
            let (first, unused) = (&configurations[0].name, unused.join(", "));
            diagnostics
                .note(format_args!("scans come once, as {first} reads them; {unused} of {} has no effect", of.name));
        }
    }
    Reader::new(flight, (0..configurations.len()).collect(), configurations, registry)
}

impl Reader {
    /// Of the configurations at these places, which read scans in one way.
    fn new(flight: Flight, places: Vec<usize>, configurations: &[Configuration], registry: &Registry) -> Self {
        let configs: Vec<&Config> = places.iter().map(|place| &configurations[*place].config).collect();
        let (variants, judge, frame) = (Variants::new(&configs, registry), Judge::default(), Frame::default());
        Self { flight, judge, variants, places, frame, next: None, returns: 0 }
    }

    fn seq(&self) -> Option<u64> {
        self.next.as_ref().map(|_| self.frame.revolution.seq)
    }

    /// Reads the next scan.
    fn read(&mut self) -> Result<(), Failure> {
        let Self { flight, frame, .. } = self;
        let (start, seq) = (Instant::now(), frame.revolution.seq + 1);
        frame.notes.clear();
        let cause = match catch_unwind(AssertUnwindSafe(|| flight.next(&mut frame.revolution, &mut frame.notes))) {
            Ok(Ok(truth)) => {
                frame.timings.set_ns(Step::Ingest, elapsed_ns(start));
                frame.notes.begin_stages();
                let seq = frame.revolution.seq;
                self.next = truth.map(|truth| self.judge.truth(truth, seq));
                self.returns += if self.next.is_some() { frame.revolution.len() } else { 0 };
                return Ok(());
            }
            Ok(Err(error)) => FailureCause::Error(error.to_string()),
            Err(panic) => FailureCause::Panic(panic_text(panic.as_ref())),
        };
        Err(Failure { step: Step::Ingest, seq, cause })
    }

    /// Gives the answer of each configuration to the scan that was read, with the truth, to `each`.
    fn answer(
        &mut self,
        each: &mut impl FnMut(usize, &mut Frame, Option<(&Truth, &Score)>),
    ) -> Vec<(usize, ResultsLine)> {
        let truth = self.next.take().flatten();
        let (mut lines, mut refused) = (Vec::new(), None);
        let places = &self.places;
        self.variants.process(&mut self.frame, &mut |of_reader, frame| {
            let place = places[of_reader];
            if frame.failure.is_some() {
                return each(place, frame, None);
            }
            let line = ResultsLine::of(frame);
            let score = truth.as_ref().map(|truth| Score::of(truth, &line));
            let judged = score.as_ref().and_then(|score| score.as_ref().ok());
            each(place, frame, truth.as_ref().zip(judged));
            refused = refused.take().or(score.and_then(Result::err));
            lines.push((place, line));
        });
        refused.into_iter().for_each(|error| self.judge.cannot(error.to_string()));
        lines
    }
}

/// A flight through a known mine that is followed with one configuration.
struct Followed {
    flight: Follower,
    mapper: Mapper,
    score: FlightScore,
}

impl Followed {
    fn new(mine: &TruthMap, config: &Config) -> Self {
        let vehicle_width_m = config.params("vehicle").get(VEHICLE_WIDTH_M);
        let flight = Follower::new(config.params("flight"), vehicle_width_m);
        Self { flight, mapper: Mapper::default(), score: FlightScore::new(mine) }
    }

    fn add(&mut self, frame: &mut Frame, truth: Option<&Truth>) {
        self.flight.add(frame);
        if let Some(truth) = truth {
            self.mapper.add(frame);
            self.score.add(frame, truth);
        }
    }
}

/// Answers every scan by every configuration, and compares each answer with the truth, if there is one, and with that of the
/// first. Answers are paired by `seq`, because a setting may leave out scans (`ingest.frame_id`). `each` is called after each scan.
pub(super) fn compare(
    (name, parts): (&str, &[PathBuf]),
    mut readers: Vec<Reader>,
    configurations: &[Configuration],
    stop: &StopFlag,
    each: &dyn Fn(),
) -> anyhow::Result<Compared> {
    let (mine, bad_map) = mine(parts, &readers)?;
    let configs = || configurations.iter().map(|of| &of.config);
    let mut followed: Vec<_> = configs().map(|config| mine.as_ref().map(|mine| Followed::new(mine, config))).collect();
    let rules: Vec<_> = configs().map(|config| config.params("report").get(CONFIDENCE)).collect();
    let mut differences = vec![Differences::default(); configurations.len() - 1];
    let mut surer: Vec<_> = rules[1..].iter().map(|other| Surer::by([&rules[0], other])).collect();
    let mut answers: Vec<Answers> = configs().map(|_| Answers::default()).collect();
    let (mut summary, mut first_stamp_ns) = (Summary::default(), None);
    let mut ended = readers.iter_mut().try_for_each(Reader::read);
    while let (Ok(()), Some(seq)) = (&ended, readers.iter().filter_map(Reader::seq).min()) {
        if stop.is_set() {
            summary.end = RunEnd::Interrupted;
            break;
        }
        let mut lines: Vec<Option<ResultsLine>> = vec![None; configurations.len()];
        for reader in readers.iter_mut().filter(|reader| reader.seq() == Some(seq)) {
            first_stamp_ns.get_or_insert(reader.frame.revolution.stamp_ns);
            let answered = reader.answer(&mut |place, frame, judged| {
                answers[place].add(frame, judged);
                if let (Some(followed), None) = (&mut followed[place], &frame.failure) {
                    followed.add(frame, judged.map(|(truth, _)| truth));
                }
            });
            answered.into_iter().for_each(|(place, line)| lines[place] = Some(line));
            ended = ended.and(reader.read());
        }
        let (first, others) = lines.split_first().expect("there is a configuration");
        for ((other, differences), surer) in others.iter().zip(&mut differences).zip(&mut surer) {
            match (first, other) {
                (Some(first), Some(other)) => {
                    let agreement = Agreement::of(first, other)?;
                    surer.add(!agreement.is_same(), agreement.confidence);
                    differences.add(&agreement);
                }
                (Some(_), None) => differences.answered_by_one[0] += 1,
                (None, Some(_)) => differences.answered_by_one[1] += 1,
                (None, None) => {}
            }
        }
        summary.revolutions += 1;
        each();
    }
    if let Err(failure) = ended {
        summary.end = RunEnd::Failed(failure);
    }
    for (answers, followed) in answers.iter_mut().zip(followed) {
        answers.flips = flips(&answers.walls).len();
        answers.flight = followed.map(|of| of.score.figures(&of.mapper.map()));
    }
    let has_truth = readers[0].flight.has_truths();
    let flown = readers.into_iter().map(|of| Flown::of(&of.flight, of.judge, Summary::default(), of.returns));
    let mut flown = flown.reduce(Flown::with_losses_of).expect("there is a configuration");
    flown.summary = summary;
    Ok(Compared {
        name: name.to_owned(),
        parts: parts.to_vec(),
        flown,
        has_truth,
        first_stamp_ns: first_stamp_ns.unwrap_or(0),
        answers,
        differences,
        surer,
        bad_map,
    })
}

/// The mine that the flight is through, if its recording holds it, or why that cannot be read.
fn mine(parts: &[PathBuf], readers: &[Reader]) -> anyhow::Result<(Option<TruthMap>, Option<String>)> {
    let [only] = parts else { return Ok((None, None)) };
    if !readers[0].flight.has_truths() || is_recorded(only) {
        return Ok((None, None)); // a recording of this program does not hold the map of the mine
    }
    Ok(match truth_map(only)?.transpose() {
        Ok(mine) => (mine, None),
        Err(error) => (None, Some(format!("{error}, in {}", only.display()))),
    })
}

fn is_recorded(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("rrd"))
}

impl Compared {
    /// Reports what is missing, and why it ended early; `whose` names the flight where there are several.
    pub(super) fn report(&self, whose: Option<&str>, configurations: &[Configuration], diagnostics: &mut Diagnostics) {
        diagnostics.lost_all(&self.bad_map);
        self.flown.report(whose, diagnostics);
        let at = whose.map_or_else(String::new, |whose| format!(", in {whose}"));
        for (Configuration { name, .. }, answers) in configurations.iter().zip(&self.answers) {
            if let Some((count, first)) = &answers.failed {
                let without = counted(*count, "revolution");
                diagnostics.error(format_args!("{name}{at}: {first}; {without} without an answer"));
            }
            let is_whole = matches!(self.flown.summary.end, RunEnd::Complete) && answers.revolutions() > 0;
            if is_whole && self.has_truth && answers.evaluation.revolutions() == 0 {
                diagnostics.error(format_args!("{name}{at}: no scan could be compared with its truth"));
            }
        }
    }
}
