//! Where the time of a run goes, read while it runs.

use std::sync::Arc;
use std::time::Duration;

use super::status::RunStatus;
use crate::page::Run;
use crate::ticks::Rate;
use lockstep::{Local, LocalCounts, Plan};

/// Reads the counters of a run. It outlives the run, and then shows where it ended.
#[derive(Clone)]
pub struct Statistics {
    source: Source,
    names: Vec<String>,
    /// The workers of every phase.
    members: Vec<Vec<usize>>,
    rate: Rate,
}

#[derive(Clone)]
enum Source {
    Processes(Arc<RunStatus>),
    Local(Arc<LocalCounts>),
}

/// The counters of a run at one moment. Those of different processes may be a step apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot {
    /// Number of complete steps.
    pub completed: u64,
    /// Every worker in order of the plan.
    pub workers: Vec<WorkerUsage>,
    /// Every phase in order.
    pub phases: Vec<PhaseUsage>,
    /// Names of the workers that the step in progress waits for.
    pub awaited: Vec<String>,
}

/// What a worker has done with its time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerUsage {
    /// Its name.
    pub name: String,
    /// How often it has run: once per step and phase.
    pub runs: u64,
    /// From its start to its arrival: reading, computing, writing, and being kept from it by others.
    pub compute: Duration,
    /// From the opening of its gate to its start.
    pub waking: Duration,
    /// From its arrival to the opening of its next gate.
    pub waiting: Duration,
    /// How often it was the last of its phase, for whom the others wait.
    pub last: u64,
}

/// How long a phase has lasted in all steps together, from the opening of its gate to the arrival of the last worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseUsage {
    /// The sum over all steps.
    pub lasted: Duration,
}

/// One run of a worker, for a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// Number of the worker.
    pub worker: usize,
    /// The step.
    pub step: u64,
    /// The phase.
    pub phase: usize,
    /// Its start, counted from the first start of all.
    pub start: Duration,
    /// How long it took.
    pub length: Duration,
}

impl From<&Local> for Statistics {
    /// Reads the counters of a run in one process. Times are those of one step in 64.
    fn from(local: &Local) -> Self {
        let names = local.network().nodes.iter().map(|node| node.name.clone()).collect();
        let phases = local.phases();
        let last = phases.iter().copied().max().unwrap_or(0);
        let of_phase = |phase| (0..phases.len()).filter(|&node| phases[node] == phase).collect();
        let members = (0..=last).map(of_phase).collect();
        Self { source: Source::Local(local.counts()), names, members, rate: Rate::start() }
    }
}

impl Statistics {
    pub(super) fn new(status: Arc<RunStatus>, plan: &Plan) -> Self {
        let names = plan.workers.iter().map(|worker| worker.name.clone()).collect();
        let members = (0..plan.phase_count()).map(|phase| plan.members(phase)).collect();
        Self { source: Source::Processes(status), names, members, rate: Rate::start() }
    }

    /// The counters now.
    pub fn read(&self) -> Snapshot {
        match &self.source {
            Source::Processes(status) => self.read_page(status),
            Source::Local(counts) => self.read_local(counts),
        }
    }

    fn read_page(&self, status: &RunStatus) -> Snapshot {
        let page = &status.page;
        let usage = |(worker, name): (usize, &String)| {
            let counts = page.counts(worker);
            WorkerUsage {
                name: name.clone(),
                runs: counts.runs,
                compute: self.rate.duration(counts.compute),
                waking: self.rate.duration(counts.wake),
                waiting: self.rate.duration(counts.wait),
                last: counts.last,
            }
        };
        let completed = page.completed();
        let phase = page.phase_of(completed).unwrap_or(0);
        let awaited = self.members[phase].iter().enumerate();
        let awaited = awaited.filter(|&(position, _)| !page.has_arrived(phase, position, completed));
        let phases = 0..self.members.len();
        Snapshot {
            completed,
            workers: self.names.iter().enumerate().map(usage).collect(),
            phases: phases.map(|phase| PhaseUsage { lasted: self.rate.duration(page.lasted(phase)) }).collect(),
            awaited: awaited.map(|(_, &worker)| self.names[worker].clone()).collect(),
        }
    }

    fn read_local(&self, counts: &LocalCounts) -> Snapshot {
        let (completed, spent) = counts.read();
        let usage = |(name, spent): (&String, &Duration)| WorkerUsage {
            name: name.clone(),
            runs: completed,
            compute: *spent,
            waking: Duration::ZERO,
            waiting: Duration::ZERO,
            last: 0,
        };
        let lasted = |members: &Vec<usize>| PhaseUsage { lasted: members.iter().map(|&node| spent[node]).sum() };
        Snapshot {
            completed,
            workers: self.names.iter().zip(&spent).map(usage).collect(),
            phases: self.members.iter().map(lasted).collect(),
            awaited: Vec::new(),
        }
    }

    /// The last runs of every worker, as many as [`Plan::traced`] says; none of a run in one process. Only whole once the run
    /// is over or paused.
    pub fn spans(&self) -> Vec<Span> {
        let Source::Processes(status) = &self.source else { return Vec::new() };
        let workers = 0..self.names.len();
        let runs = workers.flat_map(|worker| status.page.runs(worker).into_iter().map(move |run| (worker, run)));
        let runs: Vec<(usize, Run)> = runs.collect();
        let origin = runs.iter().map(|(_, run)| run.start).min().unwrap_or(0);
        let seconds_per_tick = self.rate.seconds_per_tick();
        let time = |ticks: u64| lockstep::duration(ticks as f64 * seconds_per_tick);
        let span = |(worker, run): (usize, Run)| Span {
            worker,
            step: run.step,
            phase: run.phase,
            start: time(run.start - origin),
            length: time(run.end.saturating_sub(run.start)),
        };
        runs.into_iter().map(span).collect()
    }
}
