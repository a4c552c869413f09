//! The native viewer: find it, start it, connect to it.

use std::process::{Child, ChildStdin, Command, Stdio};

use rerun::external::re_uri::ProxyUri;
use rerun::log::LogMsg;
use rerun::sink::GrpcSink;
use rerun::{SpawnError, SpawnOptions};

use crate::RecorderError;
use crate::piped::Piped;

/// Connects to the native viewer; starts the one called `executable` unless one listens already.
///
/// # Errors
/// When there is no viewer, or it cannot be started.
pub(crate) fn connect(executable: &str) -> Result<GrpcSink, RecorderError> {
    let options = SpawnOptions {
        executable_name: executable.to_owned(),
        extra_args: vec!["--bind".to_owned(), "127.0.0.1".to_owned()],
        hide_welcome_screen: true,
        ..SpawnOptions::default()
    };
    let viewer = rerun::spawn(&options).map_err(|error| match error {
        SpawnError::ExecutableNotFoundInPath { .. } | SpawnError::ExecutableNotFound { .. } => RecorderError::NoViewer,
        SpawnError::Io(io) => RecorderError::Viewer(io.to_string()),
    })?;
    let uri: ProxyUri = format!("rerun+http://127.0.0.1:{}/proxy", viewer.port)
        .parse()
        .map_err(|e| RecorderError::Viewer(format!("{e}")))?;
    Ok(GrpcSink::new(uri))
}

/// A separate viewer that reads a recording from its standard input.
pub(crate) struct Viewer {
    process: Child,
    input: Piped<ChildStdin>,
}

impl Viewer {
    /// Starts the viewer called `executable`, which listens at `port`, or at any.
    ///
    /// # Errors
    /// When there is none.
    pub(crate) fn start(executable: &str, port: Option<u16>) -> Result<Self, RecorderError> {
        let port = port.map_or_else(|| "--port=auto".to_owned(), |port| format!("--port={port}"));
        let mut command = Command::new(executable);
        command.args([&port, "--bind=127.0.0.1", "-"]).stdin(Stdio::piped()).stdout(Stdio::null());
        let mut process = command.spawn().map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => RecorderError::NoViewer,
            _ => RecorderError::Viewer(error.to_string()),
        })?;
        let input = Piped::without_footer(process.stdin.take().expect("it is piped"));
        Ok(Self { process, input })
    }

    /// Hands a message over. Returns whether the viewer reads more.
    pub(crate) fn take(&mut self, message: &LogMsg) -> bool {
        self.input.take(message)
    }

    /// Hands over the end.
    pub(crate) fn end(&mut self) {
        self.input.end(); // fails if the viewer was closed, which `wait` handles
    }

    /// Whether it was not closed yet.
    pub(crate) fn is_open(&mut self) -> bool {
        matches!(self.process.try_wait(), Ok(None))
    }

    /// Waits until the viewer is closed.
    ///
    /// # Errors
    /// When the viewer failed.
    pub(crate) fn wait(mut self) -> Result<(), RecorderError> {
        self.end();
        let ended = self.process.wait().map_err(|e| RecorderError::Viewer(e.to_string()))?;
        if ended.success() { Ok(()) } else { Err(RecorderError::Viewer(format!("it ended with {ended}"))) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_missing_viewer_has_the_install_command() {
        let error = connect("no-such-viewer-9d1f").err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains("pip install rerun-sdk==0.36.3"), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
}
