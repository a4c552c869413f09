//! Several configurations on the same scenes: a verdict on each against the first.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::tables::Table;
use crate::verdict::{SwapVerdict, holm, listed, short, thousands};

/// At most this many spans of revolutions are named in a line.
const SPANS: usize = 8;

/// Of more configurations, those that mend the most beyond what they break have a sentence.
const SENTENCES: usize = 8;

/// Which answers of several configurations are right, by family of scenes.
#[derive(Clone, Debug, Default)]
pub struct Experiment {
    /// Names of the configurations.
    names: Vec<String>,
    /// By family in the order in which they came: for each configuration, whether a revolution's answer is right.
    families: Vec<(String, Vec<BTreeMap<u64, bool>>)>,
}

/// What a configuration makes better and worse than the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Its name.
    pub configuration: String,
    /// The name of the first.
    pub against: String,
    /// Over all families.
    #[serde(flatten)]
    pub verdict: SwapVerdict,
    /// The p of the exact test of McNemar.
    pub p: f64,
    /// p with Holm's correction for all configurations.
    pub p_holm: f64,
    /// Family by family.
    pub families: Vec<FamilyOutcome>,
}

/// What a configuration makes better and worse in a family.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FamilyOutcome {
    /// Its name.
    pub family: String,
    /// Of its revolutions.
    #[serde(flatten)]
    pub verdict: SwapVerdict,
    /// The p of the exact test of McNemar.
    pub p: f64,
    /// The revolutions that it mends.
    pub mended: Vec<u64>,
    /// The revolutions that it breaks.
    pub broken: Vec<u64>,
}

impl Experiment {
    /// Of these configurations, without answers.
    pub fn new(names: Vec<String>) -> Self {
        Self { names, families: Vec::new() }
    }

    /// Adds the answer of the configuration of this index for a revolution of a family.
    ///
    /// # Panics
    /// If there is no such configuration.
    pub fn add(&mut self, family: &str, configuration: usize, seq: u64, is_right: bool) {
        let known = self.families.iter().position(|(name, _)| name == family);
        let at = known.unwrap_or_else(|| {
            self.families.push((family.to_owned(), vec![BTreeMap::new(); self.names.len()]));
            self.families.len() - 1
        });
        self.families[at].1[configuration].insert(seq, is_right);
    }

    /// The outcome of each configuration but the first. Revolutions that only one of the two answered are left out.
    pub fn outcomes(&self) -> Vec<Outcome> {
        let mut outcomes: Vec<Outcome> = (1..self.names.len()).map(|place| self.outcome(place)).collect();
        let corrected = holm(&outcomes.iter().map(|outcome| outcome.p).collect::<Vec<_>>());
        outcomes.iter_mut().zip(corrected).for_each(|(outcome, p)| outcome.p_holm = p);
        outcomes
    }

    fn outcome(&self, place: usize) -> Outcome {
        let families: Vec<FamilyOutcome> =
            self.families.iter().map(|(family, right)| FamilyOutcome::of(family, &right[0], &right[place])).collect();
        let mut verdict = SwapVerdict::default();
        families.iter().for_each(|family| verdict.merge(family.verdict));
        let (configuration, against) = (self.names[place].clone(), self.names[0].clone());
        Outcome { configuration, against, verdict, p: verdict.p(), p_holm: verdict.p(), families }
    }
}

impl FamilyOutcome {
    fn of(family: &str, first: &BTreeMap<u64, bool>, second: &BTreeMap<u64, bool>) -> Self {
        let both = || first.iter().filter_map(|(seq, a)| Some((*seq, [*a, *second.get(seq)?])));
        let mut verdict = SwapVerdict::default();
        both().for_each(|(_, right)| verdict.add(right));
        let those = |right: [bool; 2]| both().filter(|(_, of)| *of == right).map(|(seq, _)| seq).collect();
        let (mended, broken) = (those([false, true]), those([true, false]));
        Self { family: family.to_owned(), verdict, p: verdict.p(), mended, broken }
    }
}

/// The sentence on each configuration, the conclusion first, with the revolutions that it mends and breaks; empty if nothing
/// was compared.
pub fn sentences(outcomes: &[Outcome]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut told: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.verdict.of > 0).collect();
    let more = told.len().saturating_sub(SENTENCES);
    if more > 0 {
        told.sort_by_key(|of| of.verdict.breaks.cast_signed() - of.verdict.mends.cast_signed());
        told.truncate(SENTENCES);
    }
    for outcome in told {
        let corrected = (outcomes.len() > 1).then_some(outcome.p_holm);
        lines.push(format!(
            "against {}: {}",
            outcome.against,
            outcome.verdict.sentence(&outcome.configuration, corrected)
        ));
        for (what, of) in [("mended", mended as Listed), ("broken", broken)] {
            let parts = outcome.families.iter().filter(|family| !of(family).is_empty());
            let parts: Vec<String> = parts
                .map(|family| format!("{} {}", family.family, listed(of(family), SPANS)).trim().to_owned())
                .collect();
            lines.extend((!parts.is_empty()).then(|| format!("  {what}: {}", parts.join("; "))));
        }
    }
    lines.extend((more > 0).then(|| format!("{more} more configurations are left out here; these mend the most")));
    lines
}

type Listed = fn(&FamilyOutcome) -> &[u64];

fn mended(family: &FamilyOutcome) -> &[u64] {
    &family.mended
}

fn broken(family: &FamilyOutcome) -> &[u64] {
    &family.broken
}

/// A table of each configuration by family, where there are several.
pub fn tables(outcomes: &[Outcome]) -> Vec<Table> {
    let table = |outcome: &Outcome| {
        let row = |family: &FamilyOutcome| {
            let SwapVerdict { mends, breaks, of } = family.verdict;
            vec![family.family.clone(), thousands(mends), thousands(breaks), thousands(of), short(family.p)]
        };
        Table {
            title: format!("what {} mends and breaks against {}, revolutions", outcome.configuration, outcome.against),
            header: ["family", "mends", "breaks", "of", "p"].map(str::to_owned).to_vec(),
            rows: outcome.families.iter().map(row).collect(),
        }
    };
    outcomes.iter().filter(|outcome| outcome.families.len() > 1).map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_configuration_is_judged_against_the_first_on_what_both_answered() {
        let mut experiment = Experiment::new(["A", "B", "C"].map(str::to_owned).to_vec());
        for seq in 0..10 {
            experiment.add("tee", 0, seq, seq >= 5);
            experiment.add("tee", 1, seq, true);
            experiment.add("tee", 2, seq, seq >= 6);
        }
        experiment.add("bend", 0, 3, false); // that only the first answered
        let outcomes = experiment.outcomes();
        let [b, c] = &outcomes[..] else { panic!("two") };
        assert_eq!(b.verdict, SwapVerdict { mends: 5, breaks: 0, of: 10 });
        assert_eq!((c.verdict, &c.families[0].broken[..]), (SwapVerdict { mends: 0, breaks: 1, of: 10 }, &[5][..]));
        assert_eq!((b.p, b.p_holm, c.p_holm), (0.0625, 0.125, 1.0));
        assert_eq!(
            sentences(&outcomes),
            [
                "against A: B mends 5 and breaks 0 of 10 (exact McNemar p = 0.06, 0.12 with Holm's correction)",
                "  mended: tee 0-4",
                "against A: C mends 0 and breaks 1 of 10 (exact McNemar p = 1, 1 with Holm's correction)",
                "  broken: tee 5",
            ]
        );
        assert_eq!(tables(&outcomes)[0].rows[0], ["tee", "5", "0", "10", "0.06"]);
    }
}
