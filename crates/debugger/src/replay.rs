//! The whole flight from one stage on: with other settings, or with what another program made in place of the stages before.

use std::path::Path;

use crosscut_evaluate::settings_of_step;
use crosscut_report::ResultsLine;
use crosscut_stage::{Step, counted};
use serde_json::json;

use crate::settings::{Array, array_in};
use crate::{Refused, Reply, Session};

/// What a stage takes of the stage before, by its name in files.
fn input_of(step: Step) -> Option<&'static str> {
    match step {
        Step::Ingest | Step::Affinity => None,
        Step::Spectral => Some("W"),
        Step::Kmeans => Some("U"),
        Step::Report => Some("labels"),
    }
}

impl Session {
    /// Holds the present settings as A, then takes these, `section.key=value` each, which must leave the stages before `from`
    /// as they are.
    ///
    /// # Errors
    /// When a setting is not allowed, or is one of an earlier stage.
    pub fn set_from(&mut self, from: Step, settings: &[String]) -> Result<(), Refused> {
        self.hold();
        let mut changes = self.changes.clone();
        for setting in settings {
            let (key, value) =
                setting.split_once('=').ok_or_else(|| Refused::Usage(format!("{setting} is no section.key=value")))?;
            changes.push([key.to_owned(), value.to_owned()]);
        }
        let before = self.config().clone();
        self.configure(changes)?;
        let is_earlier = |step: &&Step| (**step as usize) < from as usize;
        let changed = |step: &&Step| settings_of_step(&before, **step) != settings_of_step(self.config(), **step);
        match Step::ALL.iter().filter(is_earlier).find(changed) {
            None => Ok(()),
            Some(step) => {
                Err(Refused::Usage(format!("a setting of {step} changes what {from} is given: replay from {step}")))
            }
        }
    }

    /// Gives the stage `from` what the folder holds for it: `W-107.npy`, `U-107.npy` or `labels-107.npy` for revolution 107.
    /// Revolutions without a file keep what the stages make. Returns how many have one.
    ///
    /// # Errors
    /// When a file cannot be read or does not fit, there is none, or the stage takes nothing from files.
    pub fn inject_all(&mut self, from: Step, folder: &Path) -> Result<usize, Refused> {
        let what =
            input_of(from).ok_or_else(|| Refused::Usage(format!("{from} takes no arrays: set affinity.kind")))?;
        let mut given = self.now.given.clone();
        let mut found = 0;
        for scan in given.flight.iter() {
            let seq = scan.revolution.seq;
            let path = folder.join(format!("{what}-{seq}.npy"));
            if !path.is_file() {
                continue;
            }
            let injected = given.injected.entry(seq).or_default();
            match array_in(what, &path.display().to_string(), scan.revolution.len())? {
                Array::W(w) => injected.w = Some(w),
                Array::U(u) => injected.u = Some(u),
                Array::Labels(labels) => injected.labels = Some(labels),
            }
            found += 1;
        }
        if found == 0 {
            return Err(Refused::Failed(format!("no {what}-N.npy of a revolution N in {}", folder.display())));
        }
        self.give(given);
        Ok(found)
    }

    /// What the settings and arrays that were given change, in words: A is what was held.
    ///
    /// # Errors
    /// When nothing is held.
    pub fn replayed(&mut self, from: Step) -> Result<Reply, Refused> {
        self.before = None;
        let differs = self.differs()?;
        let given = self.now.given.injected.len();
        let arrays = input_of(from).filter(|_| given > 0);
        let arrays = arrays.map_or_else(String::new, |what| format!(", {what} of {given} given"));
        let all = counted(self.revolutions() as u64, "revolution");
        let text = format!("{all} replayed from {from}{arrays}\n{}", differs.text);
        Ok(Reply::new(text, json!({"revolutions": self.revolutions(), "given": given, "differs": differs.value})))
    }

    /// The line of results of every revolution with the present settings; of one that fails, an empty line and why.
    ///
    /// # Errors
    /// When somebody asks to stop.
    pub fn lines(&mut self) -> Result<impl Iterator<Item = (&ResultsLine, Option<&str>)>, Refused> {
        let answers = self.now.answers(&self.means)?;
        Ok(answers.iter().map(|answer| (&answer.line, answer.failure.as_deref())))
    }
}
