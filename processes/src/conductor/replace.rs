//! Putting another process in the place of a worker while the run goes on.

use std::io::{self, PipeWriter, Write};
use std::ops::Range;
use std::os::fd::AsRawFd;
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::error::system;
use super::{Conductor, Death, RunError};
use crate::worker::{Replacement, ReplacementOrder};
use lockstep::{ChannelId, Store};

/// How often to look whether a process that catches up is still alive.
const LOOK: Duration = Duration::from_millis(50);
/// Samples are sent in pieces of this size, bytes.
const PIECE: usize = 1 << 16;

/// The samples of the steps that are done.
pub trait History {
    /// Gives every step of `steps` in order to `visit`, with a store that holds its samples.
    ///
    /// # Errors
    /// What `visit` returns, or that a step is not there.
    fn play(&mut self, steps: Range<u64>, visit: &mut dyn FnMut(&Store, u64) -> io::Result<()>) -> io::Result<()>;
}

impl Conductor {
    /// Starts `command` in the place of a worker: one that is dead or hangs, or any other, which is asked to end first.
    ///
    /// To be called between two calls of [`step`](Self::step), also after one that failed if the worker is one of the
    /// [`failed_workers`](Self::failed_workers). The new process is given the samples of the steps that are done and goes through
    /// them as `replacement` says; the others wait for it. It runs on `cpu`, or where the worker was moved to. After this, the run
    /// goes on as if nothing had happened. Returns the first step that it runs for the others to see, or `None` if nothing
    /// was left to be done for the worker.
    ///
    /// # Errors
    /// [`RunError`] if no process could take the place; it may be tried again with another command.
    ///
    /// # Panics
    /// If the plan has no such worker.
    pub fn replace(
        &mut self,
        worker: usize,
        command: Command,
        cpu: Option<usize>,
        replacement: Replacement,
        history: &mut dyn History,
    ) -> Result<Option<u64>, RunError> {
        let is_broken = self.failed;
        self.failed = true;
        self.look_at_page(self.next)?;
        let incarnation = self.workers.spawned(worker);
        if incarnation > self.settings.replacements {
            return Err(self.not_replaced(worker, format!("it was replaced {} times already", incarnation - 1)));
        }
        // A process that hangs cannot be asked.
        self.workers.dismiss(worker, !is_broken);
        let status = &self.workers.status;
        status.page.repair(|worker| status.is_dead(worker));
        status.page.vacate(worker);
        let (step, place) = status.page.resumption(&self.plan.places(worker));
        let recorded = self.next;
        if step == self.plan.steps {
            self.workers.status.forget_death(worker);
            self.failed = false;
            return Ok(None);
        }
        if replacement == Replacement::Hold && recorded == 0 {
            return Err(self.not_replaced(worker, "there is no sample yet that could be held".into()));
        }
        self.create_boards(worker, incarnation)?;
        let (pipe, output) = io::pipe().map_err(system("create a pipe"))?;
        let first = if replacement == Replacement::Hold { recorded - 1 } else { 0 };
        let order = ReplacementOrder { replacement, incarnation, first, recorded, step, place, pipe: pipe.as_raw_fd() };
        self.workers.status.forget_death(worker);
        let cpu = self.affinity.cores.get(worker).copied().or(cpu);
        self.workers.spawn(worker, command, cpu, self.directory.path(), Some(order))?;
        drop(pipe);
        let returned =
            self.send_steps(worker, first..recorded, output, history).and_then(|()| self.await_return(worker));
        // Asked after that: an interrupted run ends its workers, which is no failure of theirs.
        if self.workers.status.is_interrupted() {
            return Err(RunError::Interrupted { step: self.next });
        }
        returned?;
        self.failed = false;
        Ok(Some(step))
    }

    /// How often `worker` may still be replaced.
    pub fn replacements_left(&self, worker: usize) -> u32 {
        (self.settings.replacements + 1).saturating_sub(self.workers.spawned(worker))
    }

    /// Creates the services of a new process and reads from them from now on: before its return, no step is complete that
    /// was not recorded.
    fn create_boards(&mut self, worker: usize, incarnation: u32) -> Result<(), RunError> {
        self.ports.extend(|boards, readers| {
            for part in self.parts.of_worker(worker) {
                let places = self.reader_counts[worker][part.number];
                for fresh in boards.create(&self.plan, part, incarnation, places)?.readers(|_| true)? {
                    if let Ok(at) = readers.binary_search_by_key(&fresh.channel, |reader| reader.channel) {
                        // Never taken leave of, see `Ports`.
                        std::mem::forget(std::mem::replace(&mut readers[at], fresh));
                    }
                }
            }
            Ok::<(), RunError>(())
        })?;
        self.directory.protect()?;
        self.segments = self.directory.segments();
        Ok(())
    }

