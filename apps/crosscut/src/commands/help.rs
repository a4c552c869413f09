//! Two examples for each command, and what to type in place of what there was.

use std::ffi::OsString;
use std::path::Path;

use clap::Command;

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
    ("explore", ["crosscut explore loops --seed 7 --save MISSION.rrd", "crosscut explore all --seed 201..210"]),
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
    ("rrd ls", ["crosscut rrd ls FLIGHT.rrd", "crosscut rrd ls FLIGHT.rrd /scan/returns"]),
    (
        "rrd get",
        [
            "crosscut rrd get FLIGHT.rrd /spectral/eigenvalues -o eigenvalues.csv",
            "crosscut rrd get FLIGHT.rrd /affinity/W --exact --at 81 -o W.npy",
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

/// Commands and options that there were, with what does the same now: the command; its option, empty for the command itself;
/// what to type.
const RETIRED: [(&str, &str, &str); 24] = [
    ("evaluate", "", "crosscut compare FILES... --with A --with B"),
    ("sweep", "", "crosscut compare FILES... --grid KEY=V1,V2 --csv FILE.csv"),
    ("replay", "", "crosscut run FLIGHT.rrd --set KEY=VALUE -o FILE.jsonl, or crosscut debug FLIGHT.rrd"),
    ("runs", "", "crosscut compare FILES... --with A --with B --json FILE.json"),
    ("map", "", "crosscut run FLIGHT --map FILE.svg, or .json, .geojson, .g2o"),
    ("run", "--results", "-o FILE.jsonl"),
    ("run", "--odometry", "--set ingest.odometry=TOPIC"),
    ("compare", "--odometry", "--set ingest.odometry=TOPIC"),
    ("run", "--detail", "--set recording.detail=light, default or full"),
    ("explore", "--detail", "--set recording.detail=light, default or full"),
    ("run", "--domain", "'zenoh://HOST/TOPIC?domain=N'"),
    ("compare", "--domain", "'zenoh://HOST/TOPIC?domain=N'"),
    ("run", "--zenoh-config", "'zenoh://HOST/TOPIC?config=FILE.json5'"),
    ("compare", "--zenoh-config", "'zenoh://HOST/TOPIC?config=FILE.json5'"),
    ("run", "--layout", "crosscut view FLIGHT.rrd --layout PAGE"),
    (
        "run",
        "--layer",
        "two runs, one with --save A.rrd, one with --save B.rrd; then crosscut view A.rrd --beside B.rrd",
    ),
    ("view", "--with", "--beside FLIGHT.mcap"),
    ("debug", "--json", "lines of commands to standard input: crosscut debug FLIGHT < COMMANDS"),
    ("simulate", "--no-odometry", "--drift none"),
    ("explore", "--count", "--seed FIRST..LAST"),
    ("explore", "--all", "crosscut explore all"),
    ("rrd ls", "--components", "crosscut rrd ls FLIGHT.rrd ENTITY"),
    ("rrd get", "--revolution", "--at REVOLUTION"),
    ("rrd get", "--component", "ENTITY:COMPONENT, such as /log:TextLog:text"),
];

/// What to type in place of the commands and options that there were, and of a file alone, for those in `args`, of which the
/// first is the program.
pub(crate) fn instead_of(args: &[OsString]) -> Vec<String> {
    let words = args.iter().skip(1).filter_map(|arg| arg.to_str());
    let words: Vec<&str> = words.skip_while(|word| *word == "help").collect();
    let has = |option: &str| words.iter().any(|word| word.split('=').next() == Some(option));
    let is_in = |(command, option, _): &&(&str, &str, &str)| {
        words.iter().zip(command.split_whitespace()).all(|(word, of)| *word == of)
            && words.len() >= command.split_whitespace().count()
            && (option.is_empty() || has(option))
    };
    let say = |(command, option, instead): &(&str, &str, &str)| match *option {
        "" => format!("`{command}` is no longer a command; type: {instead}"),
        _ => format!("`{option}` is no longer an option; type: {instead}"),
    };
    let is_file = |word: &&&str| Path::new(word).exists() && super::command().find_subcommand(word).is_none();
    let file = words.first().filter(is_file).map(|file| format!("`{file}` is a file; type: crosscut run {file}"));
    RETIRED.iter().filter(is_in).map(say).chain(file).collect()
}

/// What a page of help looks like: purpose, examples, usage, options.
const TEMPLATE: &str = "{about-with-newline}\n{before-help}{usage-heading} {usage}\n\n{all-args}{after-help}";

/// The examples of a command, by the names that lead to it, without the program's.
pub(crate) fn examples(path: &str) -> Option<&'static [&'static str; 2]> {
    EXAMPLES.iter().find(|(of, _)| *of == path).map(|(_, lines)| lines)
}

/// The command with its examples, and those below it. `path`: the names of the commands that lead to this one, without the
/// program's.
pub(crate) fn with_examples(command: Command, path: &str) -> Command {
    let subcommands: Vec<String> = command.get_subcommands().map(|command| command.get_name().to_owned()).collect();
    let command = subcommands.into_iter().fold(command, |command, name| {
        let path = format!("{path} {name}");
        command.mut_subcommand(name, |subcommand| with_examples(subcommand, path.trim()))
    });
    match examples(path) {
        Some(lines) => {
            command.help_template(TEMPLATE).before_help(format!("Examples:\n  {}\n  {}", lines[0], lines[1]))
        }
        None => command,
    }
}
