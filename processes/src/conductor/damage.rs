//! How the conductor finds out that a process has written into memory that is not its own.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::{Conductor, RunError};
use crate::board::ChannelReader;
use crate::page::{FaultKind, Page};

/// How long a worker that computed when the page was overwritten may take to find it so.
const CONFESSION: Duration = Duration::from_millis(200);

/// How many steps the workers may do, as the page must say.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Allowance {
    limit: u64,
    /// It may have been more before.
    most: u64,
}

impl Allowance {
    /// Lets all steps below `limit` run.
    pub(super) fn allow(&mut self, page: &Page, limit: u64) {
        *self = Self { limit, most: self.most.max(limit) };
        page.allow(limit);
    }
}

impl Conductor {
    /// Whether all stands on the page that must.
    pub(super) fn look_at_page(&self, step: u64) -> Result<(), RunError> {
        let Allowance { limit, most } = self.allowance;
        match self.workers.status.page.damage(self.next, limit, most) {
            Some(what) => Err(self.overwritten(step, what)),
            None => Ok(()),
        }
    }

    /// The error that the page is overwritten, with those who may have done it.
    #[cold]
    pub(super) fn overwritten(&self, step: u64, what: &'static str) -> RunError {
        let start = Instant::now();
        loop {
            let found: Vec<usize> = (0..self.plan.workers.len()).filter(|&worker| self.found_it(worker)).collect();
            if !found.is_empty() || start.elapsed() > CONFESSION {
                let suspects = found.into_iter().map(|worker| self.process_of(worker)).collect();
                return RunError::Overwritten { step, what, suspects };
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn found_it(&self, worker: usize) -> bool {
        self.workers.status.page.report(worker).is_some_and(|report| report.kind == FaultKind::Overwritten)
    }

    /// The same error, or what is behind it if memory was cut short.
    #[cold]
    pub(super) fn explain(&self, step: u64, error: RunError) -> RunError {
        match self.cut() {
            Some((path, before, now)) if !matches!(error, RunError::Interrupted { .. }) => {
                RunError::Cut { step, path, before, now, noticed: Box::new(error) }
            }
            _ => self.blame(step, error),
        }
    }

    /// The same error, or what is behind it if memory was overwritten.
    fn blame(&self, step: u64, error: RunError) -> RunError {
        if !matches!(error, RunError::Fault { .. } | RunError::Recording { .. }) {
            return error;
        }
        if (0..self.plan.workers.len()).any(|worker| self.found_it(worker)) {
            return self.overwritten(step, "found by a participant");
        }
        let suspects = self.who_may_have_altered();
        if suspects.is_empty() { error } else { RunError::Altered { noticed: Box::new(error), suspects } }
    }

    /// The workers that have all services open in which something stands that was not published; none if there is nothing.
    fn who_may_have_altered(&self) -> Vec<String> {
        let altered = self.ports.readers.iter().filter(|reader| {
            let words = self.plan.network.channels[reader.channel.0].layout.words();
            reader.is_altered(&mut vec![0.0; words])
        });
        let altered: BTreeSet<(usize, usize)> = altered.map(ChannelReader::service).collect();
        let readers = self.parts.readers(&self.plan);
        let has_open = |worker: &usize| {
            altered.iter().all(|&(host, part)| host == *worker || readers[host][part].contains(worker))
        };
        let workers = (0..self.plan.workers.len()).filter(|worker| !altered.is_empty() && has_open(worker));
        workers.map(|worker| self.process_of(worker)).collect()
    }

    /// A worker with its process, in words.
    fn process_of(&self, worker: usize) -> String {
        format!("{} (pid {})", self.plan.workers[worker].name, self.workers.pid(worker).unwrap_or_default())
    }

    /// A file of the run's shared memory that is shorter than it was.
    fn cut(&self) -> Option<(PathBuf, u64, u64)> {
        let size = |path: &PathBuf| fs::symlink_metadata(path).map_or(0, |found| found.len());
        let mut sizes = self.segments.iter().map(|(path, before)| (path.clone(), *before, size(path)));
        sizes.find(|(_, before, now)| now < before)
    }
}
