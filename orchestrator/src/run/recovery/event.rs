//! What has happened to the participants of a run, for its log.

use crate::log::{ExtraChannel, LogError, Recorder};

/// Where events are in the log; the channel is there only if anything has happened.
const TOPIC: &str = "/phalanx/events";
const TYPE: &str = "phalanx_msgs/msg/Event";
const DEFINITION: &str = "\
# What has happened to a participant.
builtin_interfaces/Time stamp
uint64 step
string participant
string text
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Events that are not written yet, and the channel for them.
#[derive(Default)]
pub(super) struct Events {
    pending: Vec<(String, String)>,
    channel: Option<ExtraChannel>,
}

impl Events {
    /// Something has happened to a participant.
    pub(super) fn push(&mut self, participant: &str, text: String) {
        self.pending.push((participant.into(), text));
    }

    /// Writes all events at `step`, which was recorded last.
    pub(super) fn write(&mut self, step: u64, period_ns: u64, recorder: &mut Recorder) -> Result<(), LogError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let channel = match self.channel {
            Some(channel) => channel,
            None => *self.channel.insert(recorder.add_channel(TOPIC, TYPE, DEFINITION)?),
        };
        for (participant, text) in self.pending.drain(..) {
            recorder.write(channel, step, &encode(step, step * period_ns, &participant, &text))?;
        }
        Ok(())
    }
}

/// The message as CDR, little-endian.
fn encode(step: u64, time_ns: u64, participant: &str, text: &str) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    bytes.extend_from_slice(&((time_ns / 1_000_000_000) as i32).to_le_bytes());
    bytes.extend_from_slice(&((time_ns % 1_000_000_000) as u32).to_le_bytes());
    bytes.extend_from_slice(&step.to_le_bytes());
    for string in [participant, text] {
        // Behind the four bytes of encapsulation, lengths stand at multiples of four.
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes.extend_from_slice(&(string.len() as u32 + 1).to_le_bytes());
        bytes.extend_from_slice(string.as_bytes());
        bytes.push(0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_aligned_and_end_with_zero() {
        let bytes = encode(3, 1_500_000_000, "plant", "x");
        assert_eq!(bytes[..20], [0, 1, 0, 0, 1, 0, 0, 0, 0, 0x65, 0xcd, 0x1d, 3, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[20..], *b"\x06\0\0\0plant\0\0\0\x02\0\0\0x\0");
    }
}
