//! The answers of the whole flight: again, and against what is held.

use std::collections::BTreeMap;
use std::time::Instant;

use crosscut_evaluate::Score;
use crosscut_evaluate::stage_values::{first_difference, stage_values};
use crosscut_evaluate::verdict::{Surer, SwapVerdict, listed, thousands};
use crosscut_report::CONFIDENCE;
use crosscut_stage::counted;

use crate::moves::{beside, nothing_held};
use crate::side::{Answer, Side};
use crate::{Refused, Session};

/// At most this many spans of revolutions are named in a line.
const SPANS: usize = 12;

impl Session {
    pub(crate) fn again(&mut self) -> Result<String, Refused> {
        let start = Instant::now();
        let answers = self.now.given.answer(&self.means)?;
        let taken_s = start.elapsed().as_secs_f64();
        let before = match &self.before {
            None => self.now.answers(&self.means)?.to_vec(),
            Some((_, Some(known))) => known.clone(),
            Some((given, None)) => given.answer(&self.means)?,
        };
        self.before = None;
        let by_seq: BTreeMap<u64, &Answer> = before.iter().map(|answer| (answer.line.seq, answer)).collect();
        let is_changed = |answer: &&Answer| by_seq.get(&answer.line.seq).is_none_or(|before| !before.is_same(answer));
        let changed: Vec<u64> = answers.iter().filter(is_changed).map(|answer| answer.line.seq).collect();
        let failed = answers.iter().filter(|answer| answer.failure.is_some()).count();
        let which = if changed.is_empty() { String::new() } else { format!(": {}", listed(&changed, SPANS)) };
        let failing =
            if failed > 0 { format!("; {} without an answer", thousands(failed as u64)) } else { String::new() };
        let of = counted(answers.len() as u64, "revolution").replacen(
            &answers.len().to_string(),
            &thousands(answers.len() as u64),
            1,
        );
        let text = format!(
            "{of} answered again in {taken_s:.2} s; {} changed{which}{failing}",
            thousands(changed.len() as u64)
        );
        self.now.set_answers(answers);
        Ok(text)
    }

    pub(crate) fn hold(&mut self) -> String {
        let mut held = Side::new(self.now.given.clone(), &self.means);
        held.go_to(self.at);
        if let Some(answers) = self.now.answered_if_known() {
            held.set_answers(answers.to_vec());
        }
        self.held = Some(held);
        self.version += 1;
        self.holds += 1;
        format!("A: {}", self.here())
    }

    pub(crate) fn diff(&mut self) -> Result<String, Refused> {
        if self.held.is_none() {
            return Err(nothing_held());
        }
        let held = self.held_frame().ok_or_else(|| Refused::Failed("A does not have this revolution".to_owned()))?;
        if let [Some(failure), _] | [_, Some(failure)] = [&held.failure, &self.frame().failure] {
            let which = if held.failure == self.frame().failure { "both fail" } else { "one fails" };
            return Ok(format!("{which}: {failure}"));
        }
        let sides = [held, self.frame()].map(stage_values);
        Ok(match first_difference(&sides[0], &sides[1]) {
            None => "the same in every stage".to_owned(),
            Some(first) => {
                let [a, b] = &first.values;
                format!("{}: {} is {a} in A, {b} now", first.step, first.field)
            }
        })
    }

    pub(crate) fn differs(&mut self) -> Result<String, Refused> {
        let means = &self.means;
        let held = self.held.as_mut().ok_or_else(nothing_held)?;
        let flight = self.now.given.flight.clone();
        let rules = [&*held, &self.now].map(|side| side.given.config.params("report").get(CONFIDENCE).to_owned());
        let held = beside(held, &flight, means)?;
        let mut surer = Surer::by([&rules[0], &rules[1]]);
        let (mut verdict, mut differ) = (None, Vec::new());
        let (mut mended, mut broken) = (Vec::new(), Vec::new());
        for ((now, held), scan) in self.now.answers(means)?.iter().zip(held).zip(flight.iter()) {
            let Some(held) = held else { continue };
            let seq = now.line.seq;
            let is_different = !held.is_same(now);
            surer.add(is_different, [held.line.confidence, now.line.confidence]);
            differ.extend(is_different.then_some(seq));
            let right = scan.truth.as_ref().map(|truth| {
                [held, now].map(|of| Score::of(truth, &of.line).is_ok_and(|score| of.failure.is_none() && score.right))
            });
            if let Some(right) = right {
                verdict.get_or_insert_with(SwapVerdict::default).add(right);
                mended.extend((right == [false, true]).then_some(seq));
                broken.extend((right == [true, false]).then_some(seq));
            }
        }
        let mut lines = Vec::new();
        lines.extend(verdict.map(|verdict: SwapVerdict| format!("{}.", verdict.sentence("now", None))));
        let which = if differ.is_empty() { String::new() } else { format!(": {}", listed(&differ, SPANS)) };
        lines.push(format!("{}{which}", surer.sentence("A", "now")));
        for (what, list) in [("mended", &mended), ("broken", &broken)] {
            lines.extend((!list.is_empty()).then(|| format!("{what}: {}", listed(list, SPANS))));
        }
        Ok(lines.join("\n"))
    }

    pub(crate) fn report(&mut self) -> Result<String, Refused> {
        let flight = self.now.given.flight.clone();
        let answers = self.now.answers(&self.means)?;
        let mut by_walls: BTreeMap<usize, u64> = BTreeMap::new();
        let (mut right, mut judged, mut failed) = (0, 0, 0);
        for (answer, scan) in answers.iter().zip(flight.iter()) {
            if answer.failure.is_some() {
                failed += 1;
                continue;
            }
            *by_walls.entry(answer.line.junctions).or_default() += 1;
            let score = scan.truth.as_ref().and_then(|truth| Score::of(truth, &answer.line).ok());
            judged += u64::from(score.is_some());
            right += u64::from(score.is_some_and(|score| score.right));
        }
        let line = |(walls, revolutions): (&usize, &u64)| {
            format!("{}: {}", counted(*walls as u64, "wall"), counted(*revolutions, "revolution"))
        };
        let mut lines: Vec<String> = by_walls.iter().map(line).collect();
        lines.extend((failed > 0).then(|| format!("without an answer: {failed}")));
        lines.extend((judged > 0).then(|| format!("right: {} of {}", thousands(right), thousands(judged))));
        Ok(lines.join("\n"))
    }
}
