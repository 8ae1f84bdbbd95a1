//! How the conductor waits for a step: until it is complete, a worker died, reported a fault or missed its deadline.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::{Conductor, RunError};
use crate::page::{FaultKind, Report};

/// How long the others of a phase are given to report a fault, too, so that it does not depend on chance which one is reported.
const OTHER_FAULTS: Duration = Duration::from_secs(1);

/// How often the phase in progress is looked at while nothing happens, as a part of the deadline.
const LOOKS_PER_DEADLINE: u32 = 8;

impl Conductor {
    /// Waits until `step` is complete.
    pub(super) fn await_step(&self, step: u64) -> Result<(), RunError> {
        let page = &self.workers.status.page;
        // Workers need the conductor only when all that is allowed is done; woken half-way, it allows more in time.
        let enough = (step + 1 + self.ahead / 2).min(self.plan.steps);
        let mut progress = None;
        let mut since = Instant::now();
        loop {
            let mut patience = Duration::MAX;
            let found = page.sleep_unless(enough, || {
                if self.workers.status.is_interrupted() {
                    return ControlFlow::Break(Err(RunError::Interrupted { step }));
                }
                if page.completed() > step {
                    return ControlFlow::Break(Ok(()));
                }
                let phase = page.phase_of(step);
                if let Err(error) = self.look_around(step, phase) {
                    // A step that was completed in the meantime is not lost to what happened after it.
                    let complete = page.completed() > step && !matches!(error, RunError::Interrupted { .. });
                    return ControlFlow::Break(if complete { Ok(()) } else { Err(error) });
                }
                let now = Instant::now();
                if progress != Some(phase) {
                    (progress, since) = (Some(phase), now);
                }
                let waited = now - since;
                if waited >= self.settings.deadline {
                    let phase = phase.unwrap_or(0);
                    let late = self.absent(phase, step).map(|worker| self.workers.late(worker, Some(phase))).collect();
                    return ControlFlow::Break(Err(RunError::Deadline { late, step, phase, waited }));
                }
                patience = (self.settings.deadline - waited).min(self.settings.deadline / LOOKS_PER_DEADLINE);
                ControlFlow::Continue(patience)
            });
            if let ControlFlow::Break(result) = found {
                return result;
            }
            if since.elapsed() >= patience {
                // A worker that polls for a core group may be stopped; the others of the group are late only if they are.
                page.end_polling();
            }
        }
    }

    /// The workers that have not arrived in `phase` of `step`, which is in progress.
    pub(super) fn absent(&self, phase: usize, step: u64) -> impl Iterator<Item = usize> {
        let members = self.plan.members(phase).into_iter().enumerate();
        members
            .filter(move |&(position, _)| !self.workers.status.page.has_arrived(phase, position, step))
            .map(|(_, worker)| worker)
    }

    /// Whether anything has happened that ends the run.
    pub(super) fn look_around(&self, step: u64, phase: Option<usize>) -> Result<(), RunError> {
        let found = self.search(step, phase);
        // Asked after the search: an interrupted run ends its workers, which is no failure of theirs.
        if self.workers.status.is_interrupted() { Err(RunError::Interrupted { step }) } else { found }
    }

    fn search(&self, step: u64, phase: Option<usize>) -> Result<(), RunError> {
        let status = &self.workers.status;
        self.look_at_page(step)?;
        for worker in status.dead() {
            let Some(death) = self.workers.death(worker) else { continue };
            // A worker that reports something ends then, but what it says is worth more than that it ended.
            if status.page.report_count() == 0 && !self.may_end(worker, step) {
                return Err(self.workers.died(worker, death, self.ready.then_some(step), phase));
            }
        }
        if status.page.report_count() > 0 {
            return Err(self.reported());
        }
        Ok(())
    }

    /// The workers whose fault it is that the run cannot continue: dead ones, those that have reported something, those that
    /// are late; before the first step, those that are not connected. None if the run cannot be saved by replacing a worker.
    pub fn failed_workers(&self, error: &RunError) -> Vec<usize> {
        let status = &self.workers.status;
        let step = status.page.completed();
        match error {
            RunError::Deadline { phase, step, .. } => self.absent(*phase, *step).collect(),
            RunError::NotReady { .. } if !self.ready => {
                (0..self.plan.workers.len()).filter(|&worker| !status.page.is_ready(worker)).collect()
            }
            RunError::Died { .. } | RunError::Fault { .. } | RunError::Refused { .. } => {
                let has_failed = |&worker: &usize| {
                    let died = || self.workers.death(worker).is_some() && !self.may_end(worker, step);
                    status.page.report(worker).is_some() || died()
                };
                (0..self.plan.workers.len()).filter(has_failed).collect()
            }
            _ => Vec::new(),
        }
    }

    /// A worker may end once it has done its part of the last step, in whatever way: everything of it is there.
    fn may_end(&self, worker: usize, step: u64) -> bool {
        let has_done_all =
            || (0..self.plan.phase_count()).all(|phase| !self.absent(phase, step).any(|absent| absent == worker));
        step + 1 == self.plan.steps && has_done_all()
    }

    /// The error that a worker has reported. If there are several in a phase, that of the first node.
    fn reported(&self) -> RunError {
        let status = &self.workers.status;
        let start = Instant::now();
        loop {
            let reports: Vec<(usize, Report)> =
                (0..self.plan.workers.len()).filter_map(|worker| Some((worker, status.page.report(worker)?))).collect();
            if reports.is_empty() && status.page.report_count() > 0 {
                return self.overwritten(self.next, "how many participants have failed");
            }
            let Some((worker, first)) = reports.iter().min_by_key(|(_, report)| report.node) else {
                // The report was counted, so its slot is filled; nothing else can be said.
                return RunError::Over { steps: self.next };
            };
            if first.kind == FaultKind::Overwritten {
                return self.overwritten(first.step, "found by a participant");
            }
            if first.kind == FaultKind::Refusal {
                let worker = self.plan.workers[*worker].name.clone();
                return RunError::Refused { worker, message: first.message.clone() };
            }
            let phase = self.plan.phases.get(first.node).copied().unwrap_or(0);
            let is_silent = |worker| !status.is_dead(worker) && status.page.report(worker).is_none();
            if start.elapsed() > OTHER_FAULTS
                || status.is_interrupted()
                || !self.absent(phase, first.step).any(is_silent)
            {
                let node = self.plan.network.nodes.get(first.node).map_or("a node", |node| &node.name);
                return RunError::Fault { node: node.into(), step: first.step, message: first.message.clone() };
            }
            status.page.sleep(status.page.rings(), Duration::from_millis(1));
        }
    }
}
