//! `crosscut rrd diff`: two recordings compared row by row.

use std::io::Write;

use comfy_table::{Table, presets};
use crosscut_rrd::{Differences, ReadError, Recording, differences};

use super::args::RrdDiffArgs;
use super::{open, say_damages};
use crate::exit::{Outcome, UsageError, is_closed_pipe};

/// Prints the first difference and a table of all. Exit codes as of diff(1): 0 the same, 1 different, 2 trouble; and 3
/// if the readable rows of a damaged recording are the same.
pub(super) fn diff(args: &RrdDiffArgs) -> anyhow::Result<Outcome> {
    let mut ids = args.ids.iter();
    let mut open = |path| match Recording::open(path) {
        Err(ReadError::Several { .. }) => open(path, ids.next().map(String::as_str)),
        opened => opened.map_err(|error| UsageError(error.to_string()).into()),
    };
    let (a, b) = (open(&args.first)?, open(&args.second)?);
    if let Some(id) = ids.next() {
        return Err(UsageError(format!("--recording {id}: no other file holds several recordings")).into());
    }
    let found = differences(&a, &b, args.tolerance).map_err(|error| UsageError(error.to_string()))?;
    let mut text = settings_that_differ(&a, &b);
    text += &found_text(&found);
    std::io::stdout().write_all(text.as_bytes()).map_err(|error| {
        if is_closed_pipe(&error) {
            return anyhow::Error::new(error);
        }
        UsageError(format!("standard output: {error}")).into() // trouble
    })?;
    let damages = [say_damages(&a), say_damages(&b)];
    Ok(match found.first {
        Some(_) => Outcome::Different,
        None if damages.contains(&Outcome::SomethingLost) => Outcome::SomethingLost,
        None => Outcome::Done,
    })
}

fn found_text(found: &Differences) -> String {
    let Some(first) = &found.first else {
        return format!("the same in {} rows\n", found.compared);
    };
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(["step", "entity", "component", "revolutions", "first", "how"]);
    for d in &found.components {
        let (revolutions, first) = (d.revolutions.to_string(), d.revolution.to_string());
        table.add_row([d.step.name(), &d.entity, &d.component, &revolutions, &first, &d.how]);
    }
    format!("different first at revolution {}, in {}\n\n{}\n", first.revolution, first.step, table.trim_fmt())
}

/// Settings are no results, but they explain why results differ.
fn settings_that_differ(a: &Recording, b: &Recording) -> String {
    let (Some(a), Some(b)) = (a.config_toml(), b.config_toml()) else {
        return "the settings of one of them are missing\n".to_owned();
    };
    let [of_a, of_b] = [&a, &b].map(|toml| settings(toml));
    let only = |mark: &str, these: &[String], others: &[String]| -> String {
        these.iter().filter(|line| !others.contains(line)).map(|line| format!("{mark} {line}\n")).collect()
    };
    only("<", &of_a, &of_b) + &only(">", &of_b, &of_a)
}

/// Every `section.key = value` of a configuration, or the lines of a text that is no configuration.
fn settings(toml: &str) -> Vec<String> {
    let Ok(sections) = toml.parse::<toml::Table>() else {
        return toml.lines().map(str::to_owned).collect();
    };
    let of_section = |(section, values): (String, toml::Value)| {
        let values = values.as_table().cloned().unwrap_or_default();
        values.into_iter().map(move |(key, value)| format!("{section}.{key} = {value}"))
    };
    sections.into_iter().flat_map(of_section).collect()
}

#[cfg(test)]
mod tests {
    use super::settings;

    #[test]
    fn settings_have_their_section_and_no_comments() {
        let toml = "[a]\n# words\nkind = \"rbf  #1\"  # preset paper\n\n[b]\nn = 3  # default\n";
        assert_eq!(settings(toml), ["a.kind = \"rbf  #1\"", "b.n = 3"]);
    }
}
