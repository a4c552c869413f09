//! What the process that the program runs in gives it.

use crosscut_detector::Registry;

use crate::input::live::Robots;

/// What the process that the program runs in gives it.
#[derive(Clone, Copy, Default)]
pub struct Host<'a> {
    /// Hears live robots.
    pub robots: Option<&'a dyn Robots>,
    /// Finds stages that are named at the prompt.
    pub kinds: Option<&'a dyn Kinds>,
}

/// Finds kinds of stages while the program runs.
pub trait Kinds {
    /// Adds the kind that a user named to the registry, and gives its name there; `None` if it is none of these kinds. One
    /// whose code changed since gets another name, so that both can be compared.
    ///
    /// # Errors
    /// Why there is none of that name.
    fn find(&self, kind: &str, registry: &mut Registry) -> Result<Option<String>, String>;

    /// Where such a stage failed last, as its own language prints it; once.
    fn failed(&self) -> Option<String>;
}
