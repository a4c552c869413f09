//! Going through the flight.

use crate::command::takes;
use crate::side::{Answer, Means, Side};
use crate::when::{Seen, When};
use crate::{Refused, Session};

impl Session {
    pub(crate) fn seek(&mut self, to: &str) -> Result<String, Refused> {
        let flight = &self.now.given.flight;
        let at = if let Some(seconds) = to.strip_suffix('s') {
            let seconds: f64 = seconds.parse().map_err(|_| takes("seek"))?;
            (0..flight.len()).find(|&at| self.seconds(at) >= seconds)
        } else {
            let seq: u64 = to.parse().map_err(|_| takes("seek"))?;
            self.now.place_of(seq)
        };
        let at = at.ok_or_else(|| {
            let [first, last] = [0, flight.len() - 1].map(|at| flight[at].revolution.seq);
            let last_s = self.seconds(flight.len() - 1);
            Refused::Failed(format!(
                "the flight has no {to}; it has revolutions {first} to {last}, 0 s to {last_s:.2} s"
            ))
        })?;
        self.go_to(at);
        Ok(self.here())
    }

    pub(crate) fn step(&mut self, words: &[String]) -> Result<String, Refused> {
        let by: i64 = match words {
            [] => 1,
            [by] => by.parse().map_err(|_| takes("step"))?,
            _ => return Err(takes("step")),
        };
        let last = self.now.given.flight.len() as i64 - 1;
        let to = (self.at as i64).saturating_add(by).clamp(0, last);
        if to == self.at as i64 && by != 0 {
            let end = if by > 0 { "last" } else { "first" };
            return Err(Refused::Failed(format!("this is the {end} revolution")));
        }
        self.go_to(to as usize);
        Ok(self.here())
    }

    pub(crate) fn next(&mut self, words: &[String]) -> Result<String, Refused> {
        let when = When::parse(words)?;
        match self.first_after(std::slice::from_ref(&when))? {
            Some((at, _)) => {
                self.go_to(at);
                Ok(self.here())
            }
            None => Err(Refused::Failed(format!("no later revolution: {when}"))),
        }
    }

    pub(crate) fn set_break(&mut self, words: &[String]) -> Result<String, Refused> {
        match words {
            [] => {}
            [off] if off == "off" => self.breaks.clear(),
            words => {
                let when = When::parse(words)?;
                self.refuse_unanswerable(&when)?;
                if !self.breaks.contains(&when) {
                    self.breaks.push(when);
                }
            }
        }
        let list: Vec<String> = self.breaks.iter().map(ToString::to_string).collect();
        Ok(if list.is_empty() { "no break".to_owned() } else { format!("breaks: {}", list.join("; ")) })
    }

    pub(crate) fn run(&mut self) -> Result<String, Refused> {
        if self.breaks.is_empty() {
            return Err(Refused::Usage("run stops where a break holds; `break changed` sets one".to_owned()));
        }
        let breaks = self.breaks.clone();
        let found = self.first_after(&breaks)?;
        let (at, why) = match &found {
            Some((at, when)) => (*at, when.to_string()),
            None => (self.now.given.flight.len() - 1, "the end".to_owned()),
        };
        self.go_to(at);
        Ok(format!("{why}: {}", self.here()))
    }

    /// The first place after the present one where a condition holds, with that condition.
    fn first_after(&mut self, conditions: &[When]) -> Result<Option<(usize, When)>, Refused> {
        conditions.iter().try_for_each(|when| self.refuse_unanswerable(when))?;
        let needs = |needed: &When| conditions.contains(needed);
        let means = &self.means;
        let flight = self.now.given.flight.clone();
        let flown = if needs(&When::Junction) { self.now.flown(means)?.to_vec() } else { Vec::new() };
        let mut held: Vec<Option<&Answer>> = vec![None; flight.len()];
        if let Some(side) = &mut self.held
            && needs(&When::Differs)
        {
            held = beside(side, &flight, means)?;
        }
        let answers = self.now.answers(means)?;
        let truths = flight.iter().map(|scan| scan.truth.as_ref()).collect();
        let seen = Seen { answers, truths, held, flown: &flown };
        let holds = |at: usize| Some((at, conditions.iter().find(|when| when.holds(at, &seen))?.clone()));
        Ok((self.at + 1..flight.len()).find_map(holds))
    }

    /// Refuses conditions that can never hold, and says what is missing.
    fn refuse_unanswerable(&self, when: &When) -> Result<(), Refused> {
        let has_truth = self.now.given.flight.iter().any(|scan| scan.truth.is_some());
        match when {
            When::Wrong if !has_truth => {
                Err(Refused::Usage("the recording has no truth, so nothing is wrong".to_owned()))
            }
            When::Differs if self.held.is_none() => Err(nothing_held()),
            _ => Ok(()),
        }
    }
}

/// The answers of the other side for each scan of the flight, where it has it.
pub(crate) fn beside<'a>(
    side: &'a mut Side,
    flight: &[crate::Scan],
    means: &Means,
) -> Result<Vec<Option<&'a Answer>>, Refused> {
    side.answers(means)?;
    let side = &*side;
    let of = |scan: &crate::Scan| side.place_of(scan.revolution.seq).and_then(|at| side.answered().get(at));
    Ok(flight.iter().map(of).collect())
}

/// The refusal where nothing is held.
pub(crate) fn nothing_held() -> Refused {
    Refused::Usage("nothing is held to compare with; `hold` keeps the present settings as A".to_owned())
}
