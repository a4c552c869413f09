//! Conditions to stop at.

use std::fmt;

use crosscut_evaluate::Score;
use crosscut_flight::{FlightAnswer, HereKind};
use crosscut_messages::Truth;
use crosscut_stage::SURE;

use crate::Refused;
use crate::side::Answer;

/// A condition of a revolution.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum When {
    /// Count or place differ from those of the revolution before.
    Changed,
    /// The answer is not that of the truth.
    Wrong,
    /// The confidence is below that of sure answers.
    Unsure,
    /// Walls or place differ from those of the held answer.
    Differs,
    /// A note contains this text, whatever the case.
    Note(String),
    /// The place is a junction, and the one before was none.
    Junction,
    /// The stages fail.
    Fails,
    /// A figure compares so.
    Figure { name: &'static str, relation: Relation, value: f64 },
    /// The place has this name.
    Place(String),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Less,
    Equal,
    Not,
    More,
}

/// Figures that conditions name.
const FIGURES: [&str; 6] = ["walls", "k", "confidence", "margin", "returns", "openings"];

/// What there is to say of conditions.
pub(crate) const GRAMMAR: &str = "changed, wrong, unsure, differs, fails, note TEXT, junction, place=tee, or walls, k, confidence, margin, returns or \
     openings with <, =, != or > and a number, such as walls>3";

impl When {
    pub(crate) fn parse(words: &[String]) -> Result<Self, Refused> {
        let unknown =
            || Refused::Usage(format!("the condition {:?} is unknown; there are: {GRAMMAR}", words.join(" ")));
        let (first, rest) = words.split_first().ok_or_else(|| Refused::Usage(format!("a condition: {GRAMMAR}")))?;
        match (first.as_str(), rest) {
            ("note", rest) if !rest.is_empty() => return Ok(Self::Note(rest.join(" ").to_lowercase())),
            ("changed", []) => return Ok(Self::Changed),
            ("wrong", []) => return Ok(Self::Wrong),
            ("unsure", []) => return Ok(Self::Unsure),
            ("differs", []) => return Ok(Self::Differs),
            ("junction", []) => return Ok(Self::Junction),
            ("fails", []) => return Ok(Self::Fails),
            _ => {}
        }
        let text: String = words.concat();
        let at = text.find(['<', '=', '!', '>']).ok_or_else(unknown)?;
        let (name, rest) = text.split_at(at);
        let (relation, value) =
            [("!=", Relation::Not), ("<", Relation::Less), (">", Relation::More), ("=", Relation::Equal)]
                .into_iter()
                .find_map(|(sign, relation)| {
                    rest.strip_prefix(sign).map(|value| (relation, value.trim_start_matches('=')))
                })
                .ok_or_else(unknown)?;
        if name == "place" && relation == Relation::Equal {
            return Ok(Self::Place(value.to_owned()));
        }
        let name = FIGURES.into_iter().find(|known| *known == name).ok_or_else(unknown)?;
        Ok(Self::Figure { name, relation, value: value.parse().map_err(|_| unknown())? })
    }

    /// Whether it holds at `at`.
    pub(crate) fn holds(&self, at: usize, seen: &Seen<'_>) -> bool {
        let Answer { line, failure, .. } = &seen.answers[at];
        match self {
            Self::Changed => at.checked_sub(1).is_some_and(|before| {
                let before = &seen.answers[before].line;
                (before.junctions, &before.place) != (line.junctions, &line.place)
            }),
            Self::Wrong => {
                let score = seen.truths[at].and_then(|truth| Score::of(truth, line).ok());
                score.is_some_and(|score| !score.right)
            }
            Self::Unsure => line.confidence.is_some_and(|confidence| confidence < SURE),
            Self::Differs => seen.held[at].is_some_and(|held| !held.is_same(&seen.answers[at])),
            Self::Note(text) => line.notes.iter().any(|note| note.to_lowercase().contains(text)),
            Self::Junction => seen.is_junction(at) && !at.checked_sub(1).is_some_and(|before| seen.is_junction(before)),
            Self::Fails => failure.is_some(),
            Self::Place(name) => line.place == *name,
            Self::Figure { name, relation, value } => {
                let figure = match *name {
                    "walls" => line.junctions as f64,
                    "k" => line.k as f64,
                    "returns" => line.returns as f64,
                    "openings" => line.openings.len() as f64,
                    "margin" => line.margin.unwrap_or(f64::NAN),
                    _ => line.confidence.unwrap_or(f64::NAN),
                };
                match relation {
                    Relation::Less => figure < *value,
                    Relation::More => figure > *value,
                    Relation::Equal => figure == *value,
                    Relation::Not => !figure.is_nan() && figure != *value,
                }
            }
        }
    }
}

impl fmt::Display for When {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Changed => f.write_str("changed"),
            Self::Wrong => f.write_str("wrong"),
            Self::Unsure => f.write_str("unsure"),
            Self::Differs => f.write_str("differs"),
            Self::Note(text) => write!(f, "note {text}"),
            Self::Junction => f.write_str("junction"),
            Self::Fails => f.write_str("fails"),
            Self::Place(name) => write!(f, "place={name}"),
            Self::Figure { name, relation, value } => {
                let sign = match relation {
                    Relation::Less => "<",
                    Relation::Equal => "=",
                    Relation::Not => "!=",
                    Relation::More => ">",
                };
                write!(f, "{name}{sign}{value}")
            }
        }
    }
}

/// What conditions look at, an entry for each revolution of the flight.
pub(crate) struct Seen<'a> {
    pub(crate) answers: &'a [Answer],
    pub(crate) truths: Vec<Option<&'a Truth>>,
    pub(crate) held: Vec<Option<&'a Answer>>,
    /// Empty if no condition needs it.
    pub(crate) flown: &'a [FlightAnswer],
}

impl Seen<'_> {
    fn is_junction(&self, at: usize) -> bool {
        let here = self.flown.get(at).and_then(FlightAnswer::steady_here);
        here.is_some_and(|here| here.kind == HereKind::Junction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<When, Refused> {
        When::parse(&text.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn conditions_read_back_as_they_are_written() {
        for text in [
            "changed",
            "wrong",
            "unsure",
            "differs",
            "fails",
            "note 3 beams",
            "junction",
            "place=tee",
            "walls>3",
            "k!=2",
        ] {
            assert_eq!(parsed(text).expect(text).to_string(), text);
        }
        assert_eq!(parsed("confidence < 0.5").expect("spaces"), parsed("confidence<0.5").expect("none"));
    }

    #[test]
    fn what_is_no_condition_is_refused_with_those_there_are() {
        for text in ["", "chnaged", "walls", "walls>many", "height>3", "note", "place>tee"] {
            let refused = parsed(text).expect_err(text).to_string();
            assert!(refused.contains("changed, wrong"), "{text}: {refused}");
        }
    }
}
