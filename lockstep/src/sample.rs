//! The header that every sample carries.

use serde::{Deserialize, Serialize};

use crate::Period;

/// Largest number of words of a sample.
pub const MAX_WORDS: usize = 512;

/// Bytes of a [`Header`].
pub const HEADER_BYTES: usize = 24;

/// Why a sample is as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u32)]
pub enum Status {
    /// Computed in this step from inputs of this step.
    Fresh = 0,
    /// Not computed in this step: the participant runs at a lower rate and its last sample stands.
    Held = 1,
    /// Not computed at all any more: the participant failed and its last sample stands in for it.
    Stale = 2,
}

/// The first 24 bytes of every sample; the fields of its [`Layout`](crate::Layout) follow.
///
/// Laid out as CDR lays out `builtin_interfaces/Time stamp, uint64 step, uint32 agent, uint32 status`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Header {
    /// Whole seconds of simulated time.
    pub sec: i32,
    /// Nanoseconds within the second.
    pub nanosec: u32,
    /// The step that computed the sample.
    pub step: u64,
    /// Agent number, from 1.
    pub agent: u32,
    /// A [`Status`] as number.
    pub status: u32,
}

impl Header {
    /// The header of a sample that `agent` (from 1) publishes at `step` of a run whose step takes `period`.
    pub fn new(step: u64, period: impl Into<Period>, agent: u32, status: Status) -> Self {
        let time_ns = period.into().time_ns(step);
        Self {
            sec: (time_ns / 1_000_000_000) as i32,
            nanosec: (time_ns % 1_000_000_000) as u32,
            step,
            agent,
            status: status as u32,
        }
    }

    /// Simulated time in nanoseconds.
    pub fn time_ns(&self) -> u64 {
        self.sec as u64 * 1_000_000_000 + u64::from(self.nanosec)
    }

    /// The header as it stands in a log, little-endian.
    pub fn to_bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        bytes[0..4].copy_from_slice(&self.sec.to_le_bytes());
        bytes[4..8].copy_from_slice(&self.nanosec.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.step.to_le_bytes());
        bytes[16..20].copy_from_slice(&self.agent.to_le_bytes());
        bytes[20..24].copy_from_slice(&self.status.to_le_bytes());
        bytes
    }

    /// Reads what [`Header::to_bytes`] wrote; `None` if there are fewer than [`HEADER_BYTES`] bytes.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        Some(Self {
            sec: word(0)? as i32,
            nanosec: word(4)?,
            step: u64::from(word(8)?) | u64::from(word(12)?) << 32,
            agent: word(16)?,
            status: word(20)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_the_memory_of_the_struct() {
        assert_eq!(size_of::<Header>(), HEADER_BYTES);
        let header = Header::new(12_345, 1_000_000, 3, Status::Held);
        assert_eq!((header.sec, header.nanosec), (12, 345_000_000));
        assert_eq!(Header::from_bytes(&header.to_bytes()), Some(header));
        assert_eq!(Header::from_bytes(&[0; 23]), None);
    }
}
