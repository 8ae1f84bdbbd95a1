//! The steps of a connected process, asked for one by one.

use super::Worker;
use super::jitter::Jitter;
use super::phase_share::{self, PhaseShare, fault};
use super::replacement::CatchUp;
use crate::board::Boards;
use crate::page::{Arrival, FaultKind, Report, Stopwatch};
use lockstep::{Fault, Io, Plan, Step, Store};

/// A node of this process that has to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DueNode {
    /// The step.
    pub step: Step,
    /// Which node: its number among [`Worker::nodes`].
    pub number: usize,
}

/// A connected process: [`next`](Link::next), read and write through [`io`](Link::io), [`done`](Link::done), and again.
///
/// After an error of `next` or `done` the conductor has been told, and the process should end.
pub struct Link {
    worker: Worker,
    shares: Vec<PhaseShare>,
    store: Store,
    stopwatch: Stopwatch,
    jitter: Option<Jitter>,
    step: Step,
    /// The share at work, or the next one.
    share: usize,
    /// The node at work within the share, or the next one.
    member: usize,
    /// When the share at work passed its gate; `None` before that.
    started: Option<u64>,
    progress: Progress,
    /// The phase and step after which it is to poll for the others of its core group.
    polls_after: Option<(usize, u64)>,
    /// As long as it catches up with steps that are done.
    catch_up: Option<CatchUp>,
    /// What the page told about replaced workers when the readers were looked through.
    replacements: u32,
    /// Whether it only holds the last samples, see [`Worker::holds`].
    holds: bool,
    boards: Boards,
}

/// What may be done with a [`Link`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// Asking for the next node.
    Between,
    /// Running a node.
    Due,
    /// Nothing: the run is over for this process.
    Over,
}

impl Link {
    pub(super) fn new(
        worker: Worker,
        boards: Boards,
        replacements: u32,
        shares: Vec<PhaseShare>,
        catch_up: Option<CatchUp>,
    ) -> Self {
        if catch_up.is_none() {
            worker.page.mark_ready(worker.number);
        }
        let first = catch_up.as_ref().map_or(0, CatchUp::first);
        Self {
            store: store_for(&worker),
            stopwatch: Stopwatch::new(worker.number, &worker.page),
            jitter: Jitter::from_environment(worker.number),
            step: Step { index: first, dt: worker.plan.dt },
            share: 0,
            member: 0,
            started: None,
            progress: Progress::Between,
            polls_after: None,
            holds: worker.holds(),
            worker,
            shares,
            catch_up,
            replacements,
            boards,
        }
    }

    /// What every process of the run knows.
    pub fn plan(&self) -> &Plan {
        &self.worker.plan
    }

    /// Waits until a node of this process has to run, and fetches what it reads. `None` after the last step, or if the
    /// conductor ended the run.
    ///
    /// Nodes that hold their outputs at a step are passed over.
    ///
    /// # Errors
    /// [`Fault`] if a sample is not the one that was due, or the node before was not finished with [`done`](Link::done).
    #[allow(clippy::should_implement_trait, reason = "it can fail, and what it gives is used through the link")]
    #[unsafe(link_section = "lockstep_step")]
    pub fn next(&mut self) -> Result<Option<DueNode>, Fault> {
        match self.progress {
            Progress::Between => {}
            Progress::Due => return Err(self.fail("the next step was asked for before this one was done")),
            Progress::Over => return Ok(None),
        }
        while self.step.index < self.worker.plan.steps {
            if self.share == self.shares.len() {
                self.share = 0;
                self.step.index += 1;
                continue;
            }
            if !self.enter()? {
                break;
            }
            if let Some(number) = self.due() {
                self.progress = Progress::Due;
                return Ok(Some(DueNode { step: self.step, number }));
            }
            self.leave()?;
        }
        self.progress = Progress::Over;
        Ok(None)
    }

