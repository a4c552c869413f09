//! A server that viewers connect to. They get all messages, the earlier ones as well. Rerun's server listens behind a gate.

use std::any::Any;
use std::hash::{BuildHasher as _, RandomState};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use rerun::grpc_server::GrpcServerSink;
use rerun::{MemoryLimit, ServerOptions};

use crate::RecorderError;
use crate::gate::{Gate, reachable};

/// Bytes that are kept for late viewers; of more, the oldest are dropped.
pub(crate) const HISTORY_BYTES: u64 = 1 << 30;
/// How long to wait until a new server answers.
const START_TIMEOUT: Duration = Duration::from_secs(5);

/// Where a recording is served.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Served {
    /// The address for the native viewer: `rerun --connect URL`.
    pub url: String,
    /// The page for a browser; `None` without the feature `web`.
    pub web_url: Option<String>,
    /// Whether it listens at every address of this machine. Other machines put one of these in place of 127.0.0.1.
    pub at_every_address: bool,
}

/// A server that listens.
pub(crate) struct Server {
    pub(crate) sink: GrpcServerSink,
    pub(crate) served: Served,
    /// Passes viewers on until it is dropped.
    _gate: Gate,
    /// Serves the web viewer until it is dropped.
    _web: Option<Pages>,
}

/// Listens at `address`; port 0 takes a free one.
///
/// # Errors
/// When it cannot listen at the address.
pub(crate) fn open(address: SocketAddr) -> Result<Server, RecorderError> {
    let listener = TcpListener::bind(address).map_err(|e| cannot(address, &e))?;
    let address = listener.local_addr().map_err(|e| cannot(address, &e))?;
    let options = ServerOptions {
        memory_limit: MemoryLimit::from_bytes(HISTORY_BYTES),
        cors_allowed_origins: vec!["http://*:*".to_owned()], // the gate has turned away what is of another machine
        ..ServerOptions::default()
    };
    let inner = free_address(SocketAddr::from((hidden_ip(), 0)))?;
    let sink = GrpcServerSink::new(&bind_ip(inner), inner.port(), options).map_err(|e| cannot(address, &e))?;
    await_listening(inner)?;
    let gate = Gate::open(listener, inner).map_err(|e| cannot(address, &e))?;
    let at_every_address = address.ip().is_unspecified();
    let url = format!("rerun+http://{}/proxy", reachable(address));
    let (web, web_url) = web_viewer(address, &url)?.unzip();
    Ok(Server { sink, served: Served { url, web_url, at_every_address }, _gate: gate, _web: web })
}

/// A server of pages, which stops when it is dropped.
type Pages = Box<dyn Any + Send>;

/// The web viewer, at a free port of the same address, and the page that connects it to `url`.
#[cfg(feature = "web")]
fn web_viewer(address: SocketAddr, url: &str) -> Result<Option<(Pages, String)>, RecorderError> {
    let config =
        rerun::web_viewer::WebViewerConfig { bind_ip: bind_ip(address), open_browser: false, ..Default::default() };
    let server = rerun::serve_web_viewer(config).map_err(|e| cannot(address, &e))?;
    let server_url = server.server_url().replace("localhost", "127.0.0.1"); // as in `url`
    let page = format!("{server_url}?url={}", url.replace('+', "%2B"));
    Ok(Some((Box::new(server), page)))
}

#[cfg(not(feature = "web"))]
fn web_viewer(_: SocketAddr, _: &str) -> Result<Option<(Pages, String)>, RecorderError> {
    Ok(None)
}

/// The address with its port. It is tried here, as Rerun binds in another thread and does not report errors.
fn free_address(address: SocketAddr) -> Result<SocketAddr, RecorderError> {
    TcpListener::bind(address).and_then(|listener| listener.local_addr()).map_err(|e| cannot(address, &e))
}

fn await_listening(address: SocketAddr) -> Result<(), RecorderError> {
    let start = Instant::now();
    loop {
        match TcpStream::connect_timeout(&reachable(address), START_TIMEOUT) {
            Ok(_) => return Ok(()),
            Err(error) if start.elapsed() > START_TIMEOUT => return Err(cannot(address, &error)),
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

/// An address of this machine alone. Linux has 16 million of them, so that no page finds the server behind the gate.
fn hidden_ip() -> Ipv4Addr {
    let [_, a, b, c, ..] = RandomState::new().hash_one(()).to_ne_bytes();
    if cfg!(target_os = "linux") {
        Ipv4Addr::new(127, a.clamp(1, 254), b, c.clamp(1, 254))
    } else {
        Ipv4Addr::LOCALHOST
    }
}

/// The host part of the address, as it is written before the colon and the port.
fn bind_ip(address: SocketAddr) -> String {
    match address {
        SocketAddr::V4(v4) => v4.ip().to_string(),
        SocketAddr::V6(v6) => format!("[{}]", v6.ip()),
    }
}

fn cannot(address: SocketAddr, cause: &dyn std::fmt::Display) -> RecorderError {
    RecorderError::Serve { address, cause: cause.to_string() }
}
