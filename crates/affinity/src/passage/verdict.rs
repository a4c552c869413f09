//! The table of rules and vetoes, and the decision at a gap by those of them that the configuration leaves in.

use crosscut_stage::Measured;

use super::decision::Decision;
use super::gap::{Gap, STRAIGHT_RAD};
use super::odds::{self, Measures};
use super::{dark, mouth, rules};

/// A rule, which finds room for an opening, or a veto, which closes a gap whatever the rules find.
struct Rule {
    /// Its name in `affinity.without`.
    name: &'static str,
    /// The reason in a few words.
    words: &'static str,
    role: Role,
    /// The room that a rule finds and what an opening needs, or what a veto rests on; `None` where it does not apply.
    measure: fn(&Gap<'_>) -> Option<Measured>,
}

/// When an entry of the table is asked, and what it does.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A veto before all rules.
    EarlyVeto,
    /// A rule whose room is at most the clear width, divided by the width of the vehicle.
    Clear,
    /// A rule for which the clear width does not matter: no corner can be missing where nothing is seen.
    Dark,
    /// A veto of openings alone, because it takes time.
    LateVeto,
}

/// The words of the rule that asks for a width.
const WIDTH: &str = "width for the turn";

/// The words of the rule for doors in which nothing is seen.
const DOOR: &str = "nothing is seen in a door";

/// The table. Of the rules of one role, the one that finds the most room decides; of equal ones, the first. Of vetoes, the
/// first that holds decides.
const TABLE: [Rule; 11] = [
    Rule { name: "width", words: WIDTH, role: Role::Clear, measure: rules::room_in_width },
    Rule { name: "inside", words: "depth behind the nearer wall", role: Role::Clear, measure: rules::room_inside },
    Rule { name: "face", words: "the face of a corner", role: Role::Clear, measure: rules::room_before_face },
    Rule { name: "in_front", words: "a wall in front", role: Role::Clear, measure: rules::room_behind_wall_in_front },
    Rule { name: "plain_sight", words: "width in plain sight", role: Role::Clear, measure: rules::room_in_plain_sight },
    Rule {
        name: "mouth",
        words: "depth behind a mouth or a door",
        role: Role::Clear,
        measure: mouth::room_behind_mouth,
    },
    Rule { name: "doors", words: DOOR, role: Role::Dark, measure: dark::room_in_door },
    Rule { name: "blank", words: "nothing is seen", role: Role::Dark, measure: dark::room_in_blank },
    Rule {
        name: "dark_end",
        words: "nothing is seen at the end of the range",
        role: Role::Dark,
        measure: dark::room_at_dark_end,
    },
    Rule {
        name: "line",
        words: "the line of the nearer wall goes on",
        role: Role::EarlyVeto,
        measure: |gap| gap.in_line(),
    },
    Rule { name: "slit", words: "a slit", role: Role::LateVeto, measure: |gap| gap.in_slit() },
];

/// The veto of openings that are too doubtful, which has their odds as its room.
const ODDS: &str = "odds";

/// An opening at which something is seen has at least these odds: 3 of 10 gaps like it are openings.
const LEAST_ODDS: f64 = 3.0 / 7.0;
/// A door in which nothing is seen has at least these odds: 1 of 10 gaps like it is an opening. A patch of lost beams may be as
/// wide as a door.
const LEAST_DOOR_ODDS: f64 = 1.0 / 9.0;
/// The reason where the odds leave no opening.
const UNLIKELY: &str = "a wall that closes it may be hidden";

/// The names of all rules and vetoes.
pub(super) const NAMES: [&str; TABLE.len() + 1] = {
    let mut names = [ODDS; TABLE.len() + 1];
    let mut at = 0;
    while at < TABLE.len() {
        names[at] = TABLE[at].name;
        at += 1;
    }
    names
};

/// The rules and vetoes without those that the configuration leaves out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    /// For each of [`NAMES`].
    left_out: [bool; NAMES.len()],
}

impl Rules {
    /// All but those of these names.
    pub(super) fn without(names: &[String]) -> Self {
        Self { left_out: NAMES.map(|name| names.iter().any(|other| other == name)) }
    }