    /// Inputs and outputs of the node that is due; `None` if none is.
    #[unsafe(link_section = "lockstep_step")]
    pub fn io(&mut self) -> Option<Io<'_>> {
        let place = match self.progress {
            Progress::Due => &self.shares[self.share].members[self.member].runner,
            _ => return None,
        };
        Some(place.io(&mut self.store, &self.step))
    }

    /// Checks and publishes the outputs of the node that was due.
    ///
    /// # Errors
    /// [`Fault`] if an output is not a finite number, or no node is due.
    #[unsafe(link_section = "lockstep_step")]
    pub fn done(&mut self) -> Result<(), Fault> {
        if self.progress != Progress::Due {
            return Err(self.fail("a step was called done, but none is in progress"));
        }
        let hosted = &mut self.shares[self.share].members[self.member];
        if let Err(report) = hosted.finish(&self.worker.plan, &mut self.store, &self.step) {
            return Err(self.end(report));
        }
        self.progress = Progress::Between;
        self.member += 1;
        // Processes that wait for this one must not wait until it asks for its next node.
        if self.due().is_none() {
            self.leave()?;
        }
        Ok(())
    }

    /// Reports to the conductor why the node that is due, or was last, cannot go on. Returns the reason.
    pub fn fail(&mut self, reason: impl Into<String>) -> Fault {
        self.progress = Progress::Over;
        let share = self.shares.get(self.share).or(self.shares.last());
        let member = share.and_then(|share| share.members.get(self.member).or(share.members.last()));
        let node = member.map_or(0, |hosted| hosted.runner.node);
        self.worker.leave(fault(node, &self.step, reason.into()))
    }

    /// Passes the gate of the share unless that is done already; `false` if it will not open any more.
    #[unsafe(link_section = "lockstep_step")]
    fn enter(&mut self) -> Result<bool, Fault> {
        if self.started.is_some() {
            return Ok(true);
        }
        if self.catch_up.is_some() && self.relive()? {
            return Ok(true);
        }
        let page = &self.worker.page;
        let phase = self.shares[self.share].phase;
        if let Some((left, step)) = self.polls_after.take() {
            page.poll_next_gate(self.worker.number, left, step);
        }
        if !page.await_gate(self.worker.number, phase, self.step.index) {
            return Ok(false);
        }
        if page.replacements() != self.replacements {
            self.follow()?;
        }
        let page = &self.worker.page;
        self.started = Some(self.stopwatch.start(page, phase));
        self.jitter.as_mut().map(Jitter::delay);
        match self.shares[self.share].fetch(&self.worker.plan, &mut self.store, &self.step) {
            Ok(()) => Ok(true),
            Err(report) => Err(self.end(report)),
        }
    }

    /// Repeats a share of a recorded step; `false` once all are repeated and this process takes part in the run.
    fn relive(&mut self) -> Result<bool, Fault> {
        let Some(catch_up) = self.catch_up.as_mut() else { return Ok(false) };
        if !catch_up.covers(&self.step, self.share) {
            catch_up.take_over(&self.worker);
            self.catch_up = None;
            return Ok(false);
        }
        match catch_up.enter(&self.worker.plan, &self.shares, self.share, &mut self.store, &self.step) {
            Ok(()) => {
                self.started = Some(0);
                Ok(true)
            }
            Err(report) => Err(self.end(report)),
        }
    }

    /// Reads from processes that have replaced others.
    #[cold]
    fn follow(&mut self) -> Result<(), Fault> {
        // Noted before the look at which workers were replaced, so that a later replacement is noticed the next time.
        self.replacements = self.worker.page.replacements();
        let (page, plan) = (&self.worker.page, &self.worker.plan);
        phase_share::follow(&self.boards, page, plan, &mut self.shares).map_err(|error| self.worker.refuse(error))
    }

    /// The page is not as this process must find it: it, or one that computed meanwhile, has written where it must not.
    #[cold]
    fn overwritten(&mut self) -> Fault {
        let message = "the memory that all processes of the run share was overwritten while this one computed".into();
        self.end(Report { kind: FaultKind::Overwritten, node: 0, step: self.step.index, message })
    }

    fn end(&mut self, report: Report) -> Fault {
        self.progress = Progress::Over;
        self.worker.leave(report)
    }

    /// The number of the next node of the share that runs at this step; those before it hold their outputs.
    #[unsafe(link_section = "lockstep_step")]
    fn due(&mut self) -> Option<usize> {
        let (plan, members) = (&self.worker.plan, &mut self.shares[self.share].members);
        while let Some(hosted) = members.get_mut(self.member) {
            if self.holds {
                hosted.hold(&mut self.store, &self.step);
            } else if hosted.runner.is_due(&plan.network, &mut self.store, &self.step) {
                return Some(hosted.number);
            }
            hosted.publish(&self.store, &self.step);
            self.member += 1;
        }
        None
    }

    /// Arrives at the end of the phase and goes on to the next share.
    #[unsafe(link_section = "lockstep_step")]
    fn leave(&mut self) -> Result<(), Fault> {
        let start = self.started.take().unwrap_or_default();
        if let Some(catch_up) = &mut self.catch_up {
            let share = &mut self.shares[self.share];
            if let Err(report) = catch_up.leave(&self.worker.plan, share, &mut self.store, &self.step) {
                return Err(self.end(report));
            }
        } else {
            let (share, page) = (&self.shares[self.share], &self.worker.page);
            if !page.is_intact(share.phase, share.position, self.step.index) {
                return Err(self.overwritten());
            }
            let end = self.stopwatch.end(page, share.phase, self.step.index, start);
            let arrival = page.arrive(self.worker.number, share.phase, share.position, self.step.index);
            self.stopwatch.arrived(page, share.phase, end, arrival == Arrival::Last);
            self.polls_after = (arrival == Arrival::LastOfGroup).then_some((share.phase, self.step.index));
        }
        self.member = 0;
        self.share += 1;
        Ok(())
    }
}

/// Room for the samples of the channels that the process reads or writes.
fn store_for(worker: &Worker) -> Store {
    let Plan { network, workers, .. } = &worker.plan;
    let nodes = || workers[worker.number].nodes.iter().map(|&node| &network.nodes[node]);
    let inputs = nodes().flat_map(|node| node.inputs.iter().map(|input| input.channel));
    let mut used = vec![false; network.channels.len()];
    inputs.chain(nodes().flat_map(|node| node.outputs.iter().copied())).for_each(|channel| used[channel.0] = true);
    Store::of_some(network, |channel| used[channel.0])
}
