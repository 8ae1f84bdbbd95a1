//! The clock of the counters: cheap enough to be read around every step, the same on all cores.

use std::time::{Duration, Instant};

/// The clock's reading now, in units of its own; see [`Rate`].
#[cfg(target_arch = "x86_64")]
pub(crate) fn now() -> u64 {
    // SAFETY: every x86-64 processor has this counter, and reading it has no other effect.
    unsafe { core::arch::x86_64::_rdtsc() }
}

/// The clock's reading now, in units of its own; see [`Rate`].
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn now() -> u64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

/// How long a tick is, measured from its creation to its use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rate {
    ticks: u64,
    instant: Instant,
}

impl Rate {
    pub(crate) fn start() -> Self {
        Self { ticks: now(), instant: Instant::now() }
    }

    /// Seconds per tick. The longer since the start, the more exact.
    pub(crate) fn seconds_per_tick(&self) -> f64 {
        let ticks = now().saturating_sub(self.ticks).max(1);
        self.instant.elapsed().as_secs_f64() / ticks as f64
    }

    /// A time as a number of ticks.
    pub(crate) fn ticks(&self, time: Duration) -> u64 {
        (time.as_secs_f64() / self.seconds_per_tick()) as u64
    }

    /// A number of ticks as time.
    pub(crate) fn duration(&self, ticks: u64) -> Duration {
        lockstep::duration((ticks as f64 * self.seconds_per_tick()).clamp(0.0, 1e9))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_time() {
        let rate = Rate::start();
        let (ticks, start) = (now(), Instant::now());
        std::thread::sleep(Duration::from_millis(20));
        let (ticks, elapsed) = (now() - ticks, start.elapsed());
        let measured = rate.duration(ticks).as_secs_f64();
        assert!((measured / elapsed.as_secs_f64() - 1.0).abs() < 0.2, "{measured} s for {elapsed:?}");
    }
}
