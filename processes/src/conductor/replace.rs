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
use crate::worker::{Comeback, Orders};
use lockstep::{ChannelId, Store};

/// How often to look whether a process that catches up is still alive.
const LOOK: Duration = Duration::from_millis(50);
/// Samples go into the feed in pieces of this size, bytes.
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
    /// [`casualties`](Self::casualties). The new process is given the samples of the steps that are done and goes through
    /// them as `comeback` says; the others wait for it. It runs on `cpu`, or where the worker was moved to. After this, the run
    /// goes on as if nothing had happened. Returns the first step that it runs for the others to see, or `None` if nothing
    /// was left to be done for the worker.
    ///
    /// # Errors
    /// [`RunError`] if nobody could take the place; it may be tried again with another command.
    ///
    /// # Panics
    /// If the plan has no such worker.
    pub fn replace(
        &mut self,
        worker: usize,
        command: Command,
        cpu: Option<usize>,
        comeback: Comeback,
        history: &mut dyn History,
    ) -> Result<Option<u64>, RunError> {
        let is_broken = self.failed;
        self.failed = true;
        self.look_at_page(self.next)?;
        let incarnation = self.crew.spawned(worker);
        if incarnation > self.settings.replacements {
            return Err(self.not_replaced(worker, format!("it was replaced {} times already", incarnation - 1)));
        }
        // A process that hangs cannot be asked.
        self.crew.dismiss(worker, !is_broken);
        let alarm = &self.crew.alarm;
        alarm.page.repair(|worker| alarm.is_dead(worker));
        alarm.page.vacate(worker);
        let (step, place) = alarm.page.resumption(&self.plan.places(worker));
        let recorded = self.next;
        if step == self.plan.steps {
            self.crew.alarm.forget_death(worker);
            self.failed = false;
            return Ok(None);
        }
        if comeback == Comeback::Hold && recorded == 0 {
            return Err(self.not_replaced(worker, "there is no sample yet that could be held".into()));
        }
        self.create_boards(worker, incarnation)?;
        let (feed, output) = io::pipe().map_err(system("create a pipe"))?;
        let first = if comeback == Comeback::Hold { recorded - 1 } else { 0 };
        let orders = Orders { comeback, incarnation, first, recorded, step, place, feed: feed.as_raw_fd() };
        self.crew.alarm.forget_death(worker);
        let cpu = self.arrangement.cores.get(worker).copied().or(cpu);
        self.crew.spawn(worker, command, cpu, self.directory.path(), Some(orders))?;
        drop(feed);
        let returned = self.feed(worker, first..recorded, output, history).and_then(|()| self.await_return(worker));
        // Asked after that: an interrupted run ends its workers, which is no failure of theirs.
        if self.crew.alarm.is_interrupted() {
            return Err(RunError::Interrupted { step: self.next });
        }
        returned?;
        self.failed = false;
        Ok(Some(step))
    }

    /// How often `worker` may still be replaced.
    pub fn replacements_left(&self, worker: usize) -> u32 {
        (self.settings.replacements + 1).saturating_sub(self.crew.spawned(worker))
    }

    /// Creates the services of a new process and reads from them from now on: before its return, no step is complete that
    /// was not recorded.
    fn create_boards(&mut self, worker: usize, incarnation: u32) -> Result<(), RunError> {
        self.ports.extend(|hub, readers| {
            for share in self.shares.of_worker(worker) {
                let places = self.reader_counts[worker][share.part];
                for fresh in hub.create(&self.plan, share, incarnation, places)?.readers(|_| true)? {
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
    fn feed(
        &self,
        worker: usize,
        steps: Range<u64>,
        output: PipeWriter,
        history: &mut dyn History,
    ) -> Result<(), RunError> {
        let channels: Vec<ChannelId> = self.plan.traffic(worker).into_iter().collect();
        let mut feed = Feed { conductor: self, worker, output, bytes: Vec::with_capacity(2 * PIECE) };
        rustix::io::ioctl_fionbio(&feed.output, true).map_err(system("prepare the feed"))?;
        let played = history.play(steps, &mut |store, step| {
            for &channel in &channels {
                let header = store.header(channel, step).copied().unwrap_or_default();
                feed.bytes.extend_from_slice(&header.to_bytes());
                store.read(channel, step).iter().for_each(|word| feed.bytes.extend_from_slice(&word.to_le_bytes()));
            }
            if feed.bytes.len() >= PIECE { feed.flush() } else { Ok(()) }
        });
        let sent = played.and_then(|()| feed.flush());
        drop(feed);
        // The process has ended by itself; why is better known from itself.
        sent.or_else(|error| if error.kind() == io::ErrorKind::BrokenPipe { Ok(()) } else { Err(error) })
            .map_err(|error| self.not_replaced(worker, error.to_string()))
    }

    /// Waits until a new process has caught up.
    fn await_return(&self, worker: usize) -> Result<(), RunError> {
        let alarm = &self.crew.alarm;
        let start = Instant::now();
        loop {
            let rings = alarm.page.rings();
            if alarm.page.is_ready(worker) {
                return Ok(());
            }
            self.look_at(worker)?;
            if start.elapsed() >= self.settings.deadline {
                let missing = vec![self.crew.late(worker, None)];
                return Err(RunError::NotReady { missing, waited: start.elapsed() });
            }
            alarm.page.sleep(rings, LOOK);
        }
    }

    /// Whether a process that catches up has failed, or the run is to end.
    fn look_at(&self, worker: usize) -> Result<(), RunError> {
        let alarm = &self.crew.alarm;
        if alarm.is_interrupted() {
            return Err(RunError::Interrupted { step: self.next });
        }
        if let Some(report) = alarm.page.report(worker) {
            let worker = self.plan.workers[worker].name.clone();
            return Err(RunError::Refused { worker, message: report.message });
        }
        match self.crew.death(worker) {
            Some(death) => Err(self.died_catching_up(worker, death)),
            None => Ok(()),
        }
    }

    fn died_catching_up(&self, worker: usize, death: Death) -> RunError {
        // It may have left a report just before it ended.
        match self.crew.alarm.page.report(worker) {
            Some(report) => {
                let worker = self.plan.workers[worker].name.clone();
                RunError::Refused { worker, message: report.message }
            }
            None => self.crew.died(worker, death, Some(self.next), None),
        }
    }

    fn not_replaced(&self, worker: usize, reason: String) -> RunError {
        RunError::NotReplaced { worker: self.plan.workers[worker].name.clone(), step: self.next, reason }
    }
}

/// The way of recorded samples to a process that catches up.
struct Feed<'a> {
    conductor: &'a Conductor,
    worker: usize,
    output: PipeWriter,
    bytes: Vec<u8>,
}

impl Feed<'_> {
    /// Sends what has come together, without waiting for ever for a process that does not read.
    fn flush(&mut self) -> io::Result<()> {
        if self.conductor.crew.alarm.is_interrupted() {
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
