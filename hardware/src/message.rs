//! What the payloads of the frames say. `f64` is IEEE 754, little-endian as everything.
//!
//! | kind        | payload                                                                                              |
//! |-------------|------------------------------------------------------------------------------------------------------|
//! | Hello       | `u32` body, `u32` inputs, `u64` ns between two commands, `u8` clock (0 wall, 1 lockstep), `u16` port |
//! | Welcome     | `u32` body                                                                                           |
//! | Refused     | reason in UTF-8                                                                                      |
//! | Command     | n x `f64` inputs, n = 1 to 4; the stamp is the instant from which on they hold                       |
//! | Acknowledge | `u8` 1: applies, 0: halted; `u32` number of the newest pose frame sent so far, plus 1                |
//! | Halt        | nothing                                                                                              |
//! | Pose        | `u32` body, `u8` 1: valid, 0: not seen; 3 x `f64` position in m; 3 x `f64` roll, pitch, yaw in rad   |
//!
//! The sequence number of an acknowledgement is that of its command. That of a pose is the number of the camera frame, and its
//! stamp the instant of the capture.

use crate::frame::{Frame, FrameError, Kind};

/// Most inputs of a robot.
pub const MAX_INPUTS: usize = 4;
/// Longest reason of a refusal, bytes.
const MAX_REASON: usize = 200;

/// Which clock the stamps are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Everybody's own; time passes by itself.
    Wall,
    /// Simulated time, which passes with the commands.
    Lockstep,
}

/// Content of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// Asks for control.
    Hello {
        /// Which robot is meant.
        body: u32,
        /// How many inputs its commands have.
        inputs: u32,
        /// Time between two commands, ns.
        period: u64,
        /// Which clock the stamps are of.
        clock: Clock,
        /// UDP port at which the host listens to poses; 0: the cameras know.
        port: u16,
    },
    /// Grants it.
    Welcome {
        /// Which robot this is.
        body: u32,
    },
    /// Refuses it.
    Refused {
        /// Why.
        reason: String,
    },
    /// The inputs from now on.
    Command {
        /// How many there are.
        count: usize,
        /// The inputs, in the units of the vehicle.
        inputs: [f64; MAX_INPUTS],
    },
    /// A command arrived.
    Acknowledge {
        /// Whether it applies; a robot that halted says no.
        applies: bool,
        /// Number of pose frames that were sent so far, by camera number: that of the newest plus 1.
        frames: u32,
    },
    /// Stop now.
    Halt,
    /// Where a body is.
    Pose(Pose),
}

/// What the cameras tell of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Which one.
    pub body: u32,
    /// Whether it was seen.
    pub valid: bool,
    /// x, y, z in m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw in rad.
    pub orientation: [f64; 3],
}

impl Message {
    /// The frame that carries it.
    pub fn frame(&self, sequence: u32, stamp: u64) -> Frame {
        let (kind, payload) = match self {
            Message::Hello { body, inputs, period, clock, port } => {
                let mut bytes = [body.to_le_bytes(), inputs.to_le_bytes()].concat();
                bytes.extend(period.to_le_bytes());
                bytes.push(u8::from(*clock == Clock::Lockstep));
                bytes.extend(port.to_le_bytes());
                (Kind::Hello, bytes)
            }
            Message::Welcome { body } => (Kind::Welcome, body.to_le_bytes().to_vec()),
            Message::Refused { reason } => {
                let end = (0..=MAX_REASON.min(reason.len())).rev().find(|&end| reason.is_char_boundary(end));
                (Kind::Refused, reason.as_bytes()[..end.unwrap_or(0)].to_vec())
            }
            Message::Command { count, inputs } => (Kind::Command, reals(&inputs[..*count])),
            Message::Acknowledge { applies, frames } => {
                (Kind::Acknowledge, [&[u8::from(*applies)][..], &frames.to_le_bytes()].concat())
            }
            Message::Halt => (Kind::Halt, Vec::new()),
            Message::Pose(Pose { body, valid, position, orientation }) => {
                let mut bytes = body.to_le_bytes().to_vec();
                bytes.push(u8::from(*valid));
                bytes.extend(reals(position));
                bytes.extend(reals(orientation));
                (Kind::Pose, bytes)
            }
        };
        Frame { kind, sequence, stamp, payload }
    }

