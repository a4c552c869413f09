//! The explanation as text.

use crosscut_stage::{Beam, Frame, Junction, KnownGaps, Place, Spectrum, Verdict, counted};

use crate::judged::{Judged, judged};
use crate::ways::{numbered, ways};
use crate::{Change, Edge, Explanation, WallEdges};

/// The text has a line for at most this many walls.
const MOST_WALLS: usize = 12;
/// The text has a line for at most this many verdicts.
const MOST_VERDICTS: usize = 5;

impl Explanation {
    /// The explanation as Markdown: the count in a sentence, then its [details](Self::details). `color_of` names the colour
    /// in which a wall is drawn, or a way where these are counted; empty where it is not drawn.
    pub fn to_markdown(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> String {
        format!("{}\n\n{}", self.title(frame, color_of), self.details(frame, color_of))
    }

    /// The [sentence](Self::sentence) as a title with its reason.
    pub fn title(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> String {
        let [walls, nearest] = self.sentence(frame, color_of);
        if nearest.is_empty() { format!("## {walls}") } else { format!("## {walls}\n\n**{nearest}**") }
    }

    /// The details as Markdown: the inequality that gives k, changes that would give another k, verdicts, the edges of each
    /// wall, and what was left out.
    pub fn details(&self, frame: &Frame, color_of: &dyn Fn(u32) -> &'static str) -> String {
        let words = Words { frame, color_of };
        let mut paragraphs = vec![words.count(), words.inequality()];
        paragraphs.extend(self.changes.iter().map(|change| words.change(change)));
        paragraphs.extend(frame.affinity.holds_for_width_m.map(|m| widths(frame.junction.junctions, m)));
        paragraphs.extend(words.gaps());
        paragraphs.extend(words.verdicts());
        paragraphs.extend(words.walls(self));
        paragraphs.extend(self.closest.map(|(walls, returns)| words.closest(walls, returns)));
        paragraphs.push(words.left_out());
        paragraphs.join("\n\n")
    }
}

/// A count holds for every width if it holds for this one: no vehicle is wider.
const ANY_WIDTH_M: f64 = 100.0;

struct Words<'a> {
    frame: &'a Frame,
    color_of: &'a dyn Fn(u32) -> &'static str,
}

impl Words<'_> {
    fn count(&self) -> String {
        let (k, junction) = (self.frame.spectrum.k, &self.frame.junction);
        let place = junction.place.words();
        if junction.ways.is_some() {
            let rows = self.frame.affinity.degrees.len();
            let lines: Vec<String> = ways(self.frame, self.color_of).iter().map(|line| format!("- {line}")).collect();
            return format!(
                "k = {k} zeros of L, whose rows are {rows} directions in which the vehicle gets on: each component is a way on. Walls \
                 and place ({place}) are those of the level view.\n{}",
                lines.join("\n")
            );
        }
        let mut text = format!(
            "Place: {place}{}. k = {k} zeros of L, {}.",
            self.place_against_count(),
            counted(junction.junctions as u64, "wall")
        );
        let islands = junction.walls.iter().filter(|wall| wall.island).count();
        let small = k.saturating_sub(junction.junctions + islands);
        let beside = [
            (islands, counted(islands as u64, "island")),
            (small, counted(small as u64, "cluster") + " too small to be a wall"),
        ];
        let beside: Vec<String> = beside.into_iter().filter(|(count, _)| *count > 0).map(|(_, words)| words).collect();
        if k > junction.junctions && !beside.is_empty() {
            text += &format!(" k also counts {}.", beside.join(" and "));
        }
        text
    }

