//! `crosscut debug`: a flight that answers back. The session is `crosscut-debugger`; here are its front ends: a prompt on a
//! terminal, and lines of a file or pipe.

mod editor;
mod flight;
mod outside;
mod plain;
#[cfg(feature = "rerun")]
mod viewing;

use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};

use clap::Args;
use crosscut_debugger::{Refused, Session};
use crosscut_detector::{Layer, Registry};

use self::outside::Outside;
#[cfg(feature = "rerun")]
use self::viewing::Viewing;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
#[cfg(not(feature = "rerun"))]
use crate::gate::Viewing;
use crate::host::Kinds;
use crate::input::{ConfigArgs, InputArgs, config, files_read, recorded};
use crate::interrupt::CommandInterrupt;
use crate::output::say;
use crate::values::number;

#[derive(Debug, Args)]
pub(crate) struct DebugArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    config: ConfigArgs,
    /// Begin at this revolution, as `seek N` does.
    #[arg(long, value_name = "REVOLUTION", value_parser = number::<u64>, allow_negative_numbers = true)]
    at: Option<u64>,
    /// Show the page of stages in the Rerun viewer: of the present revolution, after every command; beside it what is held.
    #[arg(long)]
    view: bool,
}

/// A session with what it may write.
struct Debugger<'a> {
    session: Session,
    kinds: Option<&'a dyn Kinds>,
    outside: Outside,
    interrupt: CommandInterrupt,
    /// `None` without --view, or after the viewer was closed.
    viewing: Option<Viewing>,
}

impl Debugger<'_> {
    /// Does what the words say.
    fn command(&mut self, words: &[String]) -> Result<String, Refused> {
        let before = self.session.version();
        let Self { session, outside, interrupt, kinds, .. } = self;
        let mut done = interrupt.while_working(|| match outside.command(session, words) {
            Some(done) => done,
            None => {
                let words = kinds_found(words, *kinds, session)?;
                session.command(&words)
            }
        });
        if let Ok(reply) = &mut done
            && self.session.version() != before
            && self.session.frame().failure.is_some()
            && let Some(failed) = self.kinds.and_then(Kinds::failed)
        {
            *reply += &format!("\n{}", failed.trim_end());
        }
        self.follow();
        done
    }

    /// Shows in the viewer what the session stands at. Without the viewer it goes on.
    fn follow(&mut self) {
        if let Some(viewing) = &mut self.viewing
            && let Err(error) = viewing.follow(&self.session)
        {
            say(format_args!("note: {error}; the session goes on without it"));
            self.viewing = None;
        }
    }
}

/// Reads the flight, then does one command after the other.
pub(crate) fn debug(args: DebugArgs, registry: &Registry, kinds: Option<&dyn Kinds>) -> anyhow::Result<Outcome> {
    if args.input.recordings.input.iter().any(|path| path == Path::new("-")) {
        return Err(UsageError("standard input holds the commands; name a file of the flight".to_owned()).into());
    }
    #[cfg(not(feature = "rerun"))]
    if args.view {
        return Err(crate::gate::without_rerun());
    }
    let read = files_read(&args.input, args.config.config.clone())?;
    let layers = layers(&args.input.recordings.input, &args.config)?;
    let has_view = args.view;
    let preset = match &args.config.preset {
        None if recorded::only(&args.input.recordings.input)?.is_some() => "settings of the recording".to_owned(),
        _ => format!("preset {}", args.config.preset()),
    };
    let name = args.input.name();
    let (reader, lost) = flight::reader(args.input);
    let no_session = |refused| match refused {
        Refused::Failed(why) => anyhow::anyhow!(why),
        refused => UsageError(refused.to_string()).into(),
    };
    let mut session = Session::new(registry.clone(), layers, reader).map_err(no_session)?;
    if let Some(at) = args.at {
        session.command(&["seek".to_owned(), at.to_string()]).map_err(no_session)?;
    }
    let mut diagnostics = Diagnostics::default();
    diagnostics.lost_all(lost.borrow().iter());
    let is_terminal = io::stdin().is_terminal() && io::stdout().is_terminal();
    let interrupt = CommandInterrupt::listen(session.stop(), is_terminal)?;
    let viewing =
        if has_view { Viewing::open(&name, &preset).map_err(|error| diagnostics.lost(error)).ok() } else { None };
    let mut debugger = Debugger { interrupt, session, kinds, outside: Outside { name, read }, viewing };
    debugger.follow();
    let refused = if is_terminal {
        editor::answer_all(&mut debugger)?;
        0
    } else {
        plain::answer_all(&mut debugger, io::stdin().lock())?
    };
    if let Some(Err(error)) = debugger.viewing.map(Viewing::end) {
        say(format_args!("note: {error}"));
    }
    Ok(match (refused, diagnostics.outcome()) {
        (0, outcome) => outcome,
        _ => Outcome::Failed, // a script wants to know
    })
}

/// The words with the names of kinds as the registry has them, once they are found.
fn kinds_found(words: &[String], kinds: Option<&dyn Kinds>, session: &mut Session) -> Result<Vec<String>, Refused> {
    let mut found = words.to_vec();
    let (Some(kinds), Some("swap" | "set")) = (kinds, words.first().map(String::as_str)) else { return Ok(found) };
    for word in &mut found[1..] {
        if let Some((key, kind)) = word.split_once('=')
            && (words[0] == "swap" || key.ends_with(".kind"))
            && let Some(name) = kinds.find(kind, session.registry_mut()).map_err(Refused::Failed)?
        {
            *word = format!("{key}={name}");
        }
    }
    Ok(found)
}

/// The layers of settings. A recording (.rrd) brings its own, unless a preset is named.
pub(crate) fn layers(inputs: &[PathBuf], args: &ConfigArgs) -> anyhow::Result<Vec<Layer>> {
    let mut layers = config::layers(args.preset(), args.config.as_deref(), &[("--set", &args.set)])?;
    if let (Some(recording), None) = (recorded::only(inputs)?, &args.preset) {
        layers.insert(1, recorded::settings(recording)?);
    }
    Ok(layers)
}

/// Splits a line at spaces; what stands between double quotes is one word. Quotes within a word are a part of it, as those of
/// a list.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word) = (Vec::new(), None::<String>);
    // Between quotes, whether these are a part of the word.
    let mut quotes = None;
    for character in line.chars() {
        match character {
            '"' => {
                let is_part = quotes.unwrap_or(word.is_some());
                word.get_or_insert_default().extend(is_part.then_some('"'));
                quotes = if quotes.is_none() { Some(is_part) } else { None };
            }
            space if space.is_whitespace() && quotes.is_none() => words.extend(word.take()),
            other => word.get_or_insert_default().push(other),
        }
    }
    words.extend(word);
    words
}

/// Whether the words end the session.
fn is_end(words: &[String]) -> bool {
    matches!(words, [only] if ["quit", "exit", "q"].contains(&only.as_str()))
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn quotes_keep_spaces_within_a_word() {
        assert_eq!(words("  get W  \"my file.npy\" "), ["get", "W", "my file.npy"]);
        assert_eq!(words("note \"\""), ["note", ""]);
        assert_eq!(
            words("set affinity.without=[\"doors\",\"line\"] x"),
            ["set", "affinity.without=[\"doors\",\"line\"]", "x"]
        );
        assert!(words(" \t").is_empty());
    }
}
