//! What has happened to the participants of a run, for its log.

use lockstep::Period;

use recording::{Cdr, Durability, ExtraChannel, LogError, Recorder, own_type};

/// Where events are in the log; the channel is there only if anything has happened.
const TOPIC: &str = "/phalanx/events";
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
    pub(super) fn write(&mut self, step: u64, period: Period, recorder: &mut Recorder) -> Result<(), LogError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let channel = match self.channel {
            Some(channel) => channel,
            None => *self.channel.insert(recorder.add_channel(
                TOPIC,
                &own_type("Event", DEFINITION),
                DEFINITION,
                Durability::TransientLocal,
            )?),
        };
        for (participant, text) in self.pending.drain(..) {
            recorder.write(channel, step, encode(step, period.time_ns(step), &participant, &text).bytes())?;
        }
        Ok(())
    }
}

/// The message as CDR.
fn encode(step: u64, time_ns: u64, participant: &str, text: &str) -> Cdr {
    let mut cdr = Cdr::new();
    cdr.stamp(time_ns).u64(step).text(participant).text(text);
    cdr
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_aligned_and_end_with_zero() {
        let message = encode(3, 1_500_000_000, "plant", "x");
        let bytes = message.bytes();
        assert_eq!(bytes[..20], [0, 1, 0, 0, 1, 0, 0, 0, 0, 0x65, 0xcd, 0x1d, 3, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[20..], *b"\x06\0\0\0plant\0\0\0\x02\0\0\0x\0");
    }
}
