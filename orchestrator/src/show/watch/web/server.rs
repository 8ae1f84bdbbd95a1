//! The thread that serves all browsers: one poll over all of them, which nothing and nobody can hold up.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::connection::{Connection, Load, Text};
use super::limits::{FRESH, MOST_ANSWERS, MOST_STREAMS, MOST_WAITING, TICK};
use super::request::{Parsed, Status, Target};
use super::{Desk, lock};

const HTML: &str = "text/html";
const PLAIN: &str = "text/plain";

/// Serves the page; lives in its thread.
pub(super) struct Server {
    desk: Arc<Desk>,
    listener: TcpListener,
    connections: Vec<Connection>,
    /// The newest page, and when it was made.
    page: Option<(Instant, Text)>,
    /// Nothing is accepted before: there were no descriptors left.
    rest_until: Option<Instant>,
}

impl Server {
    /// Serves on a listener.
    ///
    /// # Errors
    /// What the operating system says.
    pub(super) fn new(desk: Arc<Desk>, listener: TcpListener) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self { desk, listener, connections: Vec::new(), page: None, rest_until: None })
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

    /// Waits until something happens, or for a look at the limits; which connections have something to read.
    fn wait(&self) -> Vec<bool> {
        let resting = self.rest_until.is_some();
        let interest = if resting { PollFlags::empty() } else { PollFlags::IN };
        let mut files = vec![PollFd::new(&self.desk.bell, PollFlags::IN), PollFd::new(&self.listener, interest)];
        files.extend(self.connections.iter().map(|connection| PollFd::new(connection.stream(), connection.interest())));
        let timeout = (resting || !self.connections.is_empty()).then(|| timespec(TICK));
        // Interrupted by a signal: the next round is as good.
        let _ = poll(&mut files, timeout.as_ref());
        let readable = PollFlags::IN | PollFlags::HUP | PollFlags::ERR;
        let ready = files[2..].iter().map(|file| file.revents().intersects(readable)).collect();
        if !files[0].revents().is_empty() {
            let _ = rustix::io::read(&self.desk.bell, &mut [0; 8]);
        }
        ready
    }

    /// Takes in what has come, and begins to answer.
    fn serve(&mut self, ready: &[bool], now: Instant) {
        let mut ready = ready.iter();
        for mut connection in std::mem::take(&mut self.connections) {
            let asked = match ready.next() {
                Some(true) => connection.receive(&self.desk.hosts, now),
                _ => Ok(None),
            };
            match asked {
                Ok(Some(parsed)) => self.answer(&mut connection, parsed, now),
                Ok(None) => {}
                // A browser may go away at any time.
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
                self.make_room(Load::Answer, MOST_ANSWERS);
                connection.answer(Status::Ok, HTML, self.page(now), now);
            }
            Parsed::Request(Target::Events) if self.count(Load::Stream) >= MOST_STREAMS => {
                connection.answer(Status::Busy, PLAIN, "Too many browsers watch this run.\n".into(), now);
            }
            Parsed::Request(Target::Events) => {
                connection.begin_stream(now);
                if let Some(farewell) = &*lock(&self.desk.farewell) {
                    connection.conclude(farewell);
                }
            }
        }
    }

    /// The page of now, or one that is not much older.
    fn page(&mut self, now: Instant) -> Text {
        match &self.page {
            Some((made, page)) if now.saturating_duration_since(*made) < FRESH => page.clone(),
            _ => {
                let page: Text = self.desk.page().into();
                self.page = Some((now, page.clone()));
                page
            }
        }
    }

    /// Gives all streams what has been sent since the last time.
    fn pass_on(&mut self) {
        let mut outbox = lock(&self.desk.outbox);
        let messages = std::mem::take(&mut outbox.messages);
        let farewell = std::mem::take(&mut outbox.ends).then(|| lock(&self.desk.farewell).clone()).flatten();
        drop(outbox);
        for connection in self.connections.iter_mut().filter(|connection| connection.load() == Load::Stream) {
            messages.iter().for_each(|message| connection.push(message));
            farewell.iter().for_each(|message| connection.conclude(message));
        }
    }

    fn accept(&mut self, now: Instant) {
        if self.rest_until.is_some() {
            return;
        }
        // So many at once, so that those that are there have their turn, too.
        for _ in 0..MOST_WAITING {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    self.make_room(Load::Waiting, MOST_WAITING);
                    self.connections.extend(Connection::new(stream, now).ok());
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                Err(_) => {
                    self.rest_until = Some(now + TICK);
                    return;
                }
            }
        }
    }

    /// Closes the oldest connection of this kind if there are as many as there may be.
    fn make_room(&mut self, load: Load, most: usize) {
        if self.count(load) < most {
            return;
        }
        let alike = self.connections.iter().enumerate().filter(|(_, connection)| connection.load() == load);
        if let Some((oldest, _)) = alike.min_by_key(|(_, connection)| connection.since()) {
            self.connections.swap_remove(oldest);
        }
    }

    fn count(&self, load: Load) -> usize {
        self.connections.iter().filter(|connection| connection.load() == load).count()
    }

    /// Tells the rest of the program how many streams there are, and whether there ever was one.
    fn report(&self) {
        self.desk.open.store(self.count(Load::Stream), SeqCst);
        if self.connections.iter().any(Connection::has_begun_stream) {
            self.desk.visited.store(true, SeqCst);
        }
    }
}

fn timespec(time: Duration) -> Timespec {
    Timespec { tv_sec: time.as_secs() as i64, tv_nsec: i64::from(time.subsec_nanos()) }
}
