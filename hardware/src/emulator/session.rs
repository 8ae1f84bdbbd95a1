//! One controller that has control, from its greeting to its end.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use super::Terms;
use super::body::Body;
use crate::frame::Frame;
use crate::link::{Link, TcpLink};
use crate::message::{Clock, Message};

/// A controller that says nothing for so long, in real time, is gone.
const SILENCE: Duration = Duration::from_secs(2);
/// More frames in a second are no controller's.
const MAX_RATE: u32 = 5000;

/// A connection.
pub(super) struct Session {
    pub(super) link: TcpLink,
    pub(super) peer: SocketAddr,
    /// What was agreed on; `None` before the greeting.
    terms: Option<Terms>,
    /// Number of the newest frame.
    sequence: u32,
    heard: Instant,
    /// Frames in this second of real time.
    rate: (Instant, u32),
}

impl Session {
    pub(super) fn new(link: TcpLink, peer: SocketAddr) -> Self {
        let now = Instant::now();
        Self { link, peer, terms: None, sequence: 0, heard: now, rate: (now, 0) }
    }

    /// Whether control was granted.
    pub(super) fn is_open(&self) -> bool {
        self.terms.is_some()
    }

    /// Takes in all that is there; an error says why the controller is to be regarded as gone.
    pub(super) fn hear(&mut self, body: &mut Body) -> Result<(), String> {
        while let Some(frame) = self.link.receive(Duration::ZERO).map_err(|error| error.to_string())? {
            self.heard = Instant::now();
            self.count()?;
            let message = Message::of(&frame).map_err(|error| error.to_string())?;
            match self.terms {
                None => self.greet(&frame, &message, body)?,
                Some(terms) => self.obey(&frame, &message, &terms, body)?,
            }
        }
        let may_be_silent = self.terms.is_some_and(|terms| terms.clock == Clock::Lockstep);
        if !may_be_silent && self.heard.elapsed() > SILENCE {
            return Err(format!("silent for {} s", SILENCE.as_secs()));
        }
        Ok(())
    }

    fn count(&mut self) -> Result<(), String> {
        let lockstep = self.terms.is_some_and(|terms| terms.clock == Clock::Lockstep);
        if self.rate.0.elapsed() > Duration::from_secs(1) {
            self.rate = (Instant::now(), 0);
        }
        self.rate.1 += 1;
        if !lockstep && self.rate.1 > MAX_RATE {
            return Err(format!("more than {MAX_RATE} frames in a second"));
        }
        Ok(())
    }

    fn greet(&mut self, frame: &Frame, message: &Message, body: &mut Body) -> Result<(), String> {
        let Message::Hello { body: number, inputs, period, clock, port } = *message else {
            return Err("its first frame is no greeting".into());
        };
        let mut terms = Terms { clock, period, poses: None, start: frame.stamp };
        if port != 0 {
            terms.poses = Some(SocketAddr::new(self.peer.ip(), port));
        }
        if let Err(reason) = body.agree(number, inputs, &terms) {
            let refusal = Message::Refused { reason: reason.clone() };
            self.link.send(&refusal.frame(0, 0)).map_err(|error| error.to_string())?;
            return Err(reason);
        }
        let welcome = Message::Welcome { body: body.number() };
        self.link.send(&welcome.frame(0, 0)).map_err(|error| error.to_string())?;
        (self.terms, self.sequence) = (Some(terms), frame.sequence);
        Ok(())
    }

    fn obey(&mut self, frame: &Frame, message: &Message, terms: &Terms, body: &mut Body) -> Result<(), String> {
        // A link that keeps the order gives consecutive numbers. One that does not may skip some, but an old command must
        // not replace a newer one.
        if frame.sequence.wrapping_sub(self.sequence) as i32 <= 0 {
            return Ok(());
        }
        self.sequence = frame.sequence;
        match message {
            Message::Command { count, inputs } => {
                if *count != Body::INPUTS {
                    return Err(format!("{count} inputs, expected {}", Body::INPUTS));
                }
                body.command(frame.stamp, [inputs[0], inputs[1], inputs[2]], terms)?;
                let answer = Message::Acknowledge { applies: true, frames: body.frames() };
                self.link.send(&answer.frame(frame.sequence, body.time(terms))).map_err(|error| error.to_string())
            }
            Message::Halt => {
                body.halt();
                Ok(())
            }
            _ => Err("a controller does not send this".into()),
        }
    }
}
