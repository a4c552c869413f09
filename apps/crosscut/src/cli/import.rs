//! What the Rerun viewer calls an importer with.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct ImportArgs {
    /// The file that the viewer opens.
    pub(crate) file: PathBuf,
    /// What else the viewer says. Later viewers may say more, which changes nothing here.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    said: Vec<String>,
}

impl ImportArgs {
    /// The value of an option.
    pub(crate) fn value(&self, option: &str) -> Option<&str> {
        let mut said = self.said.iter();
        while let Some(word) = said.next() {
            if word == option {
                return said.next().map(String::as_str);
            }
            if let Some(value) = word.strip_prefix(option).and_then(|rest| rest.strip_prefix('=')) {
                return Some(value);
            }
        }
        None
    }
}
