//! The progress bar.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar that counts revolutions on standard error. Hidden if `quiet`, or if standard error is no terminal.
pub(crate) fn bar(total: Option<u64>, quiet: bool) -> ProgressBar {
    match total {
        Some(_) => drawn("{bar:40} {pos}/{len} revolutions, {per_sec}, {eta} left", total, quiet),
        None => counter("revolutions", quiet),
    }
}

/// A counter on standard error of things whose number is not known ahead.
pub(crate) fn counter(things: &str, quiet: bool) -> ProgressBar {
    drawn(&format!("{{spinner}} {{pos}} {things}, {{per_sec}}"), None, quiet)
}

fn drawn(template: &str, total: Option<u64>, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("the templates above are valid");
    ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr_with_hz(10)).with_style(style)
}
