//! Delays at random, to show that a run does not depend on which participant is quick and which is slow.

use std::env;
use std::thread;
use std::time::{Duration, Instant};

/// Environment variable with the seed of the delays; there are none without it.
const JITTER: &str = "PHALANX_JITTER";
/// One run in so many is delayed ...
const ONE_IN: u64 = 16;
/// ... by less than this, in microseconds.
const LONGEST: u64 = 400;

/// The delays of one worker.
pub(super) struct Jitter {
    state: u64,
}

impl Jitter {
    pub(super) fn from_environment(worker: usize) -> Option<Self> {
        let seed: u64 = env::var(JITTER).ok()?.parse().ok()?;
        Some(Self { state: seed ^ (worker as u64 + 1).wrapping_mul(0xd134_2543_de82_ef95) })
    }

    /// Nothing, a sleep or a while of hard work.
    pub(super) fn delay(&mut self) {
        let random = self.next();
        if !random.is_multiple_of(ONE_IN) {
            return;
        }
        let delay = Duration::from_micros((random >> 8) % LONGEST);
        if random & 0x10 != 0 {
            thread::sleep(delay);
        } else {
            let start = Instant::now();
            while start.elapsed() < delay {
                std::hint::spin_loop();
            }
        }
    }

    /// SplitMix64.
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut value = self.state;
        value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ (value >> 31)
    }
}
