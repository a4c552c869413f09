//! What stands before the server: web pages of other machines are turned away.
//!
//! Rerun's server asks nobody who he is, and a browser lets any page send requests to any address. A page on another
//! machine is told from a viewer by the headers of its requests: `Origin` is where it comes from, and `Host` is a name
//! where the page reached this machine by a name of its own (DNS rebinding). Browsers speak HTTP/1 to a server without
//! TLS, and use a connection for one host alone, so that the first request of a connection decides.

use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::Duration;

/// The first request of a connection has at most this many bytes before its body.
const HEAD_BYTES: usize = 16 << 10;
/// A client has this long to send them.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// Connections at a time.
const CONNECTIONS: usize = 64;
/// How every connection of HTTP/2 begins that no browser opened.
const HTTP2: &[u8] = b"PRI * HTTP/2.0\r\n";
const REFUSAL: &[u8] = b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";

/// Passes connections on until it is dropped.
pub(crate) struct Gate {
    address: SocketAddr,
    is_over: Arc<AtomicBool>,
}

impl Gate {
    /// Passes on what comes to `listener` to the server at `inner`.
    ///
    /// # Errors
    /// When no thread can be started.
    pub(crate) fn open(listener: TcpListener, inner: SocketAddr) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let is_over = Arc::new(AtomicBool::new(false));
        let (of_thread, open) = (Arc::clone(&is_over), Arc::new(AtomicUsize::new(0)));
        Builder::new().name("gate".to_owned()).spawn(move || {
            for client in listener.incoming() {
                if of_thread.load(Ordering::Relaxed) {
                    return;
                }
                let Ok(client) = client else { continue };
                if open.fetch_add(1, Ordering::Relaxed) >= CONNECTIONS {
                    open.fetch_sub(1, Ordering::Relaxed);
                    continue; // closes it
                }
                let of_client = Arc::clone(&open);
                let serve = move || {
                    pass(&client, inner).ok(); // the client sees that it ends
                    of_client.fetch_sub(1, Ordering::Relaxed);
                };
                if Builder::new().name("gate-client".to_owned()).spawn(serve).is_err() {
                    open.fetch_sub(1, Ordering::Relaxed);
                }
            }
        })?;
        Ok(Self { address, is_over })
    }
}

impl Drop for Gate {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        TcpStream::connect_timeout(&reachable(self.address), HEAD_TIMEOUT).ok(); // wakes the thread
    }
}

/// The address at which this machine reaches a server that listens at `address`.
pub(crate) fn reachable(address: SocketAddr) -> SocketAddr {
    if address.ip().is_unspecified() { SocketAddr::from((Ipv4Addr::LOCALHOST, address.port())) } else { address }
}

/// Passes on one connection in both directions, if its first request may.
fn pass(mut client: &TcpStream, inner: SocketAddr) -> io::Result<()> {
    client.set_read_timeout(Some(HEAD_TIMEOUT))?;
    let head = read_head(client)?;
    if !head.starts_with(HTTP2) && !may(&head) {
        client.write_all(REFUSAL)?;
        return client.shutdown(Shutdown::Both);
    }
    client.set_read_timeout(None)?;
    client.set_nodelay(true)?;
    let mut server = TcpStream::connect(inner)?;
    server.set_nodelay(true)?;
    server.write_all(&head)?;
    let (mut answers, mut to_client) = (server.try_clone()?, client.try_clone()?);
    Builder::new().name("gate-server".to_owned()).spawn(move || {
        io::copy(&mut answers, &mut to_client).ok();
        to_client.shutdown(Shutdown::Both).ok();
    })?;
    let copied = io::copy(&mut client, &mut server);
    server.shutdown(Shutdown::Write)?; // what it still answers is passed on
    copied.map(|_| ())
}

/// The bytes up to the end of the first request's headers, or the beginning of HTTP/2, and what came with them.
fn read_head(mut client: &TcpStream) -> io::Result<Vec<u8>> {
    let (mut head, mut part) = (Vec::new(), [0; 2048]);
    loop {
        let count = client.read(&mut part)?;
        head.extend(&part[..count]);
        if head.starts_with(HTTP2) || head.windows(4).any(|four| four == b"\r\n\r\n") {
            return Ok(head);
        }
        if count == 0 || head.len() > HEAD_BYTES {
            return Err(io::ErrorKind::InvalidData.into());
        }
    }
}

