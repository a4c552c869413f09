//! Words in, answers out.

use crate::{Refused, Session};

/// A command with what it takes and does.
#[derive(Clone, Copy, Debug)]
pub struct Command {
    /// Its first word.
    pub name: &'static str,
    /// The words after it.
    pub takes: &'static str,
    /// What it does.
    pub does: &'static str,
}

macro_rules! commands {
    ($($name:literal $takes:literal $does:literal,)*) => { &[$(Command { name: $name, takes: $takes, does: $does }),*] };
}

/// Every command, in the order of `help`. Those that write more than NumPy's files are for the program around the session.
pub const COMMANDS: &[Command] = commands! {
    "seek" "N | 12.3s" "go to revolution N, or to the first at this many seconds after the first scan",
    "step" "[-]N" "go N revolutions on or back; without N: one on",
    "next" "WHEN" "go to the next revolution that is WHEN: changed, wrong, unsure, differs, fails, note TEXT, junction, walls>3...",
    "break" "WHEN | off" "let run stop at WHEN as well; without WHEN: list; off: stop nowhere",
    "run" "" "go on to where a break holds",
    "show" "[scan|W|L|spectrum|U|walls|openings|here|pose]" "show the answer, or what a stage made",
    "why" "[gap [N]]" "explain the count; the gaps where walls may end; gap N alone",
    "get" "W|L|D|eigenvalues|U|labels|points OUT.npy" "write an array for NumPy",
    "set" "SECTION.KEY=VALUE..." "set a setting, or several; this revolution is answered again at once",
    "unset" "SECTION.KEY | all" "take a setting, or all, back",
    "swap" "affinity|spectral|kmeans=KIND" "choose another kind of a stage",
    "inject" "W|U|labels IN.npy | off" "replace what a stage made of this revolution; the later stages go on from it",
    "settings" "" "list what differs from the settings at the start",
    "again" "" "answer the whole flight again: how many revolutions changed, and which",
    "hold" "" "keep the present settings and answers as A",
    "diff" "" "the first stage and value in which this revolution differs from A",
    "differs" "" "the revolutions whose walls or place differ from A, and which of the two is better",
    "save" "FLIGHT.rrd" "record the whole flight with the present settings",
    "write" "SETTINGS.toml" "write the present settings",
    "report" "" "how many walls the flight has by revolutions, and how many answers are right",
    "help" "" "list the commands",
    "quit" "" "end",
};

impl Session {
    /// Does what the words say, and answers in lines without an end. After a refusal everything is as before.
    ///
    /// # Errors
    /// When there is no such command, it takes other words, or cannot be done.
    pub fn command(&mut self, words: &[String]) -> Result<String, Refused> {
        let Some((name, rest)) = words.split_first() else { return Ok(String::new()) };
        let one = || match rest {
            [only] => Ok(only.as_str()),
            _ => Err(takes(name)),
        };
        let none = || if rest.is_empty() { Ok(()) } else { Err(takes(name)) };
        match name.as_str() {
            "seek" => self.seek(one()?),
            "step" => self.step(rest),
            "next" => self.next(rest),
            "break" => self.set_break(rest),
            "run" => none().and_then(|()| self.run()),
            "show" => self.show(rest),
            "why" => self.why(rest),
            "get" => match rest {
                [what, path] => self.get(what, path),
                _ => Err(takes(name)),
            },
            "set" => self.set(rest),
            "unset" => self.unset(one()?),
            "swap" => self.swap(one()?),
            "inject" => self.inject(rest),
            "settings" => none().map(|()| self.settings()),
            "again" => none().and_then(|()| self.again()),
            "hold" => none().map(|()| self.hold()),
            "diff" => none().and_then(|()| self.diff()),
            "differs" => none().and_then(|()| self.differs()),
            "report" => none().and_then(|()| self.report()),
            "help" => Ok(help()),
            _ => Err(unknown(name)),
        }
    }
}

/// The refusal of a command with other words than it takes.
pub(crate) fn takes(name: &str) -> Refused {
    let command = COMMANDS.iter().find(|command| command.name == name);
    Refused::Usage(command.map_or_else(String::new, |command| {
        format!("{} {}: {}", command.name, command.takes, command.does).replace("  ", " ").replace(" :", ":")
    }))
}

fn unknown(name: &str) -> Refused {
    let names: Vec<_> = COMMANDS.iter().map(|command| command.name).collect();
    Refused::Usage(format!("there is no command {name:?}; {}", crosscut_detector::nearest_and_all(name, &names)))
}

fn help() -> String {
    let width = COMMANDS.iter().map(|command| command.name.len() + 1 + command.takes.len()).max().unwrap_or(0).min(30);
    let line = |command: &Command| {
        let what = format!("{} {}", command.name, command.takes);
        if what.len() > width {
            format!("{what}\n{:width$}  {}", "", command.does)
        } else {
            format!("{what:width$}  {}", command.does)
        }
    };
    let lines: Vec<String> = COMMANDS.iter().map(line).collect();
    lines.join("\n")
}
