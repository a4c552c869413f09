//! Which of several answers holds, by the answers of the revolutions so far: the forward pass of a hidden Markov model.
//!
//! With b_k the belief in answer k, d metres of way and t seconds since the revolution before, and an answer a of which
//! the revolution is sure by q:
//!
//! ```text
//! b_k <- (1 - p) b_k + p / K,   p = 1 - exp(-d / D - t / T)      the vehicle may have come to another place
//! b_k <- b_k · l_k,   l_k = q if k = a, else (1 - q) / (K - 1),   then Σ b = 1
//! ```
//!
//! Revolutions that follow each other err alike, so that many doubtful ones make no sure answer: an answer is as sure as it
//! is believed, and at most as sure as the surest of the revolutions that gave it, of which q counts (1 - p) times as much
//! with each one since.

/// Another answer holds once it is believed this many times as much as the one that held.
const ODDS: f64 = 20.0;

/// The place changes once in this way (D), and in this time (T) also if the vehicle stands: people and doors move.
const WAY_M: f64 = 3.0;
const TIME_S: f64 = 50.0;

/// This many answers are taken to be possible (K).
const ANSWERS: f64 = 6.0;

/// [`sure`] is within these bounds: errors of revolutions that follow each other are alike.
const LEAST_SURE: f64 = 0.4;
const MOST_SURE: f64 = 0.8;

/// Revolutions nearer in time than this see the same, and count less.
const INDEPENDENT_S: f64 = 0.1;

/// Answers that are no longer likely are forgotten beyond this number of them.
const MOST_KEPT: usize = 16;

/// The surest view of an answer is forgotten once it is less sure than this.
const LEAST_KEPT: f64 = 0.001;

/// The time from one revolution to the next; a usual one where stamps do not advance, as those of scans without a stamp.
pub(crate) fn elapsed_s(before_ns: u64, now_ns: u64) -> f64 {
    match now_ns.saturating_sub(before_ns) {
        0 => INDEPENDENT_S,
        elapsed_ns => elapsed_ns as f64 * 1e-9,
    }
}

/// How many independent views a revolution is, this long after the one before; at most one.
pub(crate) fn independent(elapsed_s: f64) -> f64 {
    (elapsed_s / INDEPENDENT_S).min(1.0)
}

/// How much the answer of a revolution counts (q). One without a confidence of its own, as of a method that has none, counts
/// as a doubtful one.
pub(crate) fn sure(confidence: f64) -> f64 {
    confidence.clamp(LEAST_SURE, MOST_SURE)
}

/// What has happened since the revolution before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since {
    pub(crate) way_m: f64,
    pub(crate) time_s: f64,
}

impl Since {
    /// The probability that the vehicle has come to another place (p).
    fn change(&self) -> f64 {
        1.0 - (-self.way_m / WAY_M - self.time_s / TIME_S).exp()
    }
}

/// The answer of a revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answered<A> {
    pub(crate) answer: A,
    pub(crate) confidence: f64,
    pub(crate) since: Since,
}

impl<A: Copy + PartialEq> Answered<A> {
    /// How likely it is where the first answer is right, and where another one is (l).
    fn likelihoods(&self) -> [f64; 2] {
        let sure = sure(self.confidence);
        let weight = independent(self.since.time_s);
        [sure, (1.0 - sure) / (ANSWERS - 1.0)].map(|likelihood| likelihood.powf(weight))
    }

    /// Of normalised weights: the vehicle may have come to another place since the revolution before, or will have.
    fn allow_change(&self, weights: &mut [(A, f64)]) {
        let change = self.since.change();
        weights.iter_mut().for_each(|(_, weight)| *weight = (1.0 - change) * *weight + change / ANSWERS);
    }

    /// Multiplies each weight by how likely this answer is where that answer is right.
    fn weigh(&self, weights: &mut [(A, f64)]) {
        let [alike, other] = self.likelihoods();
        for (known, weight) in weights {
            *weight *= if *known == self.answer { alike } else { other };
        }
    }
}

/// The weight of an answer; 0 of one that was not given.
fn of_answer<A: PartialEq>(weights: &[(A, f64)], answer: A) -> f64 {
    weights.iter().find(|(known, _)| *known == answer).map_or(0.0, |(_, weight)| *weight)
}

fn normalise<A>(weights: &mut [(A, f64)]) {
    let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
    weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
}

/// The beliefs in the answers that were given, and the answer that holds.
#[derive(Clone, Debug)]
pub(crate) struct Belief<A> {
    holds: Option<A>,
    /// The belief in each answer (b).
    beliefs: Vec<(A, f64)>,
    /// How sure the surest of the revolutions up to now is that gave an answer.
    surest: Vec<(A, f64)>,
}

impl<A> Default for Belief<A> {
    fn default() -> Self {
        Self { holds: None, beliefs: Vec::new(), surest: Vec::new() }
    }
}

impl<A: Copy + PartialEq> Belief<A> {
    /// The answer that holds; `None` before the first.
    pub(crate) fn holds(&self) -> Option<A> {
        self.holds
    }

