//! The native viewer: found, started, connected to.

use rerun::external::re_uri::ProxyUri;
use rerun::sink::GrpcSink;
use rerun::{SpawnError, SpawnOptions};

use crate::RecorderError;

/// Starts the viewer called `executable`, unless one listens already, and connects to it.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_viewer_is_said_with_the_line_that_installs_it() {
        let error = connect("no-such-viewer-9d1f").err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains("pip install rerun-sdk==0.36.3"), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
}
