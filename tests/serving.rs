//! `--serve`: viewers connect during a run and afterwards.

use std::io::{BufRead as _, BufReader};
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};

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

#[test]
#[cfg(unix)]
fn a_flight_is_served_until_interrupted_and_ends_with_0() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let mut child = crosscut(["run".as_ref(), flight.as_os_str(), "--serve=127.0.0.1:0".as_ref(), "--quiet".as_ref()])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut words = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut said = String::new();
    while !said.contains("still served") {
        assert_ne!(words.read_line(&mut said).expect("UTF-8"), 0, "it ended:\n{said}");
    }
    let url = said.split_whitespace().find(|word| word.starts_with("rerun+http://")).expect("the URL is said");
    let address = url.trim_start_matches("rerun+http://").trim_end_matches("/proxy");
    TcpStream::connect(address).expect("it listens");
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(interrupted.expect("kill is on every Unix").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
    assert!(TcpStream::connect(address).is_err(), "nothing listens any more");
}
