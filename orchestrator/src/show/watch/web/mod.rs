//! The page of a run in a browser on this machine.
//!
//! One thread serves all browsers, and never waits for one: every connection is a state with limits of size and time, and what
//! one browser does not take costs the others nothing. `httparse` reads the heads of requests; the rest of HTTP that a page and
//! a stream of events need is less than a server that can more would need of options to be kept in check.

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
use self::limits::BACKLOG;
use self::server::Server;
use super::spectator::{History, lock};
use crate::failure::Failure;
use crate::show::report;

/// The port that is tried first.
const USUAL_PORT: u16 = 8467;
/// How long browsers may take for the end.
const FAREWELL: Duration = Duration::from_secs(3);

/// What is shown while no step is done.
const WAITING: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0.3\">\
<title>Phalanx</title><link rel=\"icon\" href=\"data:,\"><p>The run is about to start.</p></html>";

/// Serves the page until the program ends.
pub(crate) struct Web {
    desk: Arc<Desk>,
    address: SocketAddr,
}

/// What the thread of the server and the rest of the program share.
struct Desk {
    history: History,
    duration: f64,
    /// Where this server is, as browsers say it.
    hosts: [String; 2],
    outbox: Mutex<Outbox>,
    /// Rung when there is something in the outbox.
    bell: OwnedFd,
    /// Whether any browser has come yet.
    visited: AtomicBool,
    /// Streams that have not been sent all yet.
    open: AtomicUsize,
    /// The last message, once the run is over.
    farewell: Mutex<Option<Text>>,
}

/// What the streams have not been given yet.
#[derive(Default)]
struct Outbox {
    messages: Vec<Text>,
    /// The farewell is there.
    ends: bool,
}

impl Web {
    /// Listens on this machine alone: on `port`, or on the usual one if that is free, else on any.
    ///
    /// # Errors
    /// [`Failure::System`] if the port is taken.
    pub(crate) fn start(port: Option<u16>, history: History, duration: f64) -> Result<Self, Failure> {
        let listen = |port: u16| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        let listener = match port {
            Some(port) => listen(port).map_err(Failure::system(format!("listen on port {port} of 127.0.0.1"))),
            None => listen(USUAL_PORT).or_else(|_| listen(0)).map_err(Failure::system("listen on 127.0.0.1")),
        }?;
        let failed = || Failure::system("serve a page");
        let address = listener.local_addr().map_err(failed())?;
        let bell = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK);
        let desk = Arc::new(Desk {
            history,
            duration,
            hosts: [address.to_string(), format!("localhost:{}", address.port())],
            outbox: Mutex::default(),
            bell: bell.map_err(|error| failed()(error.into()))?,
            visited: AtomicBool::new(false),
            open: AtomicUsize::new(0),
            farewell: Mutex::new(None),
        });
        let server = Server::new(desk.clone(), listener).map_err(failed())?;
        thread::Builder::new().name("web".into()).spawn(move || server.run()).map_err(failed())?;
        Ok(Self { desk, address })
    }

    /// Where the page is.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Whether any browser looks, so that frames are worth making.
    pub(crate) fn is_watched(&self) -> bool {
        self.desk.open.load(SeqCst) > 0
    }

    /// Sends something to all browsers; one that does not keep up misses it.
    pub(crate) fn send(&self, event: &str, data: &Value) {
        let message = message(event, data);
        {
            let mut outbox = lock(&self.desk.outbox);
            if outbox.messages.len() >= BACKLOG {
                outbox.messages.remove(0);
            }
            outbox.messages.push(message);
        }
        self.desk.ring();
    }

    /// Tells all browsers, also those that come later, that the run is over and what its last frame was, and waits until
    /// those that are there know. Returns whether there were any.
    pub(crate) fn end(&self, text: &str, last: Option<Value>) -> bool {
        *lock(&self.desk.farewell) = Some(message("over", &json!({ "text": text, "frame": last })));
        lock(&self.desk.outbox).ends = true;
        self.desk.ring();
        let patience = Instant::now() + FAREWELL;
        while self.desk.open.load(SeqCst) > 0 && Instant::now() < patience {
            thread::sleep(Duration::from_millis(10));
        }
        self.desk.visited.load(SeqCst)
    }

    /// Whether any browser has been told everything.
    pub(crate) fn is_done(&self) -> bool {
        self.desk.visited.load(SeqCst) && self.desk.open.load(SeqCst) == 0
    }
}

fn message(event: &str, data: &Value) -> Text {
    format!("event: {event}\ndata: {data}\n\n").into()
}

impl Desk {
    /// Wakes the thread of the server.
    fn ring(&self) {
        // Full only if it has been rung 2^64 times without being heard.
        let _ = rustix::io::write(&self.bell, &1u64.to_ne_bytes());
    }

    fn page(&self) -> String {
        let history = lock(&self.history);
        if history.samples() == 0 { WAITING.into() } else { report::live(&history, self.duration) }
    }
}
