//! The words that change, and how the search keeps them: numbers are small here, so every word fits into a byte.

/// Words of arrivals of a phase, and core groups, that the search has.
pub(crate) const ARRIVAL_WORDS: usize = 2;
pub(crate) const GROUPS: usize = 2;
const PHASES: usize = 3;
/// All words that change.
pub(crate) const WORDS: usize = 7 + PHASES * (2 + ARRIVAL_WORDS) + GROUPS;

/// A word that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Name {
    Limit,
    Completed,
    WakeAt,
    CompletionClaim,
    Bell,
    /// What the conductor knows besides: whether the run is interrupted, and whether a worker is dead.
    Interrupted,
    Dead,
    Gate(usize),
    GateClaim(usize),
    Arrivals(usize, usize),
    Polled(usize),
}

impl Name {
    pub(crate) fn index(self) -> usize {
        match self {
            Self::Limit => 0,
            Self::Completed => 1,
            Self::WakeAt => 2,
            Self::CompletionClaim => 3,
            Self::Bell => 4,
            Self::Interrupted => 5,
            Self::Dead => 6,
            Self::Gate(phase) => 7 + phase,
            Self::GateClaim(phase) => 7 + PHASES + phase,
            Self::Arrivals(phase, word) => 7 + 2 * PHASES + ARRIVAL_WORDS * phase + word,
            Self::Polled(group) => 7 + (2 + ARRIVAL_WORDS) * PHASES + group,
        }
    }

    /// Where the upper part of a value begins: numbers here are small, so that two parts fit into a byte.
    fn upper(self) -> u32 {
        match self {
            Self::CompletionClaim | Self::GateClaim(_) => 16,
            Self::Gate(_) => 31,
            Self::Polled(_) => 32,
            _ => 4,
        }
    }

    pub(crate) fn pack(self, value: u64) -> u8 {
        let packed = (value >> self.upper()) << 4 | value & 0xF;
        let packed = packed as u8;
        assert_eq!(self.unpack(packed), value, "{self:?} is too large for the search");
        packed
    }

    pub(crate) fn unpack(self, packed: u8) -> u64 {
        u64::from(packed >> 4) << self.upper() | u64::from(packed & 0xF)
    }

    /// What ends every loop.
    pub(crate) fn last(self) -> u64 {
        if matches!(self, Self::Gate(_)) { self.unpack(0x10) } else { 0 }
    }
}
