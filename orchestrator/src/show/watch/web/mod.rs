//! The page of a run in a browser on this machine.
//!
//! One thread serves all browsers and never blocks on one: every connection is a state machine with limits of size and time, so
//! that a slow browser does not delay the others. `httparse` parses the heads of requests; docs/architecture.md says why there is
//! no HTTP server of a crate.

mod connection;
mod limits;
mod request;
mod server;

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{EventfdFlags, eventfd};
use serde_json::{Value, json};

use self::connection::Text;
use self::limits::MAX_BACKLOG;
use self::server::Server;
use super::monitor::{History, lock};
use crate::failure::Failure;
use crate::show::report;

/// The port that is tried first.
const USUAL_PORT: u16 = 8467;
/// How long browsers may take to receive the last message.
const END_TIMEOUT: Duration = Duration::from_secs(3);

/// The page before the first step.
const WAITING: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0.3\">\
<title>Phalanx</title><link rel=\"icon\" href=\"data:,\"><p>The run is about to start.</p></html>";

/// Serves the page until the program ends.
pub(crate) struct Web {
    shared: Arc<SharedState>,
    address: SocketAddr,
}

/// State that the thread of the server shares with the rest of the program.
struct SharedState {
    history: History,
    duration: f64,
    /// Why the page begins when the run was joined; `None` if it begins with the run.
    no_past: Option<String>,
    /// The values of `Host` that name this server.
    hosts: [String; 2],
    outbox: Mutex<Outbox>,
    /// An eventfd that wakes the thread of the server when there is something in the outbox.
    wakeup: OwnedFd,
    /// Whether any browser has received a message.
    visited: AtomicBool,
    /// Streams that are open.
    open: AtomicUsize,
    /// The last message, once the run is over.
    last_message: Mutex<Option<Text>>,
}

/// Messages that were not passed to the streams yet.
#[derive(Default)]
struct Outbox {
    messages: Vec<Text>,
    /// The last message is due.
    ends: bool,
}

impl Web {
    /// Listens on this machine alone: on `port`, or on the usual one if that is free, else on any. `no_past` says why the page
    /// does not begin with the run, if so.
    ///
    /// # Errors
    /// [`Failure::System`] if the port is taken.
    pub(crate) fn start(
        port: Option<u16>,
        history: History,
        duration: f64,
        no_past: Option<String>,
    ) -> Result<Self, Failure> {
        let listen = |port: u16| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        let listener = match port {
            Some(port) => listen(port).map_err(Failure::system(format!("listen on port {port} of 127.0.0.1"))),
            None => listen(USUAL_PORT).or_else(|_| listen(0)).map_err(Failure::system("listen on 127.0.0.1")),
        }?;
        let failed = || Failure::system("serve a page");
        let address = listener.local_addr().map_err(failed())?;
        let wakeup = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK);
        let shared = Arc::new(SharedState {
            history,
            duration,
            no_past,
            hosts: [address.to_string(), format!("localhost:{}", address.port())],
            outbox: Mutex::default(),
            wakeup: wakeup.map_err(|error| failed()(error.into()))?,
            visited: AtomicBool::new(false),
            open: AtomicUsize::new(0),
            last_message: Mutex::new(None),
        });
        let server = Server::new(shared.clone(), listener).map_err(failed())?;
        thread::Builder::new().name("web".into()).spawn(move || server.run()).map_err(failed())?;
        Ok(Self { shared, address })
    }

    /// Where the page is.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Whether any browser watches, so that frames are needed.
    pub(crate) fn is_watched(&self) -> bool {
        self.shared.open.load(SeqCst) > 0
    }

    /// Sends an event to all browsers. A browser that does not keep up misses it.
    pub(crate) fn send(&self, event: &str, data: &Value) {
        let message = message(event, data);
        {
            let mut outbox = lock(&self.shared.outbox);
            if outbox.messages.len() >= MAX_BACKLOG {
                outbox.messages.remove(0);
            }
            outbox.messages.push(message);
        }
        self.shared.wake();
    }

    /// Sends the end of the run with its last frame to all browsers, also to those that connect later, and waits until the
    /// connected ones have it. Returns whether there ever was one.
    pub(crate) fn end(&self, text: &str, last: Option<Value>) -> bool {
        *lock(&self.shared.last_message) = Some(message("over", &json!({ "text": text, "frame": last })));
        lock(&self.shared.outbox).ends = true;
        self.shared.wake();
        let deadline = Instant::now() + END_TIMEOUT;
        while self.shared.open.load(SeqCst) > 0 && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(10));
        }
        self.shared.visited.load(SeqCst)
    }

    /// Whether a browser has received everything.
    pub(crate) fn is_done(&self) -> bool {
        self.shared.visited.load(SeqCst) && self.shared.open.load(SeqCst) == 0
    }
}

fn message(event: &str, data: &Value) -> Text {
    format!("event: {event}\ndata: {data}\n\n").into()
}

impl SharedState {
    /// Wakes the thread of the server.
    fn wake(&self) {
        // Fails only if the counter of the eventfd is full, after 2^64 calls; the thread is awake then.
        let _ = rustix::io::write(&self.wakeup, &1u64.to_ne_bytes());
    }

    fn page(&self) -> String {
        let history = lock(&self.history);
        if history.samples() == 0 {
            WAITING.into()
        } else {
            report::live(&history, self.duration, self.no_past.as_deref())
        }
    }
}
