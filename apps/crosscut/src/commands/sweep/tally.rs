//! What is counted of one configuration on one flight.

use crosscut_evaluate::{Evaluation, Score, flips};
use crosscut_stage::{Frame, SURE, Step};
use serde_json::{Value, json};

/// Sums over the revolutions of a flight.
#[derive(Default)]
pub(super) struct Tally {
    junctions: Vec<usize>,
    /// Sum and number of those that are known.
    confidence: (f64, u64),
    sure: u64,
    failed: u64,
    evaluation: Evaluation,
    /// The `seq` of each revolution that was compared with its truth: those that are right, those that are wrong.
    right_at: Vec<u64>,
    wrong_at: Vec<u64>,
    /// Of each step, in the order of [`Step::ALL`].
    times_ns: [Vec<u64>; Step::ALL.len()],
}

impl Tally {
    /// Adds the answer to a revolution, with its score if there is a truth.
    pub(super) fn add(&mut self, frame: &Frame, score: Option<&Score>) {
        if frame.failure.is_some() {
            self.failed += 1;
            return;
        }
        self.junctions.push(frame.junction.junctions);
        if let Some(confidence) = frame.junction.confidence {
            self.confidence = (self.confidence.0 + confidence, self.confidence.1 + 1);
            self.sure += u64::from(confidence >= SURE);
        }
        for (step, times_ns) in Step::ALL.into_iter().zip(&mut self.times_ns) {
            times_ns.push(frame.timings.ns(step));
        }
        if let Some(score) = score {
            self.evaluation.add(score);
            if score.right { &mut self.right_at } else { &mut self.wrong_at }.push(frame.revolution.seq);
        }
    }

    /// Figures by name; null where there is nothing to tell.
    pub(super) fn figures(&self) -> Value {
        let revolutions = self.junctions.len();
        let mean = |sum: f64| (revolutions > 0).then(|| sum / revolutions as f64);
        let (sum, known) = self.confidence;
        let figures = self.evaluation.figures();
        let share = |proportion: crosscut_evaluate::Proportion| proportion.value();
        json!({
            "revolutions": revolutions,
            "failed": self.failed,
            "mean_junctions": mean(self.junctions.iter().sum::<usize>() as f64),
            "flips": flips(&self.junctions).len(),
            "mean_confidence": (known > 0).then(|| sum / known as f64),
            "sure": (known > 0).then(|| self.sure as f64 / known as f64),
            "compared": figures.revolutions,
            "right": share(figures.right),
            "right_count": share(figures.right_count),
            "sure_right": share(figures.confidence.sure_right),
            "auroc": figures.confidence.auroc,
            "openings_missed": share(figures.openings.missed),
            "openings_false": share(figures.openings.false_alarms),
        })
    }

    /// The revolutions that are right, and those that are wrong.
    pub(super) fn judged(&self) -> [&[u64]; 2] {
        [&self.right_at, &self.wrong_at]
    }

    /// The median time of each step, ms.
    pub(super) fn times_ms(mut self) -> Value {
        let mut median_ms = |step: Step| {
            let times_ns = &mut self.times_ns[step as usize];
            times_ns.sort_unstable();
            times_ns.get(times_ns.len() / 2).map(|ns| *ns as f64 / 1e6)
        };
        let steps = Step::ALL.map(|step| (step.name().to_owned(), json!(median_ms(step))));
        Value::Object(steps.into_iter().collect())
    }
}
