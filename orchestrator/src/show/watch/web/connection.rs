//! One browser: a state machine that never blocks.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::Instant;

use rustix::event::PollFlags;

use super::limits::{
    ANSWER_TIMEOUT, KEEP_ALIVE, LINGER_TIMEOUT, MAX_BACKLOG, MAX_HEAD_BYTES, REQUEST_TIMEOUT, STALL_TIMEOUT,
};
use super::request::{Parsed, Status, parse};

/// Text that is sent to several browsers.
pub(super) type Text = Arc<str>;

/// A connection and its state.
pub(super) struct Connection {
    stream: TcpStream,
    state: State,
    /// When the state began.
    since: Instant,
    /// When a byte was last sent or received.
    moved: Instant,
}

enum State {
    /// The head of a request is being received.
    Request(Vec<u8>),
    /// An answer is being sent: its pieces, and how many bytes of the first are sent.
    Answer(VecDeque<Text>, usize),
    /// Events are being sent: the same. `begun`: the head is sent; `last`: no event follows these.
    Stream { pieces: VecDeque<Text>, sent: usize, begun: bool, last: bool },
    /// All is sent. What still arrives is read and dropped: closing a socket with unread input resets the connection, and the
    /// browser might lose the answer.
    Linger { streamed: bool },
}

/// What a connection counts as, for the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ConnectionKind {
    Waiting,
    Answer,
    Stream,
}

impl Connection {
    /// A new connection.
    ///
    /// # Errors
    /// What the operating system reports.
    pub(super) fn new(stream: TcpStream, now: Instant) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, state: State::Request(Vec::new()), since: now, moved: now })
    }

    pub(super) fn stream(&self) -> &TcpStream {
        &self.stream
    }

    /// When its state began.
    pub(super) fn since(&self) -> Instant {
        self.since
    }

    pub(super) fn kind(&self) -> ConnectionKind {
        match self.state {
            State::Request(_) | State::Linger { .. } => ConnectionKind::Waiting,
            State::Answer(..) => ConnectionKind::Answer,
            State::Stream { .. } => ConnectionKind::Stream,
        }
    }

    /// The events that it waits for.
    pub(super) fn interest(&self) -> PollFlags {
        match &self.state {
            State::Request(_) | State::Linger { .. } => PollFlags::IN,
            State::Answer(..) => PollFlags::OUT,
            State::Stream { pieces, .. } if pieces.is_empty() => PollFlags::IN,
            State::Stream { .. } => PollFlags::IN | PollFlags::OUT,
        }
    }

    /// Reads what has arrived. Returns a request, complete or refused, or `None`.
    ///
    /// # Errors
    /// The connection is closed or broken.
    pub(super) fn receive(&mut self, hosts: &[String], now: Instant) -> io::Result<Option<Parsed>> {
        let mut bytes = [0; MAX_HEAD_BYTES];
        let count = match self.stream.read(&mut bytes) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => count,
            Err(error) if is_passing(&error) => return Ok(None),
            Err(error) => return Err(error),
        };
        let State::Request(head) = &mut self.state else { return Ok(None) };
        let room = MAX_HEAD_BYTES - head.len();
        head.extend_from_slice(&bytes[..count.min(room)]);
        self.moved = now;
        match parse(head, hosts) {
            Parsed::Partial => Ok(None),
            parsed => Ok(Some(parsed)),
        }
    }

    /// Begins an answer of these pieces.
    pub(super) fn answer(&mut self, status: Status, kind: &str, body: Text, now: Instant) {
        let head = format!(
            "HTTP/1.1 {}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
             X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
            status.line(),
            body.len()
        );
        self.enter(State::Answer(VecDeque::from([head.into(), body]), 0), now);
    }

    /// Begins a stream of frames.
    pub(super) fn begin_stream(&mut self, now: Instant) {
        let head = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
        self.enter(State::Stream { pieces: VecDeque::from([head.into()]), sent: 0, begun: false, last: false }, now);
    }

    /// Adds a message to a stream. If [`MAX_BACKLOG`] messages wait already, they are dropped.
    pub(super) fn push(&mut self, message: &Text) {
        let State::Stream { pieces, sent, begun, last: false } = &mut self.state else { return };
        if pieces.len() >= MAX_BACKLOG {
            // A message of which a part is sent has to be completed.
            pieces.truncate(usize::from(*sent > 0 || !*begun));
        }
        pieces.push_back(message.clone());
    }

    /// Adds the last message to a stream.
    pub(super) fn conclude(&mut self, message: &Text) {
        self.push(message);
        if let State::Stream { last, .. } = &mut self.state {
            *last = true;
        }
    }

    /// Sends as much as the socket accepts.
    ///
    /// # Errors
    /// The connection is closed or broken.
    pub(super) fn send(&mut self, now: Instant) -> io::Result<()> {
        let (State::Answer(pieces, sent) | State::Stream { pieces, sent, .. }) = &mut self.state else { return Ok(()) };
        while let Some(piece) = pieces.front() {
            match self.stream.write(&piece.as_bytes()[*sent..]) {
                Ok(count) => {
                    self.moved = now;
                    *sent += count;
                    if *sent == piece.len() {
                        (*sent, _) = (0, pieces.pop_front());
                    }
                }
                Err(error) if is_passing(&error) => return Ok(()),
                Err(error) => return Err(error),
            }
        }
        if let State::Stream { begun, last: false, .. } = &mut self.state {
            *begun = true;
            return Ok(());
        }
        self.stream.shutdown(Shutdown::Write)?;
        let streamed = matches!(self.state, State::Stream { .. });
        self.enter(State::Linger { streamed }, now);
        Ok(())
    }

    /// Whether this is a stream whose browser has received its beginning.
    pub(super) fn has_begun_stream(&self) -> bool {
        matches!(&self.state, State::Stream { begun: true, .. } | State::Linger { streamed: true })
    }

    /// Whether it exceeds a limit. A silent stream sends a comment, so that a closed connection is noticed.
    pub(super) fn is_overdue(&mut self, now: Instant) -> bool {
        let (age, still) = (now.saturating_duration_since(self.since), now.saturating_duration_since(self.moved));
        match &mut self.state {
            State::Request(_) => age > REQUEST_TIMEOUT,
            State::Answer(..) => age > ANSWER_TIMEOUT || still > STALL_TIMEOUT,
            State::Linger { .. } => age > LINGER_TIMEOUT,
            State::Stream { pieces, .. } if pieces.is_empty() => {
                if still > KEEP_ALIVE {
                    pieces.push_back(":\n\n".into());
                    // The comment has as much time as any message.
                    self.moved = now;
                }
                false
            }
            State::Stream { .. } => still > STALL_TIMEOUT,
        }
    }

    fn enter(&mut self, state: State, now: Instant) {
        (self.state, self.since, self.moved) = (state, now, now);
    }
}

/// Whether the operation may be tried again later.
fn is_passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
