//! One browser: a state that never waits.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::Instant;

use rustix::event::PollFlags;

use super::limits::{ANSWER, BACKLOG, LINGER, MOST_HEAD, PULSE, REQUEST, STALL};
use super::request::{Parsed, Status, parse};

/// Text that is sent to several browsers.
pub(super) type Text = Arc<str>;

/// A connection, and what it is busy with.
pub(super) struct Connection {
    stream: TcpStream,
    state: State,
    /// When the state began.
    since: Instant,
    /// When anything was last sent or taken.
    moved: Instant,
}

enum State {
    /// The head of a request is coming.
    Request(Vec<u8>),
    /// An answer is being sent: its pieces, and how much of the first is sent.
    Answer(VecDeque<Text>, usize),
    /// Frames are being sent as they come; the same. `begun`: the head is sent; `last`: nothing comes after these.
    Stream { pieces: VecDeque<Text>, sent: usize, begun: bool, last: bool },
    /// All is sent; what still comes is thrown away, so that the browser gets to read the answer. Whether it was a stream.
    Linger { streamed: bool },
}

/// What a connection takes of the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Load {
    Waiting,
    Answer,
    Stream,
}

impl Connection {
    /// Of a browser that has just come.
    ///
    /// # Errors
    /// What the operating system says.
    pub(super) fn new(stream: TcpStream, now: Instant) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, state: State::Request(Vec::new()), since: now, moved: now })
    }

    pub(super) fn stream(&self) -> &TcpStream {
        &self.stream
    }

    /// When it began what it is busy with.
    pub(super) fn since(&self) -> Instant {
        self.since
    }

    pub(super) fn load(&self) -> Load {
        match self.state {
            State::Request(_) | State::Linger { .. } => Load::Waiting,
            State::Answer(..) => Load::Answer,
            State::Stream { .. } => Load::Stream,
        }
    }

    /// What it waits for.
    pub(super) fn interest(&self) -> PollFlags {
        match &self.state {
            State::Request(_) | State::Linger { .. } => PollFlags::IN,
            State::Answer(..) => PollFlags::OUT,
            State::Stream { pieces, .. } if pieces.is_empty() => PollFlags::IN,
            State::Stream { .. } => PollFlags::IN | PollFlags::OUT,
        }
    }

    /// Takes in what has come. `None`: nothing to be done about it; else the request, whole or refused.
    ///
    /// # Errors
    /// The connection is of no use any more.
    pub(super) fn receive(&mut self, hosts: &[String], now: Instant) -> io::Result<Option<Parsed>> {
        let mut bytes = [0; MOST_HEAD];
        let count = match self.stream.read(&mut bytes) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => count,
            Err(error) if is_passing(&error) => return Ok(None),
            Err(error) => return Err(error),
        };
        let State::Request(head) = &mut self.state else { return Ok(None) };
        let room = MOST_HEAD - head.len();
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

    /// Adds a message to a stream; if too many wait already, only the newest is kept.
    pub(super) fn push(&mut self, message: &Text) {
        let State::Stream { pieces, sent, begun, last: false } = &mut self.state else { return };
        if pieces.len() >= BACKLOG {
            // One that has been begun must be ended.
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

    /// Sends as much as the browser takes.
    ///
    /// # Errors
    /// The connection is of no use any more.
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

    /// Whether this is a stream whose browser takes what is sent to it.
    pub(super) fn has_begun_stream(&self) -> bool {
        matches!(&self.state, State::Stream { begun: true, .. } | State::Linger { streamed: true })
    }

    /// Whether it took too long. A silent stream is given a comment, so that a browser that has gone is found.
    pub(super) fn is_overdue(&mut self, now: Instant) -> bool {
        let (age, still) = (now.saturating_duration_since(self.since), now.saturating_duration_since(self.moved));
        match &mut self.state {
            State::Request(_) => age > REQUEST,
            State::Answer(..) => age > ANSWER || still > STALL,
            State::Linger { .. } => age > LINGER,
            State::Stream { pieces, .. } if pieces.is_empty() => {
                if still > PULSE {
                    pieces.push_back(":\n\n".into());
                    // The comment has as much time as any message.
                    self.moved = now;
                }
                false
            }
            State::Stream { .. } => still > STALL,
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
