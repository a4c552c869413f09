//! `crosscut config`.

use crosscut_detector::Registry;

use crate::exit::Outcome;
use crate::input::ConfigArgs;
use crate::output::show;

/// Prints the resolved configuration.
pub(crate) fn print(args: &ConfigArgs, registry: &Registry) -> anyhow::Result<Outcome> {
    show(args.resolve(registry)?)?;
    Ok(Outcome::Done)
}
