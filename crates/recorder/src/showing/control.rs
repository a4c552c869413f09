//! Takes a viewer to a revolution, over the control protocol that Rerun's command line brings (`rerun viewer-mcp`): a layout
//! cannot set the time.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// How long a viewer may take to load a recording.
const PATIENCE: Duration = Duration::from_secs(120);
/// Time between two looks whether it has.
const BETWEEN_LOOKS: Duration = Duration::from_millis(200);
/// Looks in a row at which the viewer has to be where it was taken to: the layout, when it comes, takes it to the end.
const SETTLED: u32 = 5;

/// Takes the viewer that listens at `port` to `revolution`, once it has loaded all up to `last`. `is_open` says whether it is
/// still there.
///
/// # Errors
/// Why it cannot be taken there, in words.
pub(super) fn go_to(port: u16, revolution: i64, last: i64, mut is_open: impl FnMut() -> bool) -> Result<(), String> {
    let mut control = Control::start()?;
    let endpoint = format!("http://127.0.0.1:{port}");
    let since = Instant::now();
    let mut is_connected = false;
    loop {
        if !is_open() {
            return Ok(()); // who closed it does not want to go anywhere
        }
        is_connected = is_connected || control.call("connect", json!({ "endpoint": endpoint })).is_ok();
        if is_connected && control.call("viewer_state", json!({})).is_ok_and(|state| has_loaded(&state, last)) {
            break;
        }
        if since.elapsed() > PATIENCE {
            return Err("it did not load the recording in two minutes".to_owned());
        }
        std::thread::sleep(BETWEEN_LOOKS);
    }
    let mut settled = 0;
    while settled < SETTLED && is_open() && since.elapsed() < PATIENCE {
        if control.call("viewer_state", json!({})).is_ok_and(|state| is_at(&state, revolution)) {
            settled += 1;
        } else {
            control.call("set_time", json!({ "timeline": "revolution", "time": revolution }))?;
            settled = 0;
        }
        std::thread::sleep(BETWEEN_LOOKS);
    }
    Ok(())
}

/// Whether a recording of the viewer is shown at this revolution.
fn is_at(state: &Value, revolution: i64) -> bool {
    let mut recordings = state["recordings"].as_array().into_iter().flatten();
    let shown = |recording: &Value| recording["current_time"]["time"].as_i64() == Some(revolution);
    recordings.any(shown)
}

/// Whether a recording of the viewer reaches up to this revolution.
fn has_loaded(state: &Value, last: i64) -> bool {
    let recordings = state["recordings"].as_array().into_iter().flatten();
    let mut timelines = recordings.flat_map(|recording| recording["timelines"].as_array().into_iter().flatten());
    timelines.any(|line| line["timeline"] == "revolution" && line["max"].as_i64().is_some_and(|max| max >= last))
}

/// The control protocol: JSON-RPC, an object a line.
struct Control {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    asked: u64,
}

impl Control {
    fn start() -> Result<Self, String> {
        let mut command = Command::new("rerun");
        command.arg("viewer-mcp").env("RUST_LOG", "error");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().map_err(|error| format!("`rerun viewer-mcp`: {error}"))?;
        let input = process.stdin.take().expect("it is piped");
        let output = BufReader::new(process.stdout.take().expect("it is piped"));
        let mut control = Self { process, input, output, asked: 0 };
        let client = json!({ "name": "crosscut", "version": env!("CARGO_PKG_VERSION") });
        let hello = json!({ "protocolVersion": "2024-11-05", "capabilities": {}, "clientInfo": client });
        control.ask("initialize", &hello)?;
        control.send(&json!({ "jsonrpc": "2.0", "method": "notifications/initialized" }))?;
        Ok(control)
    }

    /// The result of a tool.
    fn call(&mut self, tool: &str, arguments: Value) -> Result<Value, String> {
        let answer = self.ask("tools/call", &json!({ "name": tool, "arguments": arguments }))?;
        let result = &answer["result"];
        let text = result["content"][0]["text"].as_str().unwrap_or_default();
        if answer["error"].is_object() || result["isError"] == true {
            return Err(format!("{tool}: {text}"));
        }
        serde_json::from_str(text).map_err(|error| format!("{tool}: {error}"))
    }

    fn ask(&mut self, method: &str, params: &Value) -> Result<Value, String> {
        self.asked += 1;
        self.send(&json!({ "jsonrpc": "2.0", "id": self.asked, "method": method, "params": params }))?;
        let mut line = String::new();
        self.output.read_line(&mut line).map_err(|error| format!("`rerun viewer-mcp`: {error}"))?;
        serde_json::from_str(&line).map_err(|error| format!("`rerun viewer-mcp`: {error}"))
    }

    fn send(&mut self, message: &Value) -> Result<(), String> {
        writeln!(self.input, "{message}").map_err(|error| format!("`rerun viewer-mcp`: {error}"))
    }
}

impl Drop for Control {
    fn drop(&mut self) {
        self.process.kill().ok(); // it may have ended
        self.process.wait().ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_is_loaded_once_its_last_revolution_is_there() {
        let state = |max: i64| {
            let lines = json!([{ "timeline": "stamp", "max": 9000 }, { "timeline": "revolution", "max": max }]);
            json!({ "recordings": [{ "timelines": [] }, { "timelines": lines }] })
        };
        assert!(has_loaded(&state(140), 140) && !has_loaded(&state(139), 140) && !has_loaded(&json!({}), 0));
    }
}
