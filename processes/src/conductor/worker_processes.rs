//! All worker processes of a run, from the first spawn to the last reaping.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::child::{Child, ChildSetup};
use super::error::{Activity, Death, Late, RunError, system};
use super::output_reader::OutputReader;
use super::poll::Poll;
use super::status::RunStatus;
use super::supervisor::Supervisor;
use crate::descendants::{Descendants, Mark};
use crate::ticks;
use crate::worker::ReplacementOrder;
use lockstep::Plan;

/// How long a report may wait for the end of what a dead child has printed.
const LAST_WORDS: Duration = Duration::from_millis(200);

/// How long the workers of an interrupted run may take to end by themselves: all of it has to end within a second.
const INTERRUPTED_GRACE: Duration = Duration::from_millis(400);

/// How often to look whether a worker that is to end has done so.
const DISMISSAL_LOOK: Duration = Duration::from_millis(10);

/// The processes, with the threads that watch them and read their output. Dropping it ends the run: no process is left.
pub(super) struct WorkerProcesses {
    pub(super) status: Arc<RunStatus>,
    names: Vec<String>,
    children: Vec<Option<Child>>,
    /// How many processes each worker has had.
    spawned: Vec<u32>,
    /// What marks the process of each worker, and all that descends from it.
    marks: Vec<Option<Mark>>,
    descendants: Descendants,
    grace: Duration,
    /// Watches the processes.
    watch: Poll,
    /// Reads what they print.
    output_reader: OutputReader,
    /// Ends what the processes have started, after them.
    _supervisor: Supervisor,
}

impl WorkerProcesses {
    pub(super) fn new(
        plan: &Plan,
        status: Arc<RunStatus>,
        grace: Duration,
        forward: bool,
        (descendants, supervisor): (Descendants, Supervisor),
    ) -> Result<Self, RunError> {
        let names = plan.workers.iter().map(|worker| worker.name.clone()).collect();
        let children = plan.workers.iter().map(|_| None).collect();
        let (spawned, marks) = (vec![0; plan.workers.len()], vec![None; plan.workers.len()]);
        let bell = Arc::clone(&status);
        let watch = Poll::start("phalanx-watch", move |worker| bell.report_death(worker));
        let watch = watch.map_err(system("start the thread that watches the processes"))?;
        let output_reader = OutputReader::start(forward).map_err(system("start the thread that reads their output"))?;
        Ok(Self {
            status,
            names,
            children,
            spawned,
            marks,
            descendants,
            grace,
            watch,
            output_reader,
            _supervisor: supervisor,
        })
    }

    /// Keeps what the processes print in files in `folder`.
    pub(super) fn keep_output(&mut self, folder: &Path) -> Result<(), RunError> {
        self.output_reader.keep_in(folder).map_err(system(format!("create the folder {}", folder.display())))
    }

    /// Starts the process of a worker.
    pub(super) fn spawn(
        &mut self,
        worker: usize,
        command: Command,
        cpu: Option<usize>,
        directory: &Path,
        order: Option<ReplacementOrder>,
    ) -> Result<u32, RunError> {
        // Counted whatever comes of it: what was made for it has its number. Who was there before is dead.
        self.spawned[worker] += 1;
        self.children[worker] = None;
        // So is all that it has started: two that serve as one worker would spoil the run.
        self.marks[worker].take().into_iter().for_each(Mark::end);
        let mark = self.descendants.mark(self.spawned.iter().sum());
        let name = &self.names[worker];
        let program = command.get_program().to_string_lossy().into_owned();
        let failed = || system(format!("start {program} for {name}"));
        let setup = ChildSetup { directory, worker, page: self.status.page.file(), cpu, order, mark };
        let (child, output) = Child::spawn(command, &setup).map_err(failed())?;
        self.output_reader.add(worker, name, output).map_err(failed())?;
        self.watch.add(child.pidfd(), worker, true).map_err(failed())?;
        let pid = child.pid();
        self.children[worker] = Some(child);
        self.marks[worker] = Some(mark);
        Ok(pid)
    }

