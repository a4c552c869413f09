//! The table of rules and vetoes, and the decision at a gap.

use crosscut_stage::Measured;

use super::gap::Gap;
use super::{dark, mouth, rules};

/// A way to find room at a gap.
pub(super) struct Rule {
    /// What `affinity.without` calls it.
    name: &'static str,
    /// The reason in a few words.
    pub(super) words: &'static str,
    /// When it is asked.
    pub(super) group: RuleGroup,
    /// The room that there is, and that an opening needs; `None` where the rule does not apply.
    pub(super) room: fn(&Gap<'_>) -> Option<Measured>,
}

/// When a rule is asked, and what its room is limited by.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RuleGroup {
    /// The room is at most the clear width, divided by the width of the vehicle.
    Clear,
    /// The clear width does not matter: no corner can be missing where nothing is seen.
    Dark,
    /// Asked if no other rule finds enough room.
    Last,
}

/// What makes a gap no opening, whatever the rules find.
pub(super) struct Veto {
    /// What `affinity.without` calls it.
    name: &'static str,
    /// The reason in a few words.
    words: &'static str,
    phase: VetoPhase,
    /// What it rests on where it holds.
    holds: fn(&Gap<'_>) -> Option<Measured>,
}

/// When a veto is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum VetoPhase {
    /// Before all rules.
    BeforeRules,
    /// Before the rules of [`RuleGroup::Clear`], for which alone it holds.
    OfClearRules,
    /// After the rules, if they find an opening, because it takes time.
    OfOpenings,
}

/// The words of the rule that asks for a width.
pub(super) const WIDTH: &str = "width for the turn";

/// The words of the rule for doors in which nothing is seen.
pub(super) const DOOR: &str = "nothing is seen in a door";

/// The rules. Of one group, the rule that finds the most room decides; of equal ones, the first.
pub(super) const RULES: [Rule; 10] = [
    Rule { name: "width", words: WIDTH, group: RuleGroup::Clear, room: rules::room_in_width },
    Rule { name: "inside", words: "depth behind the nearer wall", group: RuleGroup::Clear, room: rules::room_inside },
    Rule { name: "face", words: "the face of a corner", group: RuleGroup::Clear, room: rules::room_before_face },
    Rule {
        name: "in_front",
        words: "a wall in front",
        group: RuleGroup::Clear,
        room: rules::room_behind_wall_in_front,
    },
    Rule {
        name: "plain_sight",
        words: "width in plain sight",
        group: RuleGroup::Clear,
        room: rules::room_in_plain_sight,
    },
    Rule {
        name: "mouth",
        words: "depth behind a mouth or a door",
        group: RuleGroup::Clear,
        room: mouth::room_behind_mouth,
    },
    Rule { name: "doors", words: DOOR, group: RuleGroup::Dark, room: dark::room_in_door },
    Rule { name: "blank", words: "nothing is seen", group: RuleGroup::Dark, room: dark::room_in_blank },
    Rule {
        name: "dark_end",
        words: "nothing is seen at the end of the range",
        group: RuleGroup::Dark,
        room: dark::room_at_dark_end,
    },
    Rule {
        name: "side_passage",
        words: "the face of a side passage",
        group: RuleGroup::Last,
        room: rules::room_into_side_passage,
    },
];

/// The vetoes. The first that holds decides.
const VETOES: [Veto; 3] = [
    Veto {
        name: "line",
        words: "the line of the nearer wall goes on",
        phase: VetoPhase::BeforeRules,
        holds: |gap| gap.in_line(),
    },
    Veto { name: CORNER, words: "an inner corner", phase: VetoPhase::OfClearRules, holds: |gap| gap.in_corner() },
    Veto { name: "slit", words: "a slit", phase: VetoPhase::OfOpenings, holds: |gap| gap.in_slit() },
];

/// The veto of inner corners, which a side passage is not either.
const CORNER: &str = "corner";

/// The veto of openings that are too doubtful, which has their odds as its room (`odds.rs`).
const ODDS: &str = "odds";

/// The names of all rules and vetoes.
pub(super) const NAMES: [&str; RULES.len() + VETOES.len() + 1] = {
    let mut names = [ODDS; RULES.len() + VETOES.len() + 1];
    let mut at = 0;
    while at < RULES.len() + VETOES.len() {
        names[at] = if at < RULES.len() { RULES[at].name } else { VETOES[at - RULES.len()].name };
        at += 1;
    }
    names
};

/// The rules and vetoes that the configuration disables.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DisabledRules {
    /// For each of [`NAMES`].
    left_out: [bool; NAMES.len()],
    /// Whether inner corners are left out.
    pub(super) corners: bool,
    /// Whether the veto by the odds is left out.
    pub(super) odds: bool,
}

impl DisabledRules {
    /// Those of these names.
    pub(super) fn new(names: &[String]) -> Self {
        let has = |name: &str| names.iter().any(|other| other == name);
        Self { left_out: NAMES.map(has), corners: has(CORNER), odds: has(ODDS) }
    }

    /// The enabled rules of a group.
    pub(super) fn rules(self, group: RuleGroup) -> impl Iterator<Item = &'static Rule> {
        const { &RULES }
            .iter()
            .zip(self.left_out)
            .filter_map(move |(rule, out)| (!out && rule.group == group).then_some(rule))
    }

    /// The decision by the first enabled veto of a phase that holds.
    pub(super) fn veto(self, phase: VetoPhase, gap: &Gap<'_>) -> Option<Decision> {
        let left = VETOES.iter().zip(&self.left_out[RULES.len()..]);
        let mut asked = left.filter(|(veto, out)| !**out && veto.phase == phase);
        asked.find_map(|(veto, _)| (veto.holds)(gap).map(|measured| Decision::no_room(veto.words, Some(measured))))
    }
}

/// How much room there is at a gap, by the rule that finds the most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    /// The room that there is, divided by the room that an opening needs; 0 if the gap hides nothing.
    pub(super) room_ratio: f64,
    /// What decides, in a few words: why it is an opening, or why it is none.
    pub(super) reason: &'static str,
    /// What was measured.
    pub(super) measured: Option<Measured>,
    /// The room by the rules, whatever the odds make of it: one of the measurements that the odds rest on.
    pub(super) ratio_by_rules: f64,
}

impl Decision {
    /// No room, for this reason.
    pub(super) fn no_room(reason: &'static str, measured: Option<Measured>) -> Self {
        Self { room_ratio: 0.0, reason, measured, ratio_by_rules: 0.0 }
    }

    /// As much room as this at most.
    pub(super) fn at_most(self, room: Measured) -> Self {
        if room.ratio() < self.room_ratio {
            Self { room_ratio: room.ratio(), measured: Some(room), ratio_by_rules: room.ratio(), ..self }
        } else {
            self
        }
    }

    pub(super) fn is_opening(self) -> bool {
        self.room_ratio >= 1.0
    }

    /// The decision of the rule that finds the most room; this one if none finds more.
    pub(super) fn or_by<'r>(self, rules: impl Iterator<Item = &'r Rule>, gap: &Gap<'_>) -> Self {
        rules.fold(self, |most, rule| {
            let Some(room) = (rule.room)(gap).filter(|room| room.ratio() > most.room_ratio) else { return most };
            let room_ratio = room.ratio();
            Self { room_ratio, reason: rule.words, measured: Some(room), ratio_by_rules: room_ratio }
        })
    }
}
