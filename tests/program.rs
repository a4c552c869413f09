//! The program under test, and paths of the project.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The root of the project.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The flight that ships with the project.
pub(crate) fn shipped_flight() -> PathBuf {
    root().join("recordings/tee.mcap")
}

/// The command `crosscut` with these arguments.
pub(crate) fn crosscut<A: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_crosscut"));
    command.args(args);
    command
}

/// How a run ended.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    /// Fails with the complete output unless the program ended with `code`.
    #[track_caller]
    pub(crate) fn expect_code(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stderr:\n{}\nstdout:\n{}", self.stderr, self.stdout);
        self
    }
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

/// Runs `crosscut` to its end.
pub(crate) fn run<A: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = A>) -> Ran {
    crosscut(args).output().expect("the program starts").into()
}

/// Runs `crosscut run INPUT --out -` with more arguments; returns how it ended, and the lines of results.
pub(crate) fn results_of(input: &Path, more: &[&str]) -> (Ran, Vec<Value>) {
    let mut args = vec!["run".to_owned(), input.display().to_string(), "--out".to_owned(), "-".to_owned()];
    args.extend(more.iter().map(ToString::to_string));
    let ran = run(args);
    let lines = lines(&ran.stdout);
    (ran, lines)
}

/// Parses JSON lines.
pub(crate) fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("every line is JSON")).collect()
}

/// The values of a whole-number field in every line.
pub(crate) fn column(lines: &[Value], field: &str) -> Vec<u64> {
    lines.iter().map(|line| line[field].as_u64().expect("a whole number")).collect()
}