    /// How many processes a worker has had.
    pub(super) fn spawned(&self, worker: usize) -> u32 {
        self.spawned[worker]
    }

    /// Ends the process of a worker: asks it to end unless it is, and kills it after the grace period, at
    /// once if it cannot be asked.
    pub(super) fn dismiss(&self, worker: usize, ask: bool) {
        let (page, start) = (&self.status.page, Instant::now());
        if ask {
            page.dismiss(worker);
        }
        let Some(child) = &self.children[worker] else { return };
        while !self.status.is_dead(worker) {
            let rings = page.rings();
            if !ask || start.elapsed() >= self.grace || self.status.is_interrupted() {
                child.kill();
            }
            if !self.status.is_dead(worker) {
                page.sleep(rings, DISMISSAL_LOOK);
            }
        }
    }

    pub(super) fn pid(&self, worker: usize) -> Option<u32> {
        self.children[worker].as_ref().map(Child::pid)
    }

    /// How a worker ended, if it did.
    pub(super) fn death(&self, worker: usize) -> Option<Death> {
        self.children[worker].as_ref().and_then(Child::death)
    }

    /// The error that says that a worker is dead.
    pub(super) fn died(&self, worker: usize, death: Death, step: Option<u64>, phase: Option<usize>) -> RunError {
        RunError::Died {
            worker: self.names[worker].clone(),
            pid: self.pid(worker).unwrap_or(0),
            death,
            step,
            phase,
            last_lines: self.output_reader.last_lines(worker, LAST_WORDS),
        }
    }

    /// What is known about a worker that keeps the others waiting, in `phase` or before it is connected.
    pub(super) fn late(&self, worker: usize, phase: Option<usize>) -> Late {
        let state = self.children[worker].as_ref().map_or('?', Child::state);
        // A process that is stopped, for instance, waits for nothing.
        let waiting = self.children[worker].as_ref().filter(|_| ['S', 'D'].contains(&state));
        Late {
            activity: self.activity(worker, phase),
            waits_in: waiting.and_then(Child::waits_in),
            worker: self.names[worker].clone(),
            pid: self.pid(worker),
            state,
            last_lines: self.output_reader.last_lines(worker, Duration::ZERO),
        }
    }

    fn activity(&self, worker: usize, phase: Option<usize>) -> Activity {
        let RunStatus { page, rate, .. } = &*self.status;
        let Some(phase) = phase else {
            return if page.is_taken(worker) { Activity::Connecting } else { Activity::Starting };
        };
        let (opened, started) = page.opened_and_started(phase, worker);
        let now = ticks::now();
        if opened.max(started) > now || opened.min(started) == 0 && opened.max(started) == 0 {
            return Activity::Unknown;
        }
        let since = |ticks| rate.duration(now.saturating_sub(ticks));
        if started >= opened { Activity::Computing(since(started)) } else { Activity::Waking(since(opened)) }
    }
}

impl Drop for WorkerProcesses {
    fn drop(&mut self) {
        let page = &self.status.page;
        page.stop();
        self.children.iter().flatten().for_each(Child::resume);
        let grace = if self.status.is_interrupted() { self.grace.min(INTERRUPTED_GRACE) } else { self.grace };
        let start = Instant::now();
        loop {
            let rings = page.rings();
            let all_ended = self.children.iter().flatten().all(|child| child.death().is_some());
            let left = grace.saturating_sub(start.elapsed());
            if all_ended || left.is_zero() {
                break;
            }
            // Rung at every death.
            page.sleep(rings, left);
        }
        // Kills those that are still there, all before it waits for any, and reaps all.
        self.children.iter().flatten().for_each(Child::kill);
        self.children.clear();
        // Handles of the run may outlive its directory.
        page.use_events(None);
    }
}
