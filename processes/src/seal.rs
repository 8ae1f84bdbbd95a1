//! Seals of samples: numbers that only fit a sample as it was published.
//!
//! Every process of a run has the memory of all channels before it, and a stray pointer may write into any of it. The writer of
//! a channel seals what it publishes, and who fetches a sample compares. A seal is no signature: it finds mistakes, not
//! forgery.

use lockstep::{ChannelId, Header};

/// An odd number whose products have no pattern, so that bits spread upward; the rotations bring them down again.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// What the seals of a channel begin with: a sample that ends up in another channel does not fit there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SealKey(u64);

impl SealKey {
    /// That of the samples that process number `incarnation` of a worker publishes in a channel.
    pub(crate) fn of(channel: ChannelId, incarnation: u32) -> Self {
        let number = (channel.0 as u64 + 1) << 32 | u64::from(incarnation);
        Self(number.wrapping_mul(SPREAD).rotate_left(32))
    }

    /// The seal of a sample. A change of any one word changes it, and of several, but for one case in 2^64.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn seal(self, header: &Header, words: &[f64]) -> u64 {
        // Each step of a lane can be undone, and so can the sum of the lanes: no two states of one lane give the same seal.
        let spread = |lane: u64, word: u64| (lane ^ word).wrapping_mul(SPREAD).rotate_left(29);
        let stamp = u64::from(header.sec as u32) << 32 | u64::from(header.nanosec);
        let about = u64::from(header.agent) << 32 | u64::from(header.status);
        let mut even = spread(spread(self.0, stamp), about);
        let mut odd = spread(spread(!self.0, header.step), words.len() as u64);
        let (pairs, rest) = words.as_chunks::<2>();
        for [first, second] in pairs {
            (even, odd) = (spread(even, first.to_bits()), spread(odd, second.to_bits()));
        }
        if let [last] = rest {
            even = spread(even, last.to_bits());
        }
        spread(even, odd.rotate_left(32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lockstep::Status;

    #[test]
    fn every_bit_counts() {
        let (key, header) = (SealKey::of(ChannelId(3), 0), Header::new(7, 1_000_000, 2, Status::Fresh));
        for length in [0, 1, 4, 7, 13] {
            let words: Vec<f64> = (0..length).map(|word| word as f64 * 0.1).collect();
            let seal = key.seal(&header, &words);
            for bit in 0..64 * length {
                let mut changed = words.clone();
                changed[bit / 64] = f64::from_bits(changed[bit / 64].to_bits() ^ 1 << (bit % 64));
                assert_ne!(key.seal(&header, &changed), seal, "bit {bit} of {length} words");
            }
            for bit in 0..32 {
                let Header { sec, nanosec, step, agent, status } = header;
                let changed = [
                    Header { sec: sec ^ 1 << bit, ..header },
                    Header { nanosec: nanosec ^ 1 << bit, ..header },
                    Header { step: step ^ 1 << bit, ..header },
                    Header { agent: agent ^ 1 << bit, ..header },
                    Header { status: status ^ 1 << bit, ..header },
                ];
                assert!(changed.iter().all(|changed| key.seal(changed, &words) != seal), "bit {bit} of the header");
            }
            assert_ne!(SealKey::of(ChannelId(4), 0).seal(&header, &words), seal);
            assert_ne!(SealKey::of(ChannelId(3), 1).seal(&header, &words), seal);
        }
        assert_ne!(key.seal(&header, &[1.0, 2.0]), key.seal(&header, &[2.0, 1.0]));
        assert_ne!(key.seal(&header, &[0.0]), key.seal(&header, &[0.0, 0.0]));
        assert_ne!(key.seal(&header, &[0.0]), key.seal(&header, &[-0.0]));
    }
}
