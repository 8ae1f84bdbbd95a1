//! One client of the control socket: how far its request and its answer are. Nothing here waits.

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Instant;

use rustix::event::PollFlags;

use super::{PATIENCE, SWAP_PATIENCE};
use crate::run::control::message::Answer;

/// Longest request, bytes.
const LONGEST_LINE: usize = 8192;

/// A connection, from its first byte to its last.
pub(super) struct Client {
    pub(super) stream: UnixStream,
    /// Clients are numbered in the order in which they came.
    pub(super) number: u64,
    /// When its connection is closed, unless something happens before.
    pub(super) deadline: Instant,
    state: State,
}

enum State {
    /// Its request is not complete.
    Asking(Vec<u8>),
    /// It has asked for a swap.
    Waiting,
    /// Its answer is being sent, from here on.
    Reading(Vec<u8>, usize),
}

/// What has become of a client.
pub(super) enum Step {
    /// There is more to come.
    Pending,
    /// It has asked for this.
    Request(String),
    /// It has its answer, or has gone.
    Over,
}

impl Client {
    pub(super) fn new(stream: UnixStream, number: u64) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self { stream, number, deadline: Instant::now() + PATIENCE, state: State::Asking(Vec::new()) })
    }

    /// What it is to be woken for; that it has gone is always noticed.
    pub(super) fn interest(&self) -> PollFlags {
        match &self.state {
            State::Asking(_) => PollFlags::IN,
            State::Waiting => PollFlags::empty(),
            State::Reading(..) => PollFlags::OUT,
        }
    }

    /// Whether it has asked for something that takes its time.
    pub(super) fn is_waiting(&self) -> bool {
        matches!(self.state, State::Waiting)
    }

    /// Its answer comes when the swap is done.
    pub(super) fn wait_for_swap(&mut self) {
        (self.state, self.deadline) = (State::Waiting, Instant::now() + SWAP_PATIENCE);
    }

    /// Sends an answer, as far as there is room for it; `false` if it was sent, or cannot be.
    pub(super) fn answer(&mut self, answer: &Answer) -> bool {
        let error = |error: serde_json::Error| format!("{{\"error\": \"{error}\"}}");
        let text = serde_json::to_string(answer).unwrap_or_else(error) + "\n";
        (self.state, self.deadline) = (State::Reading(text.into_bytes(), 0), Instant::now() + PATIENCE);
        matches!(self.proceed(), Step::Pending)
    }

    /// Reads what is there of the request, or sends what there is room for of the answer.
    pub(super) fn proceed(&mut self) -> Step {
        let result = match &mut self.state {
            State::Asking(line) => read(&mut self.stream, line),
            // It woke the server although nothing is expected from it: it has hung up.
            State::Waiting => Ok(Step::Over),
            State::Reading(bytes, sent) => write(&mut self.stream, bytes, sent),
        };
        match result {
            Ok(step) => step,
            Err(error) if [ErrorKind::WouldBlock, ErrorKind::Interrupted].contains(&error.kind()) => Step::Pending,
            Err(_) => Step::Over,
        }
    }
}

/// Reads once, so that a client that sends without an end does not block the server.
fn read(stream: &mut UnixStream, line: &mut Vec<u8>) -> io::Result<Step> {
    let mut bytes = [0; LONGEST_LINE];
    let count = stream.read(&mut bytes[..LONGEST_LINE - line.len()])?;
    let begin = line.len();
    line.extend_from_slice(&bytes[..count]);
    let end = line[begin..].iter().position(|&byte| byte == b'\n').map(|place| begin + place);
    match end {
        // One that ends without a line break is complete, too.
        None if count == 0 && line.is_empty() => Ok(Step::Over),
        None if count > 0 && line.len() < LONGEST_LINE => Ok(Step::Pending),
        // One that is too long is not understood, which is what its sender learns.
        _ => Ok(Step::Request(String::from_utf8_lossy(&line[..end.unwrap_or(line.len())]).into_owned())),
    }
}

fn write(stream: &mut UnixStream, bytes: &[u8], sent: &mut usize) -> io::Result<Step> {
    while *sent < bytes.len() {
        *sent += stream.write(&bytes[*sent..])?;
    }
    Ok(Step::Over)
}