    /// The message that a frame carries.
    ///
    /// # Errors
    /// [`FrameError`] if the payload is not as long as its kind demands, or holds what it must not.
    pub fn of(frame: &Frame) -> Result<Self, FrameError> {
        let mut fields = Fields(&frame.payload);
        let message = match frame.kind {
            Kind::Hello => Message::Hello {
                body: fields.whole()?,
                inputs: fields.whole()?,
                period: u64::from_le_bytes(fields.take()?),
                clock: if fields.flag("the clock is neither 0 nor 1")? { Clock::Lockstep } else { Clock::Wall },
                port: u16::from_le_bytes(fields.take()?),
            },
            Kind::Welcome => Message::Welcome { body: fields.whole()? },
            Kind::Refused => {
                let bytes = std::mem::take(&mut fields.0);
                let text = std::str::from_utf8(bytes).map_err(|_| FrameError::Content("the reason is not UTF-8"))?;
                Message::Refused { reason: text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect() }
            }
            Kind::Command => {
                let length = frame.payload.len();
                let count = length / 8;
                if !length.is_multiple_of(8) || !(1..=MAX_INPUTS).contains(&count) {
                    return Err(FrameError::Length(length));
                }
                let mut inputs = [0.0; MAX_INPUTS];
                for input in &mut inputs[..count] {
                    *input = fields.real()?;
                }
                Message::Command { count, inputs }
            }
            Kind::Acknowledge => {
                Message::Acknowledge { applies: fields.flag("`applies` is neither 0 nor 1")?, frames: fields.whole()? }
            }
            Kind::Halt => Message::Halt,
            Kind::Pose => Message::Pose(Pose {
                body: fields.whole()?,
                valid: fields.flag("`valid` is neither 0 nor 1")?,
                position: fields.three()?,
                orientation: fields.three()?,
            }),
        };
        if fields.0.is_empty() { Ok(message) } else { Err(FrameError::Length(frame.payload.len())) }
    }
}

fn reals(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// What is left of a payload.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], FrameError> {
        let (field, rest) = self.0.split_first_chunk::<N>().ok_or(FrameError::Length(self.0.len()))?;
        self.0 = rest;
        Ok(*field)
    }

    fn whole(&mut self) -> Result<u32, FrameError> {
        self.take().map(u32::from_le_bytes)
    }

    fn flag(&mut self, complaint: &'static str) -> Result<bool, FrameError> {
        match self.take()? {
            [0] => Ok(false),
            [1] => Ok(true),
            _ => Err(FrameError::Content(complaint)),
        }
    }

    fn real(&mut self) -> Result<f64, FrameError> {
        let value = f64::from_le_bytes(self.take()?);
        if value.is_finite() { Ok(value) } else { Err(FrameError::Content("a number that is not finite")) }
    }

    fn three(&mut self) -> Result<[f64; 3], FrameError> {
        Ok([self.real()?, self.real()?, self.real()?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn messages() -> impl Strategy<Value = Message> {
        let real = || -1e9..1e9f64;
        let three = || [real(), real(), real()];
        prop_oneof![
            (any::<u32>(), any::<u32>(), any::<u64>(), any::<bool>(), any::<u16>()).prop_map(
                |(body, inputs, period, lockstep, port)| {
                    let clock = if lockstep { Clock::Lockstep } else { Clock::Wall };
                    Message::Hello { body, inputs, period, clock, port }
                }
            ),
            any::<u32>().prop_map(|body| Message::Welcome { body }),
            "[a-zäö ]{0,60}".prop_map(|reason| Message::Refused { reason }),
            prop::collection::vec(real(), 1..=MAX_INPUTS).prop_map(|values| {
                let mut inputs = [0.0; MAX_INPUTS];
                inputs[..values.len()].copy_from_slice(&values);
                Message::Command { count: values.len(), inputs }
            }),
            (any::<bool>(), any::<u32>()).prop_map(|(applies, frames)| Message::Acknowledge { applies, frames }),
            Just(Message::Halt),
            (any::<u32>(), any::<bool>(), three(), three()).prop_map(|(body, valid, position, orientation)| {
                Message::Pose(Pose { body, valid, position, orientation })
            }),
        ]
    }

    proptest! {
        #[test]
        fn what_is_sent_is_received(message in messages(), sequence in any::<u32>(), stamp in any::<u64>()) {
            let frame = Frame::decode(&message.frame(sequence, stamp).encode()).unwrap();
            prop_assert_eq!((frame.sequence, frame.stamp), (sequence, stamp));
            prop_assert_eq!(Message::of(&frame).unwrap(), message);
        }

        #[test]
        fn any_payload_is_read_without_a_panic(
            kind in prop::sample::select(Kind::ALL.to_vec()),
            payload in prop::collection::vec(any::<u8>(), 0..=256),
        ) {
            let _ = Message::of(&Frame { kind, sequence: 0, stamp: 0, payload });
        }

        #[test]
        fn a_payload_of_another_length_is_refused(message in messages(), more in 1usize..8) {
            prop_assume!(!matches!(message, Message::Refused { .. }));
            let mut frame = message.frame(1, 1);
            frame.payload.extend(vec![0; more]);
            prop_assert!(Message::of(&frame).is_err());
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let command = Message::Command { count: 1, inputs: [f64::NAN, 0.0, 0.0, 0.0] };
        assert_eq!(Message::of(&command.frame(0, 0)), Err(FrameError::Content("a number that is not finite")));
    }
}