    /// Sends the samples of the steps that are done.
    fn send_steps(
        &self,
        worker: usize,
        steps: Range<u64>,
        output: PipeWriter,
        history: &mut dyn History,
    ) -> Result<(), RunError> {
        let channels: Vec<ChannelId> = self.plan.traffic(worker).into_iter().collect();
        let mut sender = StepSender { conductor: self, worker, output, bytes: Vec::with_capacity(2 * PIECE) };
        rustix::io::ioctl_fionbio(&sender.output, true).map_err(system("prepare the pipe of recorded steps"))?;
        let played = history.play(steps, &mut |store, step| {
            for &channel in &channels {
                let header = store.header(channel, step).copied().unwrap_or_default();
                sender.bytes.extend_from_slice(&header.to_bytes());
                store.read(channel, step).iter().for_each(|word| sender.bytes.extend_from_slice(&word.to_le_bytes()));
            }
            if sender.bytes.len() >= PIECE { sender.flush() } else { Ok(()) }
        });
        let sent = played.and_then(|()| sender.flush());
        drop(sender);
        // The process has ended by itself; why is better known from itself.
        sent.or_else(|error| if error.kind() == io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
            .map_err(|error| self.not_replaced(worker, error.to_string()))
    }

    /// Waits until a new process has caught up.
    fn await_return(&self, worker: usize) -> Result<(), RunError> {
        let status = &self.workers.status;
        let start = Instant::now();
        loop {
            let rings = status.page.rings();
            if status.page.is_ready(worker) {
                return Ok(());
            }
            self.look_at(worker)?;
            if start.elapsed() >= self.settings.deadline {
                let missing = vec![self.workers.late(worker, None)];
                return Err(RunError::NotReady { missing, waited: start.elapsed() });
            }
            status.page.sleep(rings, LOOK);
        }
    }

    /// Whether a process that catches up has failed, or the run is to end.
    fn look_at(&self, worker: usize) -> Result<(), RunError> {
        let status = &self.workers.status;
        if status.is_interrupted() {
            return Err(RunError::Interrupted { step: self.next });
        }
        if let Some(report) = status.page.report(worker) {
            let worker = self.plan.workers[worker].name.clone();
            return Err(RunError::Refused { worker, message: report.message });
        }
        match self.workers.death(worker) {
            Some(death) => Err(self.died_catching_up(worker, death)),
            None => Ok(()),
        }
    }

    fn died_catching_up(&self, worker: usize, death: Death) -> RunError {
        // It may have left a report just before it ended.
        match self.workers.status.page.report(worker) {
            Some(report) => {
                let worker = self.plan.workers[worker].name.clone();
                RunError::Refused { worker, message: report.message }
            }
            None => self.workers.died(worker, death, Some(self.next), None),
        }
    }

    fn not_replaced(&self, worker: usize, reason: String) -> RunError {
        RunError::NotReplaced { worker: self.plan.workers[worker].name.clone(), step: self.next, reason }
    }
}

/// The way of recorded samples to a process that catches up.
struct StepSender<'a> {
    conductor: &'a Conductor,
    worker: usize,
    output: PipeWriter,
    bytes: Vec<u8>,
}

impl StepSender<'_> {
    /// Sends what has come together, without waiting for ever for a process that does not read.
    fn flush(&mut self) -> io::Result<()> {
        if self.conductor.workers.status.is_interrupted() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let mut sent = 0;
        let mut progress = Instant::now();
        while sent < self.bytes.len() {
            match self.output.write(&self.bytes[sent..]) {
                Ok(count) => (sent, progress) = (sent + count, Instant::now()),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => self.wait(progress)?,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.bytes.clear();
        Ok(())
    }

    fn wait(&self, progress: Instant) -> io::Result<()> {
        let patience = Timespec { tv_sec: 0, tv_nsec: LOOK.subsec_nanos().into() };
        match poll(&mut [PollFd::new(&self.output, PollFlags::OUT)], Some(&patience)) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let is_gone = self.conductor.look_at(self.worker).is_err();
        if is_gone || progress.elapsed() > self.conductor.settings.deadline {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        Ok(())
    }
}
