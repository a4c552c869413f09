//! What is shown of a revolution, with small pictures in text.

mod matrix;
mod scan;
mod spectrum;
mod strip;

use crosscut_explain::{Explanation, inequality, ways};
use crosscut_flight::{FlightAnswer, Here};
use crosscut_stage::{Frame, Verdict};

use crate::command::takes;
use crate::session::answer_in_words;
use crate::{Refused, Session};

impl Session {
    pub(crate) fn show(&mut self, words: &[String]) -> Result<String, Refused> {
        let what = match words {
            [] => return Ok(self.show_answer()),
            [what] => what.as_str(),
            _ => return Err(takes("show")),
        };
        let known = ["scan", "W", "L", "spectrum", "U", "walls", "openings", "here", "pose"];
        if !known.contains(&what) {
            return Err(takes("show"));
        }
        let frame = self.frame();
        if frame.failure.is_some() && what != "scan" {
            return Err(Refused::Failed(answer_in_words(frame)));
        }
        let text = match what {
            "scan" => scan::picture(frame),
            "W" => matrix::picture(&crate::matrices::w(frame), "W"),
            "L" => matrix::picture(&crate::matrices::l(frame)?, "L"),
            "spectrum" => spectrum::bars(&frame.spectrum),
            "U" => strip::columns(frame),
            "walls" => strip::walls(frame),
            "openings" => openings(frame),
            _ => return self.show_flown(what),
        };
        Ok(text)
    }

    fn show_answer(&mut self) -> String {
        let frame = self.frame();
        let mut lines = vec![self.here(), format!("returns: {}", frame.revolution.len())];
        if frame.failure.is_none() {
            let margin = frame.spectrum.margin_decades;
            let margin = margin.map_or_else(String::new, |decades| format!(", a margin of {decades:.1} decades"));
            lines.push(format!("zeros: {}{margin}", inequality(&frame.spectrum)));
            lines.extend(strip::of_walls(frame));
        }
        if let Some(truth) = &self.now.given.flight[self.at].truth {
            lines.push(format!("truth: {} walls, {} openings", truth.walls, truth.openings.len()));
        }
        lines.extend(frame.notes.iter().map(|note| format!("note: {note}")));
        lines.join("\n")
    }

    /// The place or the pose, of which the flight so far is a part.
    fn show_flown(&mut self, what: &str) -> Result<String, Refused> {
        let at = self.at;
        let flown: FlightAnswer = self.now.flown(&self.means)?[at].clone();
        if what == "pose" {
            return Ok(match flown.pose {
                None => "no pose is known".to_owned(),
                Some(pose) => {
                    let ([x, y], yaw) = (<[f64; 2]>::from(pose.translation.vector), pose.rotation.angle());
                    let turned_deg = yaw.to_degrees();
                    format!("{x:.2} m ahead and {y:.2} m left of the first pose, turned by {turned_deg:+.1}°")
                }
            });
        }
        let words = |name: &str, here: Option<&Here>| match here {
            None => format!("{name}: none"),
            Some(here) => {
                let ways: Vec<String> = here.ways.iter().map(|way| degrees(way.bearing_rad)).collect();
                let (kind, confidence) = (here.kind.name().replace('_', " "), here.confidence);
                format!("{name}: {kind}, ways at {}, confidence {confidence:.2}", ways.join(", "))
            }
        };
        let (here, steady) = (flown.here.as_ref(), flown.steady_here());
        Ok(format!("{}\n{}", words("this revolution", here), words("steady", steady)))
    }

    pub(crate) fn why(&mut self, words: &[String]) -> Result<String, Refused> {
        let frame = self.frame();
        if frame.failure.is_some() {
            return Err(Refused::Failed(answer_in_words(frame)));
        }
        let verdicts = &frame.affinity.verdicts;
        match words {
            [] => {
                let text = Explanation::of(frame).to_markdown(frame, &|_| "");
                Ok(text.replace("**", "").replace("## ", "").replace("\n\n", "\n"))
            }
            [gap] if gap == "gap" => {
                if verdicts.is_empty() {
                    return Err(no_verdicts());
                }
                let lines: Vec<String> =
                    verdicts.iter().enumerate().map(|(at, verdict)| gap_in_words(frame, at, verdict)).collect();
                Ok(lines.join("\n"))
            }
            [gap, number] if gap == "gap" => {
                if verdicts.is_empty() {
                    return Err(no_verdicts());
                }
                let at = number.parse::<usize>().ok().filter(|at| *at < verdicts.len());
                let at = at.ok_or_else(|| Refused::Usage(format!("gaps are numbered 0 to {}", verdicts.len() - 1)))?;
                let verdict = &verdicts[at];
                let [a, b] = verdict.returns;
                let mut weight = 0.0;
                frame.affinity.weights.for_each(|i, j, w| {
                    if (i, j) == (a as usize, b as usize) {
                        weight = w;
                    }
                });
                Ok(format!("{}\nW[{a}, {b}] = {weight:?}", gap_in_words(frame, at, verdict)))
            }
            _ => Err(takes("why")),
        }
    }
}

fn no_verdicts() -> Refused {
    Refused::Failed("this affinity decides nothing at gaps; `why` has the edges that decide the count".to_owned())
}

/// "gap 3, -12° to +5°, 3.46 m: an opening, 1.8 times the room that it needs (a wall goes on behind it)".
fn gap_in_words(frame: &Frame, at: usize, verdict: &Verdict) -> String {
    let [from, to] = verdict.returns.map(|i| degrees(frame.revolution.bearing_rad(i as usize)));
    let what = if verdict.is_opening { "an opening" } else { "the wall continues" };
    let odds = verdict.p.map_or_else(String::new, |p| format!(", p = {p:.2}"));
    let Verdict { room_ratio, reason, measured, .. } = verdict;
    let width_m = width_m(frame, verdict);
    let room = match measured {
        Some(measured) => format!("{measured} ({reason}; {room_ratio:.2})"),
        None => format!("{room_ratio:.2} times the room that an opening needs ({reason})"),
    };
    format!("gap {at}, {from} to {to}, {width_m:.2} m: {what}; {room}{odds}")
}

fn width_m(frame: &Frame, verdict: &Verdict) -> f64 {
    let [a, b] = verdict.returns.map(|i| frame.revolution.points_m[i as usize]);
    (a - b).norm()
}

fn openings(frame: &Frame) -> String {
    let line = |opening: &crosscut_stage::Opening| {
        let [a, b] = opening.walls;
        let odds = opening.p.map_or_else(String::new, |p| format!(", p = {p:.2}"));
        let (at, width_m, evidence) = (degrees(opening.bearing_rad), opening.width_m, opening.evidence.to_string());
        let (evidence, known) = (evidence.replace('_', " "), opening.known);
        format!("{at}: {width_m:.2} m wide, between walls {a} and {b}{odds} ({known}; {evidence})")
    };
    let mut lines: Vec<String> = frame.junction.openings.iter().map(line).collect();
    lines.extend(ways(frame, &|_| "").into_iter().map(|line| line.replace("**", "")));
    if lines.is_empty() { "no opening".to_owned() } else { lines.join("\n") }
}

pub(crate) fn degrees(rad: f64) -> String {
    format!("{:+.0}°", rad.to_degrees())
}

/// The sign in which a wall is drawn: 0 to 9, then letters.
pub(crate) fn sign(wall: u32) -> char {
    char::from_digit(wall % 36, 36).unwrap_or('?')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_have_signs_of_one_character() {
        assert_eq!([0, 9, 10, 35, 36].map(sign), ['0', '9', 'a', 'z', '0']);
    }
}
