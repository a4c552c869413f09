//! The prompt on a terminal: lines are edited, completed by Tab and remembered for the session.

use anyhow::Context as _;
use crosscut_debugger::COMMANDS;
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::MemHistory;
use rustyline::validate::Validator;
use rustyline::{CompletionType, Config, Context, Editor, Helper};

use super::{Debugger, is_end, words};
use crate::output::{say, show};

/// Does one line after the other up to `quit` or Ctrl-D. Ctrl-C drops the line.
pub(super) fn answer_all(debugger: &mut Debugger) -> anyhow::Result<()> {
    let config = Config::builder().completion_type(CompletionType::List).build(); // as shells do
    let mut editor = Editor::with_history(config, MemHistory::new()).context("the terminal cannot be read")?;
    show(format_args!("{}\n{}\n", debugger.session.greeting(), debugger.session.here()))?;
    loop {
        editor.set_helper(Some(Completion::of(debugger)));
        let line = match editor.readline(&format!("{}> ", debugger.session.frame().revolution.seq)) {
            Ok(line) => line,
            Err(ReadlineError::Interrupted) => continue,
            Err(ReadlineError::Eof) => return Ok(()),
            Err(error) => return Err(error).context("the terminal cannot be read"),
        };
        let words = words(&line);
        if words.is_empty() {
            continue;
        }
        editor.add_history_entry(&line).ok(); // without it, it cannot be repeated by a key
        if is_end(&words) {
            return Ok(());
        }
        match debugger.command(&words) {
            Ok(reply) => show(format_args!("{reply}\n"))?,
            Err(error) => say(format_args!("error: {error}")),
        }
    }
}

/// Words that can be completed: commands, then what they take.
struct Completion {
    settings: Vec<String>,
}

impl Completion {
    fn of(debugger: &Debugger) -> Self {
        Self { settings: debugger.session.config().settings().map(|(key, _)| key).collect() }
    }

    /// The words that a command takes, where they can be listed.
    fn taken_by(&self, command: &str) -> Vec<String> {
        let listed = |list: &[&str]| list.iter().map(|&word| word.to_owned()).collect();
        match command {
            "set" => self.settings.iter().map(|key| format!("{key}=")).collect(),
            "unset" => self.settings.clone(),
            "swap" => listed(&["affinity=", "spectral=", "kmeans="]),
            "next" | "break" => listed(&["changed", "wrong", "unsure", "differs", "fails", "note", "junction"]),
            "why" => listed(&["gap"]),
            "show" => listed(&["scan", "W", "L", "spectrum", "U", "walls", "openings", "here", "pose"]),
            "get" => listed(&["W", "L", "D", "eigenvalues", "U", "labels", "points"]),
            "inject" => listed(&["W", "U", "labels", "off"]),
            _ => Vec::new(),
        }
    }
}

impl Completer for Completion {
    type Candidate = String;

    fn complete(&self, line: &str, at: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<String>)> {
        let before = &line[..at];
        let start = before.rfind(' ').map_or(0, |space| space + 1);
        let begun = &before[start..];
        let known = match before[..start].split_whitespace().collect::<Vec<_>>()[..] {
            [] => COMMANDS.iter().map(|command| command.name.to_owned()).collect(),
            [command] => self.taken_by(command),
            _ => Vec::new(),
        };
        Ok((start, known.into_iter().filter(|word| word.starts_with(begun)).collect()))
    }
}

impl Helper for Completion {}
impl Highlighter for Completion {}
impl Validator for Completion {}
impl Hinter for Completion {
    type Hint = String;
}
