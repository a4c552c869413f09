//! How to look at what a verdict counts.

use std::path::{Path, PathBuf};

use crosscut_evaluate::experiment::{FamilyOutcome, Outcome};

/// The commands that show why an answer is wrong: one that a configuration breaks, or else one that it mends, as the first gives
/// it. `options` are those of each configuration, `flights` the files of the families.
pub(crate) fn hint(outcomes: &[Outcome], flights: &[PathBuf], options: &[String]) -> Option<String> {
    let first = |of: fn(&FamilyOutcome) -> &[u64]| {
        outcomes.iter().enumerate().find_map(|(place, outcome)| {
            outcome.families.iter().find_map(|family| Some((place + 1, &family.family, *of(family).first()?)))
        })
    };
    let broken = first(|family| &family.broken);
    let mended = || first(|family| &family.mended).map(|(_, family, seq)| (0, family, seq));
    let (wrong, family, seq) = broken.or_else(mended)?;
    let is_of_family = |path: &&PathBuf| {
        path.file_stem().is_some_and(|stem| stem.to_string_lossy() == family.as_str())
            || path.display().to_string() == *family
    };
    let flight = match flights {
        [only] => only,
        several => several.iter().find(is_of_family)?,
    };
    let space = if options[wrong].is_empty() { "" } else { " " };
    Some(format!(
        "to see why: crosscut debug {}{space}{}, then seek {seq} and why",
        quoted_path(flight),
        options[wrong]
    ))
}

/// A word as a shell takes it.
pub(crate) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./=,:+-@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn quoted_path(path: &Path) -> String {
    quoted(&path.display().to_string())
}

#[cfg(test)]
mod tests {
    use crosscut_evaluate::experiment::Experiment;

    use super::*;

    #[test]
    fn the_wrong_answer_is_named_with_its_configuration_and_file() {
        let mut experiment = Experiment::new(["paper", "mine"].map(str::to_owned).to_vec());
        for (family, seq, right) in [("a", 0, [true, true]), ("b c", 7, [true, false])] {
            (0..2).for_each(|place| experiment.add(family, place, seq, right[place]));
        }
        let options = ["--preset paper", "--config mine.toml"].map(str::to_owned);
        let flights = ["x/a.mcap", "x/b c.mcap"].map(PathBuf::from);
        let said = hint(&experiment.outcomes(), &flights, &options).expect("one is broken");
        assert_eq!(said, "to see why: crosscut debug 'x/b c.mcap' --config mine.toml, then seek 7 and why");
        experiment.add("b c", 0, 7, false);
        assert_eq!(hint(&experiment.outcomes(), &flights, &options), None, "both are wrong");
        experiment.add("a", 0, 0, false);
        let said = hint(&experiment.outcomes(), &flights, &options).expect("one is mended");
        assert_eq!(said, "to see why: crosscut debug x/a.mcap --preset paper, then seek 0 and why");
    }
}