    /// Why the place, which goes by openings, has another number of them than there are walls: ", by its 3 openings; there is none
    /// between 2 (orange) and 3 (vermilion)". Empty where both numbers agree, and of a view that is not named.
    fn place_against_count(&self) -> String {
        let Junction { junctions, walls, openings, wall_of_return, place, .. } = &self.frame.junction;
        let is_named = !matches!(place, Place::PartialView | Place::Closed);
        if !is_named || *junctions == openings.len() {
            return String::new();
        }
        let of_return = |i: u32| wall_of_return.get(i as usize).copied().flatten();
        let parted = |[a, b]: [u32; 2]| {
            openings.iter().any(|opening| {
                let gaps = opening.gaps.iter().map(|gap| gap.map(of_return));
                let mut pairs = gaps.chain([opening.walls.map(Some)]);
                pairs.any(|pair| pair == [Some(a), Some(b)] || pair == [Some(b), Some(a)])
            })
        };
        let is_island = |id: &u32| walls.get(*id as usize).is_some_and(|wall| wall.island);
        let around: Vec<u32> = wall_of_return.iter().flatten().copied().filter(|id| !is_island(id)).collect();
        let pairs = around
            .windows(2)
            .map(|pair| [pair[0], pair[1]])
            .chain(around.last().zip(around.first()).map(|(a, b)| [*a, *b]));
        let mut closed: Vec<[u32; 2]> = pairs.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        closed.sort_unstable();
        closed.dedup();
        closed.retain(|pair| !parted(*pair));
        let none = closed.iter().map(|[a, b]| format!("between {} and {}", self.wall(*a), self.wall(*b)));
        let none = none.take(2).collect::<Vec<_>>().join(" nor ");
        let through = openings.iter().any(|opening| !opening.gaps.is_empty());
        let why = match (none.is_empty(), through) {
            (false, _) => format!("; there is none {none}"),
            (true, true) => "; a wall is seen through one of them, with a gap on both of its sides".to_owned(),
            (true, false) => "; both sides of one are the same wall".to_owned(),
        };
        format!(", by its {}{why}", counted(openings.len() as u64, "opening"))
    }

    /// The inequality that gives k, and the margin.
    fn inequality(&self) -> String {
        let spectrum = &self.frame.spectrum;
        let margin = spectrum.margin_decades.map(|decades| format!(": a margin of {decades:.1} decades"));
        format!("{}{}.", inequality(spectrum), margin.unwrap_or_default())
    }

    fn change(&self, change: &Change) -> String {
        let up = change.k > self.frame.spectrum.k;
        let (side, decades) = (if up { "above" } else { "below" }, change.decades.abs());
        let mut text =
            format!("**k = {}** with τ {side} {} ({decades:.1} decades away)", change.k, power(change.eigenvalue));
        if let Some(sigma) = change.sigma_per_m2 {
            text += &format!(", or σ about {sigma:.2} per m²");
        }
        match (change.walls.as_slice(), change.edge) {
            ([wall], Some(edge)) => text += &format!(": {} would break at {}", self.wall(*wall), self.edge(edge)),
            ([a, b], Some(edge)) => {
                text += &format!(": {} and {} would be joined by {}", self.wall(*a), self.wall(*b), self.edge(edge));
            }
            ([a, b], None) => {
                let (a, b) = (self.wall(*a), self.wall(*b));
                text += &format!(": {a} and {b} are the nearest to being one; no single edge explains it");
            }
            _ => text += "; no single edge explains it",
        }
        text + "."
    }