    /// How much room there is at a gap, by the table and by the odds. No opening if the odds that all measurements together
    /// give it are below [`LEAST_ODDS`], or below [`LEAST_DOOR_ODDS`] at a door in which nothing is seen. The odds are then
    /// the room, so the gap keeps its doubt. Elsewhere in the dark the table decides alone: no measurement shows how the
    /// hidden wall runs.
    pub(super) fn decide(&self, gap: &Gap<'_>) -> Decision {
        let decision = self.decide_by_table(gap);
        let is_door = decision.reason == DOOR;
        let [.., without_odds] = self.left_out;
        if (gap.is_dark && !is_door) || !decision.is_opening() || without_odds {
            return decision;
        }
        let least = if is_door { LEAST_DOOR_ODDS } else { LEAST_ODDS };
        let odds = odds::odds(&self.measures(gap, decision));
        let percent = |odds: f64| 100.0 * odds / (1.0 + odds);
        let measured = || Measured {
            what: "the share of openings among gaps that measure like this is",
            value: percent(odds),
            against: "an opening has at least",
            limit: percent(least),
            unit: "%",
        };
        if odds < least {
            Decision { room_ratio: odds, reason: UNLIKELY, measured: Some(measured()), ..decision }
        } else {
            decision
        }
    }

    /// Measures a gap, at which this is decided, for its odds. Of two equally near ends neither is the nearer one, and
    /// the mean of both views counts.
    pub(super) fn measures(&self, gap: &Gap<'_>, decision: Decision) -> Measures {
        let one = gap.measures(decision.ratio_by_rules);
        let Some(other) = gap.by_other_end() else { return one };
        let other = other.measures(self.decide_by_table(&other).ratio_by_rules);
        std::array::from_fn(|at| f64::midpoint(one[at], other[at]))
    }

    fn decide_by_table(&self, gap: &Gap<'_>) -> Decision {
        if let Some(none) = self.veto(Role::EarlyVeto, gap) {
            return none;
        }
        let mut decision = self.most_room(Role::Clear, without_room(gap), gap);
        let clear = gap.clear_width();
        if clear.ratio() < decision.room_ratio {
            decision = Decision::room(decision.reason, clear);
        }
        let decision = self.most_room(Role::Dark, decision, gap);
        let veto = if decision.is_opening() { self.veto(Role::LateVeto, gap) } else { None };
        veto.unwrap_or(decision)
    }

    fn of_role(&self, role: Role) -> impl Iterator<Item = &'static Rule> {
        let all = const { &TABLE }.iter().zip(self.left_out);
        all.filter_map(move |(rule, out)| (!out && rule.role == role).then_some(rule))
    }

    /// The decision by the first veto of a role that holds.
    fn veto(&self, role: Role, gap: &Gap<'_>) -> Option<Decision> {
        let holds = |veto: &Rule| (veto.measure)(gap).map(|measured| Decision::no_room(veto.words, Some(measured)));
        self.of_role(role).find_map(holds)
    }

    /// The decision of the rule of a role that finds the most room; `without` if none finds more.
    fn most_room(&self, role: Role, without: Decision, gap: &Gap<'_>) -> Decision {
        self.of_role(role).fold(without, |most, rule| match (rule.measure)(gap) {
            Some(room) if room.ratio() > most.room_ratio => Decision::room(rule.words, room),
            _ => most,
        })
    }
}

/// What is decided if no rule finds room.
fn without_room(gap: &Gap<'_>) -> Decision {
    if gap.opening_share().is_some() {
        return Decision::no_room(WIDTH, None);
    }
    let turn_rad = gap.turns.whole_rad;
    let turn = Measured {
        what: if turn_rad < 0.0 { "the wall turns back by" } else { "the wall turns away by" },
        value: turn_rad.abs().to_degrees(),
        against: "where it ends it turns away by at least",
        limit: STRAIGHT_RAD.to_degrees(),
        unit: "°",
    };
    Decision::no_room("the wall turns too little", Some(turn))
}
