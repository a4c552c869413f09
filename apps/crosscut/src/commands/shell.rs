//! `crosscut completions` and `crosscut man`: the command line for the shell and for its manual.

use std::io::Write as _;
use std::path::Path;

use anyhow::Context;
use clap::Command;
use clap_complete::Shell;

use crate::exit::Outcome;
use crate::output::say;

/// Prints the script of completions.
pub(crate) fn completions(shell: Shell, mut command: Command) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, "crosscut", &mut script);
    std::io::stdout().write_all(&script).context("standard output")?;
    Ok(Outcome::Done)
}

/// Writes the pages.
pub(crate) fn man(folder: &Path, command: Command) -> anyhow::Result<Outcome> {
    let written = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command, folder));
    written.with_context(|| format!("cannot write pages into {}", folder.display()))?;
    say(format_args!("{}: `man -l {}`", folder.display(), folder.join("crosscut.1").display()));
    Ok(Outcome::Done)
}