    /// The probability that an answer is right, after what has happened since the last revolution that answered.
    pub(crate) fn confidence(&self, answer: A, since: Since) -> f64 {
        let change = since.change();
        let all: f64 = self.beliefs.iter().map(|(_, belief)| belief).sum(); // 1 but for rounding, and for answers that were forgotten
        let believed = (1.0 - change) * (of_answer(&self.beliefs, answer) / all) + change / ANSWERS;
        believed.min((1.0 - change) * of_answer(&self.surest, answer))
    }

    /// Takes the answer of the next revolution. The answer that holds changes to this one or not at all.
    pub(crate) fn add(&mut self, seen: Answered<A>) {
        seen.allow_change(&mut self.beliefs);
        if !self.beliefs.iter().any(|(known, _)| *known == seen.answer) {
            self.beliefs.push((seen.answer, (seen.since.change() / ANSWERS).max(f64::MIN_POSITIVE)));
        }
        seen.weigh(&mut self.beliefs);
        normalise(&mut self.beliefs);
        self.view(&seen);
        let held = self.holds.map_or(0.0, |answer| of_answer(&self.beliefs, answer));
        // Of equal ones the first.
        let likeliest = self.beliefs.iter().rev().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((answer, _)) = likeliest.filter(|(_, belief)| *belief > ODDS * held) {
            self.holds = Some(*answer);
        }
        if self.beliefs.len() > MOST_KEPT {
            self.beliefs.sort_by(|a, b| b.1.total_cmp(&a.1));
            let holds = self.holds;
            let mut kept = 0;
            self.beliefs.retain(|(known, _)| {
                kept += 1;
                kept < MOST_KEPT || Some(*known) == holds
            });
        }
    }

    /// Takes how sure a revolution is; what is hardly sure any more is forgotten.
    fn view(&mut self, seen: &Answered<A>) {
        let stays = 1.0 - seen.since.change();
        let before = stays * of_answer(&self.surest, seen.answer);
        self.surest.iter_mut().for_each(|(_, confidence)| *confidence *= stays);
        self.surest.retain(|(known, confidence)| *known != seen.answer && *confidence > LEAST_KEPT);
        self.surest.push((seen.answer, before.max(seen.confidence)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDING: Since = Since { way_m: 0.0, time_s: 0.1 };
    const FLYING: Since = Since { way_m: 0.15, time_s: 0.1 };

    /// The answers that hold after each of those of the revolutions.
    fn held(answers: &[(usize, f64)], since: Since) -> Vec<usize> {
        let mut belief = Belief::default();
        let held = |&(answer, confidence): &(usize, f64)| {
            belief.add(Answered { answer, confidence, since });
            belief.holds().expect("there is an answer")
        };
        answers.iter().map(held).collect()
    }

    #[test]
    fn single_deviations_change_nothing_and_a_lasting_change_is_seen_in_half_a_second() {
        let mut answers = vec![(2, 0.9); 20];
        answers[10] = (3, 0.9);
        assert_eq!(held(&answers, FLYING), [2; 20]);
        answers[12..].fill((3, 0.9));
        let held = held(&answers, FLYING);
        assert_eq!((held[11], held[16..].to_vec()), (2, vec![3; 4]), "{held:?}");
    }

    #[test]
    fn doubtful_answers_in_turn_do_not_move_a_standing_vehicle() {
        let answers: Vec<_> = (0..200).map(|i| (2 + usize::from(i % 3 == 1), 0.5)).collect();
        let held = held(&answers, STANDING);
        assert!(held[10..].iter().all(|held| *held == 2), "{held:?}");
    }

    #[test]
    fn one_clear_view_weighs_more_than_a_doubtful_one() {
        let after = |confidence| held(&[&[(2, 0.6)], &[(3, confidence); 4][..]].concat(), FLYING)[4];
        assert_eq!((after(0.9), after(0.3)), (3, 2));
    }

    #[test]
    fn many_doubtful_views_make_no_sure_answer_and_one_sure_view_fades_with_the_way() {
        let mut belief = Belief::default();
        let mut sure_after = |confidence, count| {
            (0..count).for_each(|_| belief.add(Answered { answer: 3, confidence, since: FLYING }));
            belief.confidence(3, Since { way_m: 0.0, time_s: 0.0 })
        };
        assert_eq!(sure_after(0.05, 200), 0.05);
        assert!(sure_after(0.95, 1) > 0.9);
        let after_3m = sure_after(0.05, 20);
        assert!((0.3..0.4).contains(&after_3m), "{after_3m}");
        let unseen_for_30m = belief.confidence(3, Since { way_m: 30.0, time_s: 1.0 });
        assert!(unseen_for_30m < 0.01, "{unseen_for_30m}");
    }

    #[test]
    fn the_number_of_answers_that_are_kept_is_bounded() {
        let mut belief = Belief::default();
        (0..1000).for_each(|i| belief.add(Answered { answer: i, confidence: 0.9, since: FLYING }));
        assert!(belief.beliefs.len() <= MOST_KEPT && belief.holds().is_some());
    }
}