    /// The verdicts closest to the threshold, of an affinity that decides where walls end.
    fn verdicts(&self) -> Option<String> {
        let line = |Judged { verdict, walls, .. }: &Judged| {
            let what = match (verdict.is_opening, verdict.room_ratio >= 1.0) {
                (true, _) => "an opening",
                (false, false) => "the wall continues",
                (false, true) => "the wall continues nevertheless, because its pieces were joined one by one",
            };
            let between = self.between(verdict.returns.map(|i| i as usize));
            let whose = match *walls {
                [Some(a), Some(b)] if a != b => format!(" between {} and {}", self.wall(a), self.wall(b)),
                [Some(a), Some(_)] => format!(" in {}", self.wall(a)),
                _ => String::new(),
            };
            let Verdict { room_ratio, reason, measured, .. } = verdict;
            let overruled = if verdict.is_opening { ", overruled by the rule" } else { "" };
            let odds =
                verdict.p.map_or(String::new(), |p| format!(", p = {p:.2}{}", if p < 0.5 { overruled } else { "" }));
            let room = match measured {
                Some(measured) => format!("**{measured}** ({reason}; {room_ratio:.2})"),
                None if *room_ratio == 0.0 => format!("a rule forbids an opening ({reason})"),
                None => format!("**{room_ratio:.2}** times the room that an opening needs ({reason})"),
            };
            format!("- {what}{whose} ({between}): {room}{odds}")
        };
        let lines: Vec<String> = judged(self.frame).iter().take(MOST_VERDICTS).map(line).collect();
        let title = "Verdicts where walls may end, the closest to the threshold first: what decides, by which rule and with how \
                     many times the room that an opening needs; p, the probability of an opening, forbids one below 0.3 where \
                     something is seen in the gap, else the rule decides:";
        (!lines.is_empty()).then(|| format!("{title}\n{}", lines.join("\n")))
    }

    /// How the gaps are known, of an affinity that decides where walls end.
    fn gaps(&self) -> Option<String> {
        let KnownGaps { seen, proved, judged } = self.frame.junction.gaps;
        let text = format!("Gaps: {judged} judged, {seen} seen through, {proved} proved to be closed.");
        (!self.frame.affinity.verdicts.is_empty()).then_some(text)
    }

    /// A line for each wall with its weakest and its strongest edge.
    fn walls(&self, explanation: &Explanation) -> Option<String> {
        let walls = &explanation.walls;
        let mut lines: Vec<String> = walls.iter().take(MOST_WALLS).map(|wall| self.edges_of(wall)).collect();
        if walls.len() > MOST_WALLS {
            lines.push(format!("- and {} more", walls.len() - MOST_WALLS));
        }
        let title = "The edges of each wall:";
        (!lines.is_empty()).then(|| format!("{title}\n{}", lines.join("\n")))
    }

    fn edges_of(&self, wall: &WallEdges) -> String {
        let inside = match wall.weakest {
            Some(edge) => format!("weakest edge inside {}", self.edge(edge)),
            None if wall.parts > 1 => format!("{} parts without an edge between them", wall.parts),
            None => "no edge inside".to_owned(),
        };
        let outside = match wall.strongest {
            Some((to, edge)) => format!("strongest edge to another wall {}, to {}", self.edge(edge), self.wall(to)),
            None => "no edge to another wall".to_owned(),
        };
        let returns = self.frame.junction.wall_of_return.iter().filter(|of| **of == Some(wall.wall)).count();
        let returns = counted(returns as u64, "return");
        format!("- **{}**, {returns}: {inside}; {outside}", self.wall(wall.wall))
    }

    fn closest(&self, [a, b]: [u32; 2], returns: [usize; 2]) -> String {
        let (a, b, between) = (self.wall(a), self.wall(b), self.between(returns));
        format!("W has no edge between walls. The closest two are {a} and {b}: {between}.")
    }

    fn left_out(&self) -> String {
        let frame = self.frame;
        let of_no_wall = frame.junction.wall_of_return.iter().filter(|wall| wall.is_none()).count();
        let mut lines =
            vec![format!("{}, {of_no_wall} of them in no wall.", counted(frame.revolution.len() as u64, "return"))];
        if let Some(sweep) = frame.revolution.beams() {
            let unknown = sweep.beams.iter().filter(|beam| **beam == Beam::Unknown).count();
            let nothing = sweep.beams.iter().filter(|beam| **beam == Beam::NoReturn).count();
            lines.push(format!(
                "Of {}, {nothing} have no return in range and {unknown} are unknown.",
                counted(sweep.len() as u64, "beam")
            ));
        }
        lines.extend(frame.notes.iter().map(|note| format!("- {note}")));
        lines.join("\n")
    }

