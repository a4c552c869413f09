//! The command line with two examples for each command, and what is made of it: completions, pages for `man`.

use std::io;
use std::path::Path;

use clap::{Command, CommandFactory};

use super::Cli;

/// Two lines for each command, the most wanted first; each line is a command that the parser accepts.
const EXAMPLES: [(&str, [&str; 2]); 17] = [
    ("", ["crosscut run FLIGHT.bag", "crosscut run recordings/tee.mcap --preset paper --save tee.rrd"]),
    (
        "run",
        [
            "crosscut run FLIGHT.bag -o FLIGHT.jsonl --map FLIGHT.svg",
            "crosscut run FLIGHT.bag --set vehicle.width_m=0.8 --save FLIGHT.rrd",
        ],
    ),
    ("view", ["crosscut view FLIGHT.rrd --at 81", "crosscut view A.rrd --beside B.rrd"]),
    ("simulate", ["crosscut simulate loops --seed 7 -o loops.mcap", "crosscut simulate --list"]),
    ("explore", ["crosscut explore loops --seed 7", "crosscut explore --plan PLAN.json --save MISSION.rrd"]),
    (
        "compare",
        [
            "crosscut compare scenes/ --with default --with mine=paper,affinity.sigma_per_m2=3",
            "crosscut compare FLIGHT.bag --grid vehicle.width_m=0.6,0.9,1.2 --csv widths.csv",
        ],
    ),
    ("debug", ["crosscut debug FLIGHT.bag", "crosscut debug FLIGHT.rrd --at 81 --view"]),
    ("info", ["crosscut info FLIGHT.bag", "crosscut info FLIGHT.db3 --json -"]),
    (
        "report",
        ["crosscut report FLIGHT.bag -o FLIGHT.html", "crosscut report FLIGHT.bag --preset paper -o FLIGHT.html"],
    ),
    (
        "convert",
        ["crosscut convert FLIGHT.clf -o FLIGHT.mcap", "crosscut convert FLIGHT.bag --from 10 --to 60 -o PART.mcap"],
    ),
    ("rrd", ["crosscut rrd ls FLIGHT.rrd", "crosscut rrd get FLIGHT.rrd /spectral/eigenvalues -o eigenvalues.csv"]),
    ("rrd ls", ["crosscut rrd ls FLIGHT.rrd", "crosscut rrd ls FLIGHT.rrd --config"]),
    (
        "rrd get",
        [
            "crosscut rrd get FLIGHT.rrd /spectral/eigenvalues -o eigenvalues.csv",
            "crosscut rrd get FLIGHT.rrd /affinity/W --exact --revolution 81 -o W.npy",
        ],
    ),
    ("rrd diff", ["crosscut rrd diff A.rrd B.rrd", "crosscut rrd diff A.rrd B.rrd --tolerance 1e-12"]),
    ("config", ["crosscut config", "crosscut config --preset paper > mine.toml"]),
    (
        "completions",
        [
            "crosscut completions bash > ~/.local/share/bash-completion/completions/crosscut",
            "crosscut completions zsh > ~/.zfunc/_crosscut",
        ],
    ),
    ("man", ["crosscut man ~/.local/share/man/man1", "crosscut man target/man"]),
];

/// Commands that there were, each with what does the same now.
const RETIRED: [(&str, &str); 5] = [
    ("evaluate", "crosscut compare FILES... --with A --with B"),
    ("sweep", "crosscut compare FILES... --grid KEY=V1,V2 --csv FILE.csv"),
    ("replay", "crosscut run FLIGHT.rrd --set KEY=VALUE -o FILE.jsonl, or crosscut debug FLIGHT.rrd"),
    ("runs", "crosscut compare FILES... --with A --with B --json FILE.json"),
    ("map", "crosscut run FLIGHT --map FILE.svg, or .json, .geojson, .g2o"),
];

/// What to type in place of a command that there was.
pub(crate) fn instead_of(command: &str) -> Option<String> {
    let (_, instead) = RETIRED.iter().find(|(retired, _)| *retired == command)?;
    Some(format!("`{command}` is no longer a command; type: {instead}"))
}

/// What a page of help looks like: purpose, examples, usage, options.
const TEMPLATE: &str = "{about-with-newline}\n{before-help}{usage-heading} {usage}\n\n{all-args}{after-help}";

/// The command line, with its examples.
pub(crate) fn command() -> Command {
    with_examples(Cli::command(), "")
}

/// `path`: the names of the commands that lead to this one, without the program's.
fn with_examples(command: Command, path: &str) -> Command {
    let subcommands: Vec<String> = command.get_subcommands().map(|command| command.get_name().to_owned()).collect();
    let command = subcommands.into_iter().fold(command, |command, name| {
        let path = format!("{path} {name}");
        command.mut_subcommand(name, |subcommand| with_examples(subcommand, path.trim()))
    });
    match EXAMPLES.iter().find(|(of, _)| *of == path) {
        Some((_, lines)) => {
            command.help_template(TEMPLATE).before_help(format!("Examples:\n  {}\n  {}", lines[0], lines[1]))
        }
        None => command,
    }
}

/// Writes a page for `man` of the program and of each command into `folder`.
///
/// # Errors
/// Those of writing.
pub(crate) fn write_man_pages(folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    clap_mangen::generate_to(command(), folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_opens_with_examples_that_it_accepts() {
        fn check(command: &Command, path: &str) {
            let of_it = EXAMPLES.iter().find(|(of, _)| *of == path);
            let (_, lines) = of_it.unwrap_or_else(|| panic!("`crosscut {path}` has no examples"));
            for line in lines {
                let line = line.split(" > ").next().unwrap_or_default();
                let parsed = super::command().try_get_matches_from(line.split(' '));
                assert!(parsed.is_ok(), "{line}: {}", parsed.expect_err("refused"));
                assert!(line.starts_with(format!("crosscut {path}").trim()), "{line} is no example of {path}");
            }
            for subcommand in command.get_subcommands().filter(|command| !command.is_hide_set()) {
                check(subcommand, format!("{path} {}", subcommand.get_name()).trim());
            }
        }
        check(&super::command(), "");
    }
}
