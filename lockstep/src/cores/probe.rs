//! What it costs to wake somebody on this core and on another one.

use std::io;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::thread;
use std::time::{Duration, Instant};

use rustix::thread::futex;

use super::pin_to_core;

/// Longest time of a measurement: a loaded machine must not hold up a run.
const PATIENCE: Duration = Duration::from_millis(25);
/// Most round trips of a measurement.
const ROUNDS: usize = 400;
/// What the words show when the partner is to end.
const END: u32 = u32::MAX;

/// Median time from waking a thread on core `b` to its start, seen from core `a`: half of a round trip.
///
/// Takes 25 ms at most, and moves no thread of the caller.
///
/// # Errors
/// If a core is not allowed, or no thread can be started.
pub fn wake_up_time(a: usize, b: usize) -> io::Result<Duration> {
    let (ping, pong) = (AtomicU32::new(0), AtomicU32::new(0));
    let times = thread::scope(|scope| {
        thread::Builder::new().spawn_scoped(scope, || echo(b, &ping, &pong))?;
        let measurement = thread::Builder::new().spawn_scoped(scope, || {
            let times = pin_to_core(a).map(|()| round_trips(&ping, &pong));
            publish(&ping, END);
            times
        })?;
        measurement.join().unwrap_or_else(|_| Err(io::Error::other("the measurement panicked")))
    })?;
    let mut times = times;
    times.sort_unstable();
    times.get(times.len() / 2).map(|time| *time / 2).ok_or_else(|| io::ErrorKind::TimedOut.into())
}

fn round_trips(ping: &AtomicU32, pong: &AtomicU32) -> Vec<Duration> {
    let start = Instant::now();
    let mut times = Vec::with_capacity(ROUNDS);
    for round in 1..=ROUNDS as u32 {
        let before = Instant::now();
        publish(ping, round);
        if await_change(pong, round - 1) == END {
            break;
        }
        times.push(before.elapsed());
        if start.elapsed() > PATIENCE {
            break;
        }
    }
    times
}

fn echo(core: usize, ping: &AtomicU32, pong: &AtomicU32) {
    if pin_to_core(core).is_ok() {
        let mut last = 0;
        loop {
            last = match await_change(ping, last) {
                END => break,
                value => value,
            };
            publish(pong, last);
        }
    }
    publish(pong, END);
}

fn publish(word: &AtomicU32, value: u32) {
    word.store(value, SeqCst);
    let _ = futex::wake(word, futex::Flags::PRIVATE, 1);
}

fn await_change(word: &AtomicU32, old: u32) -> u32 {
    loop {
        let value = word.load(SeqCst);
        if value != old {
            return value;
        }
        let _ = futex::wait(word, futex::Flags::PRIVATE, old, None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allowed_cores;

    #[test]
    fn a_wake_up_takes_time() {
        let core = *allowed_cores().unwrap().last().unwrap();
        let time = wake_up_time(core, core).unwrap();
        assert!(time > Duration::ZERO && time < Duration::from_secs(1), "{time:?}");
        assert!(wake_up_time(core, 1023).is_err());
    }
}
