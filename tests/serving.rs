//! `--serve`: viewers connect during a run and afterwards.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::flight::{Writing, file, tunnel};
use crate::program::{crosscut, results_of};

#[test]
fn an_address_in_use_leaves_recording_and_results_complete() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let taken = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = taken.local_addr().expect("it is bound");
    let saved = folder.path().join("tunnel.rrd");
    let (ran, lines) = results_of(&flight, &[&format!("--serve={address}"), "--save", saved.to_str().expect("UTF-8")]);
    let ran = ran.expect_code(3);
    assert_eq!(lines.len(), 5);
    assert!(ran.stderr.contains(&format!("cannot serve at {address}: ")), "{}", ran.stderr);
    assert!(saved.metadata().expect("saved").len() > 20_000);
}

/// A run that serves the flight, and what it said until its end.
#[cfg(unix)]
fn serving(flight: &Path, address: &str) -> (Child, String) {
    let serve = format!("--serve={address}");
    let mut child = crosscut(["run".as_ref(), flight.as_os_str(), serve.as_ref(), "--quiet".as_ref()])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut words = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut said = String::new();
    while !said.contains("still served") {
        assert_ne!(words.read_line(&mut said).expect("UTF-8"), 0, "it ended:\n{said}");
    }
    (child, said)
}

/// Whether a page of `origin` that calls the machine `host` may read from the server at `address`.
#[cfg(unix)]
fn allows(address: &str, host: &str, origin: &str) -> bool {
    let mut stream = TcpStream::connect(address).expect("it listens");
    let request = format!("OPTIONS / HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nConnection: close\r\n");
    let preflight = format!("{request}Access-Control-Request-Method: POST\r\n\r\n");
    stream.write_all(preflight.as_bytes()).expect("it reads");
    let mut answer = String::new();
    let mut lines = BufReader::new(stream);
    while lines.read_line(&mut answer).is_ok_and(|bytes| bytes > 2) {}
    answer.to_lowercase().contains(&format!("access-control-allow-origin: {origin}"))
}

#[test]
#[cfg(unix)]
fn other_machines_can_connect_to_a_server_at_every_address() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let (mut child, said) = serving(&flight, "0.0.0.0:0");
    assert!(said.contains("from another machine: put this machine's address in place of 127.0.0.1"), "{said}");
    let address = address_in(&said);
    for (host, origin, expected) in [
        (address, "http://127.0.0.1:4242", true),
        ("192.168.1.7:9877", "http://192.168.1.7:4242", true),
        ("192.168.1.7:9877", "http://192.168.1.8:4242", false),
        (address, "https://example.com", false),
        ("example.com:9877", "http://example.com:9877", false),
    ] {
        assert_eq!(allows(address, host, origin), expected, "{host} {origin}");
    }
    child.kill().expect("it runs");
    child.wait().expect("it ends");
}

/// Where the program said that it listens.
#[cfg(unix)]
fn address_in(said: &str) -> &str {
    let url = said.split_whitespace().find(|word| word.starts_with("rerun+http://")).expect("the URL is said");
    url.trim_start_matches("rerun+http://").trim_end_matches("/proxy")
}

#[test]
#[cfg(unix)]
fn a_flight_is_served_until_interrupted_and_ends_with_0() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let (mut child, said) = serving(&flight, "127.0.0.1:0");
    assert!(!said.contains("another machine"), "{said}");
    let address = address_in(&said);
    TcpStream::connect(address).expect("it listens");
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupted.expect("kill is on every Unix").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
    assert!(TcpStream::connect(address).is_err(), "nothing listens any more");
}
