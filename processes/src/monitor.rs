//! Looking at a run from outside: its newest samples, without any effect on it.
//!
//! A monitor is a reader for which no process waits. It has no arrival bit and opens no gate, and a blackboard does not know
//! how far its readers are; so however slow or dead it is, the run does not notice.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use iceoryx2::prelude::{LogLevel, set_log_level};

use crate::board::{Boards, ChannelReader, RING};
use crate::board_parts::BoardParts;
use crate::directory::{self, JoinLock};
use crate::service::ServiceError;
use crate::{DirectoryError, RunDirectory};
use lockstep::{ChannelId, Header, Network, Plan, PlanError, Status};

/// Processes that may have hosted a node one after the other, as far as this looks for them.
const MOST_INCARNATIONS: u32 = 64;

/// Looks without anything new after which a process may have taken the place of another.
const IDLE_LOOKS: u32 = 16;

/// How often a look is repeated if the run has overtaken it.
const ATTEMPTS: usize = 20;

/// Why a run cannot be monitored.
#[derive(Debug, thiserror::Error)]
pub enum MonitorError {
    /// There is no such run, or it is over.
    #[error("the run {0} is over")]
    Over(String),
    /// The directory of all runs cannot be used.
    #[error(transparent)]
    Directory(#[from] DirectoryError),
    /// The channels cannot be read: the run has none in shared memory, or too many look on already.
    #[error(transparent)]
    Service(#[from] ServiceError),
}

/// Reads the samples of a run that is going on, from outside.
///
/// It stays usable when the run ends: the last samples can still be read then.
pub struct Monitor {
    network: Network,
    presence: Presence,
    /// `None` only while it is dropped.
    joined: Option<JoinedRun>,
    /// The channel that tells how far the run is.
    probe: usize,
    samples: Vec<Sample>,
    /// What is being fetched; it becomes `samples` when it is complete.
    fetched: Vec<Sample>,
    /// The step that was seen last, and looks since then that found nothing new.
    before: Option<u64>,
    idle: u32,
}

/// What a run knows of an monitor.
struct JoinedRun {
    /// By number of the channel; `None` for a channel without a writer.
    readers: Vec<Option<ChannelReader>>,
    /// By number of the worker: which of its processes is read.
    incarnations: Vec<u32>,
    /// Which worker hosts which participant.
    plan: Plan,
    parts: BoardParts,
    /// After the readers, which belong to it.
    boards: Boards,
}

#[derive(Clone, Debug)]
struct Sample {
    header: Header,
    words: Vec<f64>,
}

impl Monitor {
    /// Joins the run called `run`, whose channels are those of `network`.
    ///
    /// # Errors
    /// [`MonitorError`].
    pub fn join(run: &str, network: Network) -> Result<Self, MonitorError> {
        // The run is not removed while this process makes files in its directory.
        let over = || MonitorError::Over(run.into());
        let presence = Presence::of(run).ok_or_else(over)?;
        let lock = presence.enter().ok_or_else(over)?;
        let unknown = |error: PlanError| ServiceError { what: "read its plan".into(), cause: error.to_string() };
        let plan = Plan::read(&presence.path).map_err(unknown)?;
        let boards = Boards::join(&presence.path, run, &format!("monitor-{}", std::process::id()))?;
        // When the run ends first, its files are gone before this reader lets go of them, which iceoryx2 deplores.
        set_log_level(LogLevel::Fatal);
        let mut joined = JoinedRun {
            readers: network.channels.iter().map(|_| None).collect(),
            incarnations: vec![0; plan.workers.len()],
            parts: BoardParts::of(&plan),
            plan,
            boards,
        };
        for worker in 0..joined.plan.workers.len() {
            joined.find(worker)?;
        }
        drop(lock);
        let empty = |words| Sample { header: Header::default(), words: vec![0.0; words] };
        let samples: Vec<Sample> = network.channels.iter().map(|channel| empty(channel.layout.words())).collect();
        let fastest = network.nodes.iter().filter(|node| !node.outputs.is_empty()).min_by_key(|node| node.every);
        let probe = fastest.map_or(0, |node| node.outputs[0].0);
        Ok(Self {
            presence,
            joined: Some(joined),
            probe,
            fetched: samples.clone(),
            samples,
            network,
            before: None,
            idle: 0,
        })
    }

    /// The channels that it looks at.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Whether the run has ended.
    pub fn is_over(&self) -> bool {
        !self.presence.lasts()
    }

    /// Fetches the samples of the newest step that is complete and returns its number. `None` if no step is, or if the run
    /// was faster than this process every time; the samples fetched before stand then.
    pub fn look(&mut self) -> Option<u64> {
        let step = self.fetch_newest();
        // A run that stands still is paused, or another process has taken the place of the one that tells how far it is.
        self.idle = if step.is_some() && step != self.before { 0 } else { self.idle + 1 };
        if self.idle == IDLE_LOOKS {
            self.idle = 0;
            self.follow();
        }
        self.before = step.or(self.before);
        step
    }

    fn fetch_newest(&mut self) -> Option<u64> {
        let over = self.is_over();
        for _ in 0..ATTEMPTS {
            let newest = self.newest()?;
            // In the first round through the ring, a cell that is not written yet looks like one of step 0.
            let first = if newest < RING && !over { newest.checked_sub(1)? } else { newest };
            for step in [first, newest.saturating_sub(1)] {
                if self.fetch(step) {
                    std::mem::swap(&mut self.samples, &mut self.fetched);
                    return Some(step);
                }
            }
        }
        None
    }

    /// The sample of a channel as of the last look that succeeded.
    pub fn sample(&self, channel: ChannelId) -> (&Header, &[f64]) {
        let Sample { header, words } = &self.samples[channel.0];
        (header, words)
    }

    /// The newest step that has begun.
    fn newest(&self) -> Option<u64> {
        let reader = self.joined.as_ref()?.readers.get(self.probe)?.as_ref()?;
        let steps = (0..RING).map(|place| (place, reader.step_in(place)));
        steps.filter(|(place, step)| step % RING == *place).map(|(_, step)| step).max()
    }

    /// Goes over to the processes that have taken the place of others.
    fn follow(&mut self) {
        let Some(_door) = self.presence.enter() else { return };
        let Some(joined) = self.joined.as_mut() else { return };
        for worker in 0..joined.plan.workers.len() {
            if let Ok(readers) = joined.open(worker, joined.incarnations[worker] + 1) {
                joined.incarnations[worker] += 1;
                joined.take(readers);
            }
        }
    }

    /// Fetches all samples of a step; whether all of them were there.
    fn fetch(&mut self, step: u64) -> bool {
        let Some(JoinedRun { readers, .. }) = &self.joined else { return false };
        for node in &self.network.nodes {
            let expected = node.last_run(step);
            for channel in &node.outputs {
                let Some(reader) = &readers[channel.0] else { continue };
                let Sample { header, words } = &mut self.fetched[channel.0];
                let Some(expected) = expected else {
                    *header = Header::default();
                    words.fill(0.0);
                    continue;
                };
                let Some(found) = reader.peek(step, words) else { return false };
                *header = found;
                if header.step != expected && header.status != Status::Stale as u32 {
                    return false;
                }
            }
        }
        true
    }
}

impl JoinedRun {
    /// Reads from the process that serves as a worker now: the last one that has services.
    fn find(&mut self, worker: usize) -> Result<(), ServiceError> {
        if self.parts.of_worker(worker).is_empty() {
            return Ok(());
        }
        let mut first = None;
        for incarnation in 0..MOST_INCARNATIONS {
            match self.open(worker, incarnation) {
                Ok(readers) => {
                    self.take(readers);
                    self.incarnations[worker] = incarnation;
                    first = Some(Ok(()));
                }
                Err(_) if matches!(first, Some(Ok(()))) => break,
                Err(error) => first = first.or(Some(Err(error))),
            }
        }
        first.unwrap_or(Ok(()))
    }

    /// The readers of a process that serves or served as a worker, if it has services and places are free.
    fn open(&self, worker: usize, incarnation: u32) -> Result<Vec<ChannelReader>, ServiceError> {
        let mut readers = Vec::new();
        for part in self.parts.of_worker(worker) {
            readers.extend(self.boards.open(&self.plan, part, incarnation)?.readers(|_| true)?);
        }
        Ok(readers)
    }

    fn take(&mut self, readers: Vec<ChannelReader>) {
        for reader in readers {
            // The run may have channels that this process does not know.
            if let Some(place) = self.readers.get_mut(reader.channel.0) {
                *place = Some(reader);
            }
        }
    }
}

impl Drop for Monitor {
    fn drop(&mut self) {
        let lock = self.presence.enter();
        let joined = self.joined.take();
        if lock.is_none() {
            // What belongs to a run that is over was removed with it, and its names may be those of another run by now. So
            // nothing may be cleaned up under them; this process keeps the memory until it ends.
            std::mem::forget(joined);
        }
    }
}

/// The directory of a run, which the run holds as long as it lives.
struct Presence {
    path: PathBuf,
    identity: (u64, u64),
}

impl Presence {
    /// That of a run that is going on.
    fn of(run: &str) -> Option<Self> {
        let path = RunDirectory::path_of(run);
        let identity = identity(&path)?;
        directory::is_alive(&path).then_some(Self { path, identity })
    }

    /// Whether it still is, and not another run of the same name.
    fn lasts(&self) -> bool {
        directory::is_alive(&self.path) && identity(&self.path) == Some(self.identity)
    }

    /// Keeps the run from removing its files; `None` if it is over.
    fn enter(&self) -> Option<JoinLock> {
        let lock = JoinLock::hold(&self.path)?;
        self.lasts().then_some(lock)
    }
}

/// Which directory it is.
fn identity(path: &Path) -> Option<(u64, u64)> {
    fs::symlink_metadata(path).ok().map(|found| (found.dev(), found.ino()))
}
