//! `crosscut replay`: a recorded flight again from one stage on, and what that changes.

use std::io::Write as _;
use std::path::Path;

use anyhow::Context;
use crosscut_debugger::{Refused, Session};
use crosscut_detector::Registry;
use crosscut_evaluate::verdict::thousands;

use super::debug::{flight, layers};
use crate::cli::ConfigArgs;
use crate::cli::debug::ReplayArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::fly::files_read;
use crate::outputs;
use crate::say::{say, show};

/// Answers all revolutions again and says which differ from the recorded settings' answers.
pub(crate) fn replay(args: ReplayArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    let input = args.input();
    let read = files_read(&input, args.config.clone())?;
    let start = ConfigArgs { preset: args.preset, config: args.config, set: Vec::new() };
    let layers = layers(&input.recordings.input, &start)?;
    let (reader, lost) = flight::reader(input);
    let mut session = Session::new(registry.clone(), layers, reader).map_err(error_of)?;
    let mut diagnostics = Diagnostics::default();
    diagnostics.lost_all(lost.borrow().iter());
    session.set_from(args.from, &args.set).map_err(error_of)?;
    if let Some(folder) = &args.given {
        session.inject_all(args.from, folder).map_err(error_of)?;
    }
    let said = session.replayed(args.from).map_err(error_of)?.text;
    if let Some(path) = &args.results {
        let mut out = outputs::grow(path, &read)?;
        for (line, failure) in session.lines().map_err(error_of)? {
            if failure.is_none() {
                line.write(&mut out).with_context(|| format!("cannot write {}", path.display()))?;
            }
        }
        out.flush().with_context(|| format!("cannot write {}", path.display()))?;
    }
    let failures: Vec<String> =
        session.lines().map_err(error_of)?.filter_map(|(_, failure)| failure.map(str::to_owned)).collect();
    if let Some(first) = failures.first() {
        diagnostics.error(format_args!("{} fail, the first: {first}", thousands(failures.len() as u64)));
    }
    if args.results.as_deref() == Some(Path::new("-")) {
        say(format_args!("{said}")); // standard output holds the results
    } else {
        show(format_args!("{said}\n"))?;
    }
    Ok(diagnostics.outcome())
}

fn error_of(refused: Refused) -> anyhow::Error {
    match refused {
        Refused::Failed(why) => anyhow::anyhow!(why),
        refused => UsageError(refused.to_string()).into(),
    }
}
