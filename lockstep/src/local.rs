//! All participants in one process: the same order, the same bits, no system call in a step.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use crate::execute::{Member, stamp};
use crate::{Fault, LoopError, Network, Participant, Period, Step, Store};

/// One step in so many is timed: reading the clock around every participant would cost as much as the participants.
const TIMED_EVERY: u64 = 64;

/// A participant that could not compute its step.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{node} at step {step}: {fault}")]
pub struct StepError {
    /// Name of the node.
    pub node: String,
    /// Number of the step.
    pub step: u64,
    /// What it said.
    pub fault: Fault,
}

/// Runs a network in the calling thread.
pub struct Local {
    /// Participants in order of execution.
    members: Vec<Member>,
    network: Network,
    phases: Vec<usize>,
    store: Store,
    next: Step,
    period: Period,
    counts: Arc<LocalCounts>,
}

/// The counters of a run in one process; they can be read from another thread.
#[derive(Debug)]
pub struct LocalCounts {
    completed: AtomicU64,
    timed: AtomicU64,
    /// Nanoseconds by node, of the timed steps together.
    spent_ns: Vec<AtomicU64>,
}

impl LocalCounts {
    fn new(nodes: usize) -> Self {
        let spent_ns = (0..nodes).map(|_| AtomicU64::new(0)).collect();
        Self { completed: AtomicU64::new(0), timed: AtomicU64::new(0), spent_ns }
    }

    /// Complete steps, and by node the time that all of them took. One step in 64 is timed; the others count as those.
    pub fn read(&self) -> (u64, Vec<Duration>) {
        let (completed, timed) = (self.completed.load(Relaxed), self.timed.load(Relaxed).max(1));
        let scale = completed as f64 / timed as f64;
        let spent = |ns: &AtomicU64| Duration::from_nanos((ns.load(Relaxed) as f64 * scale) as u64);
        (completed, self.spent_ns.iter().map(spent).collect())
    }
}

impl Local {
    /// A run of `network` whose node i is `participants[i]`, with steps of `dt` seconds.
    ///
    /// Headers are stamped with multiples of the [`Period`] that `dt` stands for, rounded to nanoseconds.
    ///
    /// # Errors
    /// [`LoopError`] if same-step edges form a loop.
    pub fn new(network: Network, participants: Vec<Box<dyn Participant>>, dt: f64) -> Result<Self, LoopError> {
        let phases = network.phases()?;
        let mut members: Vec<Member> = participants
            .into_iter()
            .enumerate()
            .map(|(node, participant)| Member::new(&network, node, participant))
            .collect();
        // Stable: within a phase the order of the network stays.
        members.sort_by_key(|member| phases[member.runner.node]);
        let store = Store::of(&network);
        let period = Period::from_seconds(dt).unwrap_or_else(|| Period::nanoseconds((dt * 1e9).round() as u64));
        let counts = Arc::new(LocalCounts::new(members.len()));
        Ok(Self { members, network, phases, store, next: Step { index: 0, dt }, period, counts })
    }

    /// Runs one step of all nodes and returns its number. Nodes that run at a lower rate hold their outputs in between.
    ///
    /// # Errors
    /// [`StepError`] if a participant faults or an output is not finite; the run cannot go on then.
    pub fn step(&mut self) -> Result<u64, StepError> {
        let step = self.next;
        let stamp = stamp(&step, self.period);
        let timed = step.index.is_multiple_of(TIMED_EVERY);
        for member in &mut self.members {
            let start = timed.then(clock::now);
            member.run(&self.network, &mut self.store, &step, &stamp).map_err(|fault| StepError {
                node: self.network.nodes[member.runner.node].name.clone(),
                step: step.index,
                fault,
            })?;
            if let Some(start) = start {
                self.counts.spent_ns[member.runner.node].fetch_add(start.elapsed().as_nanos() as u64, Relaxed);
            }
        }
        self.next.index += 1;
        self.counts.completed.store(self.next.index, Relaxed);
        if timed {
            self.counts.timed.fetch_add(1, Relaxed);
        }
        Ok(step.index)
    }

    /// The samples of the last two steps.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// The run's counters, which outlive it.
    pub fn counts(&self) -> Arc<LocalCounts> {
        Arc::clone(&self.counts)
    }

    /// Phase of every node.
    pub fn phases(&self) -> &[usize] {
        &self.phases
    }

    /// The network that runs.
    pub fn network(&self) -> &Network {
        &self.network
    }
}

/// The clock of the counters, which no result depends on.
#[expect(clippy::disallowed_types, reason = "what is measured is shown, and never computed with")]
mod clock {
    use std::time::Instant;

    pub(super) fn now() -> Instant {
        Instant::now()
    }
}
