//! Making a run stumble, to show that nothing comes out differently.

use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::{self, JoinHandle};

use formation::math::SplitMix64;
use lockstep::WorkerPlan;
use rustix::process::{Pid, setpriority_process};

/// Environment variable with which a worker delays itself at random; see the crate `lockstep`.
const JITTER: &str = "PHALANX_JITTER";

/// What is done to the processes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stress {
    /// Decides on delays, order and priorities.
    pub seed: u64,
}

impl Stress {
    /// Starts the processes in another order, each with its participants in another order.
    pub fn shuffle(&self, workers: &mut [WorkerPlan]) {
        let mut random = SplitMix64::new(self.seed);
        workers.iter_mut().for_each(|worker| shuffle(&mut worker.nodes, &mut random));
        shuffle(workers, &mut random);
    }

    /// Makes a worker delay itself at random.
    pub fn disturb(&self, command: &mut Command) {
        command.env(JITTER, self.seed.to_string());
    }

    /// Lowers the priority of every second worker.
    pub fn set_priority(&self, worker: usize, pid: u32) {
        if (worker as u64 ^ self.seed) & 1 == 0 {
            // A worker that keeps its priority is only less disturbed.
            let _ = setpriority_process(Pid::from_raw(pid as i32), 10);
        }
    }
}

fn shuffle<T>(items: &mut [T], random: &mut SplitMix64) {
    for end in (1..items.len()).rev() {
        items.swap(end, (random.next_bits() % (end as u64 + 1)) as usize);
    }
}

/// Threads that do nothing, as hard as they can, until this is dropped.
pub struct Busy {
    end: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Busy {
    /// Starts `count` of them.
    pub fn start(count: usize) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let spin = || {
            let end = end.clone();
            thread::spawn(move || {
                while !end.load(Relaxed) {
                    std::hint::spin_loop();
                }
            })
        };
        let threads = (0..count).map(|_| spin()).collect();
        Self { end, threads }
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.end.store(true, Relaxed);
        for thread in self.threads.drain(..) {
            // They cannot panic.
            let _ = thread.join();
        }
    }
}
