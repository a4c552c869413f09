//! The commands that write more than arrays: settings and recordings.

use std::path::{Path, PathBuf};

use crosscut_debugger::{Refused, Session};
use crosscut_outfile::Keep;

use crate::output::{Document, files};

/// What is around a session.
pub(super) struct Outside {
    /// Of the flight, for recordings.
    #[cfg_attr(not(feature = "rerun"), allow(dead_code))] // recordings need the feature
    pub(super) name: String,
    /// The files that were read, which no output may replace.
    pub(super) read: Vec<PathBuf>,
}

impl Outside {
    /// Does what the words say, if it is no work of the session alone.
    pub(super) fn command(&self, session: &mut Session, words: &[String]) -> Option<Result<String, Refused>> {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        Some(match words[..] {
            ["write", path] => self.write(session, Path::new(path)),
            ["save", path] => self.save(session, Path::new(path)),
            ["write", ..] => Err(Refused::Usage("write SETTINGS.toml: write the present settings".to_owned())),
            ["save", ..] => Err(Refused::Usage("save FLIGHT.rrd: record the whole flight".to_owned())),
            ["get", _, path] => match self.refuse(Path::new(path)) {
                Err(refused) => Err(refused),
                Ok(()) => return None,
            },
            _ => return None,
        })
    }

    fn refuse(&self, path: &Path) -> Result<(), Refused> {
        files::refuse(&[path], &self.read).map_err(|error| Refused::Usage(error.0))
    }

    fn write(&self, session: &Session, path: &Path) -> Result<String, Refused> {
        self.refuse(path)?;
        let mut out = Document::create(path, &self.read, Keep::ThroughKill).map_err(failed)?;
        let (mut text, mut options) = (session.config().to_string(), String::new());
        for (key, kind) in session.config().settings().filter(|(_, kind)| kind.contains("python:")) {
            let kind = kind.trim_matches('"');
            let named = kind.split('#').next().unwrap_or(kind); // as it is called outside of this session
            text = text.replace(kind, named);
            if key.ends_with(".kind") {
                options += &format!(" --set {key}={named}"); // code is named by the user alone
            }
        }
        out.write(&text).map_err(failed)?;
        let path = path.display();
        Ok(format!("settings in {path}; `--config {path}{options}` takes them"))
    }

    #[cfg(feature = "rerun")]
    fn save(&self, session: &mut Session, path: &Path) -> Result<String, Refused> {
        use crosscut_recorder::{Recorder, RecorderOptions, TrueWalls};

        use super::viewing::tell;

        self.refuse(path)?;
        let truth = TrueWalls::default();
        session.truths().for_each(|(seq, of)| tell(&truth, seq, of));
        let options = RecorderOptions {
            truth,
            path: Some(crate::output::record::rrd_path(path.to_owned()).map_err(|why| Refused::Usage(why.to_owned()))?),
            ..crate::output::observers::recorder_options(self.name.clone(), session.config())
        };
        let mut recorder = Recorder::new(options).map_err(failed)?;
        let revolutions = session.show_all(&mut recorder).map_err(failed)?;
        let path = path.display();
        if revolutions < session.revolutions() {
            return Err(Refused::Failed(format!("stopped; {path} holds the first {revolutions} revolutions")));
        }
        Ok(format!("{revolutions} revolutions in {path}; `crosscut view {path}` shows them"))
    }

    #[cfg(not(feature = "rerun"))]
    fn save(&self, _: &mut Session, _: &Path) -> Result<String, Refused> {
        Err(Refused::Failed(crate::gate::without_rerun().to_string()))
    }
}

fn failed(error: impl Into<anyhow::Error>) -> Refused {
    Refused::Failed(format!("{:#}", error.into()))
}
