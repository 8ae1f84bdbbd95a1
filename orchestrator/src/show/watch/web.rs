//! The page of a run in a browser on this machine.

use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tiny_http::{Header, Method, Request, Response, Server};

use super::spectator::{History, lock};
use crate::failure::Failure;
use crate::show::report;

/// The port that is tried first.
const USUAL_PORT: u16 = 8467;
/// Messages that may wait for a browser; one that is slower misses some.
const BACKLOG: usize = 8;
/// Silence after which a connection is tried.
const PULSE: Duration = Duration::from_secs(5);
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

struct Desk {
    history: History,
    duration: f64,
    /// Where this server is, as browsers say it.
    hosts: [String; 2],
    clients: Mutex<Vec<SyncSender<Arc<str>>>>,
    /// Whether any browser has come yet.
    visited: AtomicBool,
    /// Browsers that have not been told all yet.
    open: AtomicUsize,
    /// The last message, once the run is over.
    farewell: Mutex<Option<Arc<str>>>,
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
        let server = Server::from_listener(listener, None).map_err(|error| failed()(io::Error::other(error)))?;
        let desk = Arc::new(Desk {
            history,
            duration,
            hosts: [address.to_string(), format!("localhost:{}", address.port())],
            clients: Mutex::new(Vec::new()),
            visited: AtomicBool::new(false),
            open: AtomicUsize::new(0),
            farewell: Mutex::new(None),
        });
        let serving = desk.clone();
        let serve = move || server.incoming_requests().for_each(|request| serving.clone().answer(request));
        thread::Builder::new().name("web".into()).spawn(serve).map_err(failed())?;
        Ok(Self { desk, address })
    }

    /// Where the page is.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Whether anybody looks, so that frames are worth making.
    pub(crate) fn is_watched(&self) -> bool {
        !lock(&self.desk.clients).is_empty()
    }

    /// Sends something to all browsers; one that does not keep up misses it.
    pub(crate) fn send(&self, event: &str, data: &Value) {
        let message = message(event, data);
        lock(&self.desk.clients)
            .retain(|client| !matches!(client.try_send(message.clone()), Err(TrySendError::Disconnected(_))));
    }

    /// Tells all browsers, also those that come later, that the run is over and what its last frame was, and waits until
    /// those that are there know. Returns whether there were any.
    pub(crate) fn end(&self, text: &str, last: Option<Value>) -> bool {
        *lock(&self.desk.farewell) = Some(message("over", &json!({ "text": text, "frame": last })));
        // Without senders, their threads come to the farewell.
        lock(&self.desk.clients).clear();
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

fn message(event: &str, data: &Value) -> Arc<str> {
    format!("event: {event}\ndata: {data}\n\n").into()
}

impl Desk {
    fn answer(self: Arc<Self>, request: Request) {
        // A page of another site that a browser takes for one of this address must not read this.
        let host =
            request.headers().iter().find(|header| header.field.equiv("Host")).map(|header| header.value.as_str());
        let known = host.is_some_and(|host| self.hosts.iter().any(|known| known == host));
        let (code, body) = match (known, request.method(), request.url()) {
            (false, ..) => (403, "This page is for browsers on this machine.\n".to_string()),
            (_, Method::Get, "/") => (200, self.page()),
            (_, Method::Get, "/events") => {
                let serve = move || self.stream(request);
                // Without a thread there is no live view; the browser tries again.
                let _ = thread::Builder::new().name("events".into()).spawn(serve);
                return;
            }
            _ => (404, "There is only one page, /.\n".to_string()),
        };
        let kind = if code == 200 { "text/html; charset=utf-8" } else { "text/plain; charset=utf-8" };
        let headers = [("Content-Type", kind), ("Cache-Control", "no-store")];
        let headers = headers.into_iter().filter_map(|(name, value)| Header::from_bytes(name, value).ok());
        let response = headers.fold(Response::from_string(body).with_status_code(code), Response::with_header);
        // A browser that goes away has its own reasons.
        let _ = request.respond(response);
    }

    fn page(&self) -> String {
        let history = lock(&self.history);
        if history.samples() == 0 { WAITING.into() } else { report::live(&history, self.duration) }
    }

    fn stream(&self, request: Request) {
        self.open.fetch_add(1, SeqCst);
        let (sender, messages) = sync_channel(BACKLOG);
        {
            // Under the lock of the farewell, so that nobody comes to the list after it was cleared.
            let farewell = lock(&self.farewell);
            if farewell.is_none() {
                lock(&self.clients).push(sender);
            }
        }
        let _ = self.pass_on(&messages, request.into_writer());
        self.visited.store(true, SeqCst);
        self.open.fetch_sub(1, SeqCst);
    }

    fn pass_on(&self, messages: &Receiver<Arc<str>>, mut browser: Box<dyn Write + Send>) -> io::Result<()> {
        let head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
        browser.write_all(head.as_bytes())?;
        browser.flush()?;
        self.visited.store(true, SeqCst);
        loop {
            match messages.recv_timeout(PULSE) {
                Ok(message) => browser.write_all(message.as_bytes())?,
                // A comment, to find out whether anybody is still there.
                Err(RecvTimeoutError::Timeout) => browser.write_all(b":\n\n")?,
                Err(RecvTimeoutError::Disconnected) => break,
            }
            browser.flush()?;
        }
        let farewell = lock(&self.farewell).clone();
        if let Some(message) = farewell {
            browser.write_all(message.as_bytes())?;
        }
        browser.flush()
    }
}