    fn wall(&self, id: u32) -> String {
        wall(id, (self.color_of)(id))
    }

    fn edge(&self, edge: Edge) -> String {
        format!("{} ({})", power(edge.weight), self.between(edge.returns))
    }

    /// Formats "beams 12, 301: 3.46 m"; numbers of returns if there are no beams.
    fn between(&self, returns: [usize; 2]) -> String {
        let revolution = &self.frame.revolution;
        let [a, b] = returns.map(|i| revolution.points_m[i]);
        let beam_of = |i: usize| {
            let beams = &revolution.beams()?.beams;
            let sought = Beam::Return(u32::try_from(i).ok()?);
            beams.iter().position(|beam| *beam == sought)
        };
        let (what, [i, j]) = match returns.map(beam_of) {
            [Some(i), Some(j)] => ("beams", [i, j]),
            _ => ("returns", returns),
        };
        format!("{what} {}, {}: {:.2} m", i.min(j), i.max(j), (a - b).norm())
    }
}

/// What a wall is called: "wall 3 (vermilion)"; "wall 3" where it is not drawn.
pub fn wall(id: u32, color: &str) -> String {
    numbered("wall", id, color)
}

/// The inequality that gives k: "λ3 7.4e-9 < τ 1.0e-7 ≤ λ4 2.5e-5".
pub fn inequality(spectrum: &Spectrum) -> String {
    let (k, values) = (spectrum.k, &spectrum.eigenvalues);
    let below = k.checked_sub(1).and_then(|last| Some(format!("λ{k} {} < ", power(*values.get(last)?))));
    let above = values.get(k).map(|next| format!(" ≤ λ{} {}", k + 1, power(*next)));
    let (below, above) = (below.unwrap_or_default(), above.unwrap_or_default());
    format!("{below}τ {}{above}", power(spectrum.tolerance))
}

/// For which widths of the vehicle the count stays the same: "3 walls by these gaps for vehicles 0.20 to 3.40 m
/// wide."
pub fn widths(count: usize, [least_m, most_m]: [f64; 2]) -> String {
    let walls = counted(count as u64, "wall");
    if most_m >= ANY_WIDTH_M {
        format!("{walls} by these gaps for vehicles at least {least_m:.2} m wide.")
    } else {
        format!("{walls} by these gaps for vehicles {least_m:.2} to {most_m:.2} m wide.")
    }
}

/// Formats a value as 1.2e-8, or 0.31 if it is near 1.
pub(crate) fn power(value: f64) -> String {
    if value == 0.0 || (0.01..10.0).contains(&value.abs()) { format!("{value:.2}") } else { format!("{value:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widths_are_told_to_the_centimetre() {
        assert_eq!(widths(3, [0.2, 3.4]), "3 walls by these gaps for vehicles 0.20 to 3.40 m wide.");
        assert_eq!(widths(1, [0.1, 100.0]), "1 wall by these gaps for vehicles at least 0.10 m wide.");
    }

    #[test]
    fn the_inequality_names_the_eigenvalues_on_both_sides() {
        let inequality = |eigenvalues: &[f64], k| {
            inequality(&Spectrum { eigenvalues: eigenvalues.to_vec(), tolerance: 1e-7, k, ..Spectrum::default() })
        };
        assert_eq!(inequality(&[1e-16, 2e-8, 0.01], 2), "λ2 2.0e-8 < τ 1.0e-7 ≤ λ3 0.01");
        assert_eq!(inequality(&[1e-16], 1), "λ1 1.0e-16 < τ 1.0e-7");
        assert_eq!(inequality(&[], 0), "τ 1.0e-7");
        assert_eq!(inequality(&[], 3), "τ 1.0e-7", "a k that the eigenvalues do not reach breaks nothing");
    }
}
