//! JSON-RPC 2.0, an object a line: `{"jsonrpc":"2.0","id":1,"method":"seek","params":["81"]}`. The result has the text for
//! people and the values of the command; where the session stands is in `revolution`.

use std::io::{BufRead, Write};

use anyhow::Context;
use crosscut_debugger::{Refused, Reply};
use serde_json::{Value, json};

use super::{Debugger, is_end};

const NO_JSON: i64 = -32700;
const NO_REQUEST: i64 = -32600;
const UNKNOWN: i64 = -32601;
const WRONG_WORDS: i64 = -32602;
const FAILED: i64 = -32000;

/// Answers one line after the other up to the end, or up to `quit`, which is answered.
pub(super) fn answer_all(debugger: &mut Debugger, lines: impl BufRead, out: &mut impl Write) -> anyhow::Result<()> {
    for line in lines.lines() {
        let line = line.context("standard input")?;
        if line.trim().is_empty() {
            continue;
        }
        let (answer, is_end) = answer(debugger, &line);
        if let Some(answer) = answer {
            writeln!(out, "{answer}").and_then(|()| out.flush()).context("standard output")?;
        }
        if is_end {
            break;
        }
    }
    Ok(())
}

/// The answer to a line, unless it wants none, and whether it ends the session.
fn answer(debugger: &mut Debugger, line: &str) -> (Option<Value>, bool) {
    let request: Value = match serde_json::from_str(line) {
        Ok(request) => request,
        Err(wrong) => return (Some(error(Value::Null, NO_JSON, &wrong.to_string())), false),
    };
    let id = request.get("id").cloned();
    let Some(words) = words_of(&request) else {
        let text = "a request is {\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"seek\",\"params\":[\"81\"]}";
        return (Some(error(id.unwrap_or(Value::Null), NO_REQUEST, text)), false);
    };
    let ends = is_end(&words);
    let done = if ends { Ok(Reply { text: String::new(), value: json!({}) }) } else { debugger.command(&words) };
    let Some(id) = id else { return (None, ends) }; // a notification
    let answer = match done {
        Ok(Reply { text, value: mut result }) => {
            result["text"] = text.into();
            result["at"] = debugger.session.frame().revolution.seq.into();
            json!({"jsonrpc": "2.0", "id": id, "result": result})
        }
        Err(refused) => {
            let code = match refused {
                Refused::Unknown(_) => UNKNOWN,
                Refused::Usage(_) => WRONG_WORDS,
                Refused::Failed(_) => FAILED,
            };
            error(id, code, &refused.to_string())
        }
    };
    (Some(answer), ends)
}

/// The method and its params as words; `None` if the request is none.
fn words_of(request: &Value) -> Option<Vec<String>> {
    let word = |param: &Value| match param {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    let mut words = vec![request.get("method")?.as_str()?.to_owned()];
    if let Some(params) = request.get("params") {
        words.extend(params.as_array()?.iter().map(word).collect::<Option<Vec<_>>>()?);
    }
    (request.get("jsonrpc")? == "2.0").then_some(words)
}

fn error(id: Value, code: i64, message: &str) -> Value {
    json!({"jsonrpc": "2.0", "id": id, "error": {"code": code, "message": message}})
}
