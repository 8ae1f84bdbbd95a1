//! The thread that serves all browsers: one poll over all connections, none of which can block it.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::connection::{Connection, ConnectionKind, Text};
use super::limits::{CHECK_INTERVAL, MAX_ANSWERS, MAX_STREAMS, MAX_WAITING, PAGE_LIFETIME};
use super::request::{Parsed, Status, Target};
use super::{SharedState, lock};

const HTML: &str = "text/html";
const PLAIN: &str = "text/plain";

/// Serves the page; lives in its thread.
pub(super) struct Server {
    shared: Arc<SharedState>,
    listener: TcpListener,
    connections: Vec<Connection>,
    /// The newest page, and when it was made.
    page: Option<(Instant, Text)>,
    /// No connection is accepted before this time: the process had no file descriptor left.
    rest_until: Option<Instant>,
}

impl Server {
    /// Serves on a listener.
    ///
    /// # Errors
    /// What the operating system reports.
    pub(super) fn new(shared: Arc<SharedState>, listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self { shared, listener, connections: Vec::new(), page: None, rest_until: None })
    }

    /// Serves until the program ends.
    pub(super) fn run(mut self) {
        loop {
            let ready = self.wait();
            let now = Instant::now();
            if self.rest_until.is_some_and(|until| now >= until) {
                self.rest_until = None;
            }
            self.serve(&ready, now);
            self.pass_on();
            self.connections.retain_mut(|connection| connection.send(now).is_ok() && !connection.is_overdue(now));
            self.accept(now);
            self.report();
        }
    }

    /// Waits until a file is ready or the limits have to be checked. Returns which connections can be read.
    fn wait(&self) -> Vec<bool> {
        let resting = self.rest_until.is_some();
        let interest = if resting { PollFlags::empty() } else { PollFlags::IN };
        let mut files = vec![PollFd::new(&self.shared.wakeup, PollFlags::IN), PollFd::new(&self.listener, interest)];
        files.extend(self.connections.iter().map(|connection| PollFd::new(connection.stream(), connection.interest())));
        let timeout = (resting || !self.connections.is_empty()).then(|| timespec(CHECK_INTERVAL));
        // A signal may interrupt it; the next round finds the same.
        let _ = poll(&mut files, timeout.as_ref());
        let readable = PollFlags::IN | PollFlags::HUP | PollFlags::ERR;
        let ready = files[2..].iter().map(|file| file.revents().intersects(readable)).collect();
        if !files[0].revents().is_empty() {
            let _ = rustix::io::read(&self.shared.wakeup, &mut [0; 8]);
        }
        ready
    }

    /// Reads what has arrived and begins to answer.
    fn serve(&mut self, ready: &[bool], now: Instant) {
        let mut ready = ready.iter();
        for mut connection in std::mem::take(&mut self.connections) {
            let asked = match ready.next() {
                Some(true) => connection.receive(&self.shared.hosts, now),
                _ => Ok(None),
            };
            match asked {
                Ok(Some(parsed)) => self.answer(&mut connection, parsed, now),
                Ok(None) => {}
                // A browser may close its connection at any time.
                Err(_) => continue,
            }
            self.connections.push(connection);
        }
    }

    fn answer(&mut self, connection: &mut Connection, parsed: Parsed, now: Instant) {
        match parsed {
            Parsed::Partial => {}
            Parsed::Refused(status, words) => connection.answer(status, PLAIN, words.into(), now),
            Parsed::Request(Target::Page) => {
                self.make_room(ConnectionKind::Answer, MAX_ANSWERS);
                connection.answer(Status::Ok, HTML, self.page(now), now);
            }
            Parsed::Request(Target::Events) if self.count(ConnectionKind::Stream) >= MAX_STREAMS => {
                connection.answer(Status::Busy, PLAIN, "Too many browsers watch this run.\n".into(), now);
            }
            Parsed::Request(Target::Events) => {
                connection.begin_stream(now);
                if let Some(last_message) = &*lock(&self.shared.last_message) {
                    connection.conclude(last_message);
                }
            }
        }
    }

    /// The current page, or one that is at most [`PAGE_LIFETIME`] old.
    fn page(&mut self, now: Instant) -> Text {
        match &self.page {
            Some((made, page)) if now.saturating_duration_since(*made) < PAGE_LIFETIME => page.clone(),
            _ => {
                let page: Text = self.shared.page().into();
                self.page = Some((now, page.clone()));
                page
            }
        }
    }

    /// Passes what is in the outbox to all streams.
    fn pass_on(&mut self) {
        let mut outbox = lock(&self.shared.outbox);
        let messages = std::mem::take(&mut outbox.messages);
        let last_message = std::mem::take(&mut outbox.ends).then(|| lock(&self.shared.last_message).clone()).flatten();
        drop(outbox);
        for connection in self.connections.iter_mut().filter(|connection| connection.kind() == ConnectionKind::Stream) {
            messages.iter().for_each(|message| connection.push(message));
            last_message.iter().for_each(|message| connection.conclude(message));
        }
    }

    fn accept(&mut self, now: Instant) {
        if self.rest_until.is_some() {
            return;
        }
        // At most so many at once, so that a flood of new connections does not delay those that are being served.
        for _ in 0..MAX_WAITING {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    self.make_room(ConnectionKind::Waiting, MAX_WAITING);
                    self.connections.extend(Connection::new(stream, now).ok());
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                Err(_) => {
                    self.rest_until = Some(now + CHECK_INTERVAL);
                    return;
                }
            }
        }
    }

    /// Closes the oldest connection of this kind if there are already `most`.
    fn make_room(&mut self, kind: ConnectionKind, most: usize) {
        if self.count(kind) < most {
            return;
        }
        let alike = self.connections.iter().enumerate().filter(|(_, connection)| connection.kind() == kind);
        if let Some((oldest, _)) = alike.min_by_key(|(_, connection)| connection.since()) {
            self.connections.swap_remove(oldest);
        }
    }

    fn count(&self, kind: ConnectionKind) -> usize {
        self.connections.iter().filter(|connection| connection.kind() == kind).count()
    }

    /// Publishes how many streams there are, and whether there ever was one.
    fn report(&self) {
        self.shared.open.store(self.count(ConnectionKind::Stream), SeqCst);
        if self.connections.iter().any(Connection::has_begun_stream) {
            self.shared.visited.store(true, SeqCst);
        }
    }
}

fn timespec(time: Duration) -> Timespec {
    Timespec { tv_sec: time.as_secs() as i64, tv_nsec: i64::from(time.subsec_nanos()) }
}