/// Whether a request of HTTP/1 comes from a page of this machine, or from no page: `Host` is an address, not a name, and
/// `Origin`, where there is one, is of the same host.
fn may(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    let headers = || head.split("\r\n").skip(1).take_while(|line| !line.is_empty());
    let values = |name: &str| -> Vec<String> {
        let named = headers().filter_map(|line| line.split_once(':'));
        let named = named.filter(|(key, _)| key.trim().eq_ignore_ascii_case(name));
        named.map(|(_, value)| value.trim().to_ascii_lowercase()).collect()
    };
    let [host] = &values("host")[..] else { return false };
    let Some(host) = address_of(host) else { return false };
    values("origin").iter().all(|origin| {
        let from = origin.split_once("://").and_then(|(_, from)| address_of(from));
        from.is_some_and(|from| from == host || (from.is_loopback() && host.is_loopback()))
    })
}

/// The address in `HOST:PORT`; `None` for a name.
fn address_of(authority: &str) -> Option<IpAddr> {
    let host = match authority.strip_prefix('[') {
        Some(v6) => v6.split_once(']')?.0,
        None => authority.split_once(':').map_or(authority, |(host, _)| host),
    };
    if host == "localhost" { Some(Ipv4Addr::LOCALHOST.into()) } else { host.parse().ok() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_let_in(lines: &[&str]) -> bool {
        may(format!("POST /service HTTP/1.1\r\n{}\r\n\r\n", lines.join("\r\n")).as_bytes())
    }

    #[test]
    fn pages_of_other_machines_and_names_are_turned_away() {
        assert!(is_let_in(&["Host: 127.0.0.1:9877"]));
        assert!(is_let_in(&["host: 192.168.1.7:9877", "Accept: */*"]));
        assert!(is_let_in(&["Host: localhost:9877", "Origin: http://127.0.0.1:9090"]));
        assert!(is_let_in(&["Host: 192.168.1.7:9877", "Origin: http://192.168.1.7:4242"]));
        assert!(is_let_in(&["Host: [fe80::1]:9877", "Origin: http://[fe80::1]:4242"]));
        assert!(!is_let_in(&["Host: evil.example:9877"]), "DNS rebinding");
        assert!(!is_let_in(&["Host: evil.example:9877", "Origin: http://evil.example:9877"]));
        assert!(!is_let_in(&["Host: 192.168.1.7:9877", "Origin: https://evil.example"]));
        assert!(!is_let_in(&["Host: 192.168.1.7:9877", "Origin: http://192.168.1.8"]));
        assert!(!is_let_in(&["Host: 127.0.0.1:9877", "Origin: null"]));
        assert!(!is_let_in(&["Host: 127.0.0.1", "Host: evil.example"]), "two");
        assert!(!is_let_in(&["Accept: */*"]), "none");
    }

    /// What a client reads that sends this, with a server behind the gate that answers in the words it hears.
    fn heard(sent: &[u8]) -> Vec<u8> {
        let inner = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let at = inner.local_addr().expect("bound");
        let echo = Builder::new().spawn(move || {
            if let Ok((client, _)) = inner.accept() {
                io::copy(&mut &client, &mut &client).ok();
            }
        });
        echo.expect("a thread");
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("bound");
        let gate = Gate::open(listener, at).expect("a thread");
        let mut client = TcpStream::connect(address).expect("it listens");
        client.write_all(sent).expect("it reads");
        client.shutdown(Shutdown::Write).expect("connected");
        let mut answer = Vec::new();
        client.read_to_end(&mut answer).ok();
        drop(gate);
        answer
    }

    #[test]
    fn viewers_are_passed_on_byte_for_byte_and_pages_refused() {
        let viewer = [HTTP2, &[b'x'; 100_000]].concat();
        assert!(heard(&viewer) == viewer);
        let page = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
        assert_eq!(heard(page), page);
        assert_eq!(heard(b"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"), REFUSAL);
        assert_eq!(heard(b"no request at all"), b"");
    }
}
