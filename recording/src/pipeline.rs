//! Compression on several threads, writing in order.
//!
//! Chunks stand for themselves, so they may be compressed at the same time; each thread waits with its chunk until it is its
//! turn to write. So the bytes of the file depend neither on the number of threads nor on their speed.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};

use super::chunk::{Chunk, Packer};
use super::output::{Attachment, Output};
use super::target::Target;

/// Threads that compress and write.
const THREADS: usize = 2;
/// Jobs that may wait for a thread before the step waits for one.
const QUEUE: usize = 8;

/// Something to write.
pub(super) enum Job {
    Chunk(Chunk),
    Attachment(Attachment),
    Metadata(String, BTreeMap<String, String>),
    /// A chunk that is to be shown until the next one is written, and the bytes of definitions in it.
    Show(Vec<u8>, usize),
}

/// The threads that write one file.
pub(super) struct Pipeline<W> {
    shared: Arc<Shared<W>>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared<W> {
    state: Mutex<State>,
    /// Signalled when a job comes, or none comes any more.
    work: Condvar,
    /// Signalled when a job is taken or done.
    progress: Condvar,
    /// `None` once the file is closed.
    output: Mutex<Option<Output<W>>>,
    /// Why a job could not be done; no other is done after it.
    failure: OnceLock<Arc<io::Error>>,
    /// Why something could not be shown; what takes its place may still find room.
    not_shown: OnceLock<Arc<io::Error>>,
}

#[derive(Default)]
struct State {
    jobs: VecDeque<(u64, Job)>,
    /// Number of the next job that comes.
    next: u64,
    /// Number of the job that is written next.
    turn: u64,
    closed: bool,
    /// Chunks to use again.
    spare: Vec<Chunk>,
    /// Buffers to use again.
    buffers: Vec<Vec<u8>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<W: Target + 'static> Pipeline<W> {
    /// Starts the threads, which inherit the cores of the caller.
    pub(super) fn start(output: Output<W>) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            work: Condvar::new(),
            progress: Condvar::new(),
            output: Mutex::new(Some(output)),
            failure: OnceLock::new(),
            not_shown: OnceLock::new(),
        });
        let mut pipeline = Self { shared, threads: Vec::new() };
        for number in 1..=THREADS {
            let shared = pipeline.shared.clone();
            let packer = Packer::new()?;
            let thread = thread::Builder::new().name(format!("log {number}"));
            pipeline.threads.push(thread.spawn(move || shared.serve(packer))?);
        }
        Ok(pipeline)
    }
}

impl<W> Pipeline<W> {
    /// Takes a job over; waits if there are many.
    ///
    /// # Errors
    /// Why an earlier one could not be done.
    pub(super) fn send(&self, job: Job) -> Result<(), Arc<io::Error>> {
        let shared = &*self.shared;
        let is_full = |state: &mut State| state.jobs.len() >= QUEUE && shared.failure.get().is_none();
        let room = shared.progress.wait_while(lock(&shared.state), is_full);
        let mut state = room.unwrap_or_else(PoisonError::into_inner);
        shared.failure.get().map_or(Ok(()), |failure| Err(failure.clone()))?;
        let number = state.next;
        state.next += 1;
        state.jobs.push_back((number, job));
        shared.work.notify_one();
        Ok(())
    }

    /// An empty chunk.
    pub(super) fn chunk(&self) -> Chunk {
        lock(&self.shared.state).spare.pop().unwrap_or_default()
    }

    /// An empty buffer for what is to be shown.
    pub(super) fn buffer(&self) -> Vec<u8> {
        lock(&self.shared.state).buffers.pop().unwrap_or_default()
    }

    /// What went wrong so far.
    pub(super) fn check(&self) -> Result<(), Arc<io::Error>> {
        let shared = &*self.shared;
        shared.failure.get().or(shared.not_shown.get()).map_or(Ok(()), |failure| Err(failure.clone()))
    }

    /// Waits until all jobs are done.
    pub(super) fn drain(&self) -> Result<(), Arc<io::Error>> {
        let shared = &*self.shared;
        let is_busy = |state: &mut State| state.turn < state.next && shared.failure.get().is_none();
        drop(shared.progress.wait_while(lock(&shared.state), is_busy));
        self.check()
    }

    /// Waits until all jobs are done, ends the threads and gives the output back, with all that could be written; and why a job
    /// could not be done.
    pub(super) fn finish(mut self) -> (Option<Output<W>>, Result<(), Arc<io::Error>>) {
        self.join();
        let shared = &*self.shared;
        (lock(&shared.output).take(), shared.failure.get().map_or(Ok(()), |failure| Err(failure.clone())))
    }

    fn join(&mut self) {
        lock(&self.shared.state).closed = true;
        self.shared.work.notify_all();
        for thread in self.threads.drain(..) {
            // A panic has become a failure already.
            let _ = thread.join();
        }
    }
}

impl<W> Drop for Pipeline<W> {
    fn drop(&mut self) {
        self.join();
    }
}

impl<W> Shared<W> {
    /// Also wakes the threads that wait.
    fn fail(&self, error: io::Error) {
        let _ = self.failure.set(Arc::new(error));
        // Under the lock, so that no thread is between its check of the failure and its sleep.
        drop(lock(&self.state));
        self.progress.notify_all();
    }
}

/// Reports a panic of its thread: the thread that waits for its turn would wait for ever.
struct Watch<'a, W>(&'a Shared<W>);

impl<W> Drop for Watch<'_, W> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.fail(io::Error::other("a writing thread panicked"));
        }
    }
}

impl<W: Target> Shared<W> {
    /// What a thread does.
    fn serve(&self, mut packer: Packer) {
        let _watch = Watch(self);
        while let Some((number, job)) = self.take() {
            let packed = match &job {
                Job::Chunk(chunk) => packer.pack(chunk).map(Some),
                Job::Attachment(_) | Job::Metadata(..) | Job::Show(..) => Ok(None),
            };
            let not_yet = |state: &mut State| state.turn != number && self.failure.get().is_none();
            drop(self.progress.wait_while(lock(&self.state), not_yet));
            if self.failure.get().is_some() {
                return;
            }
            let written = match lock(&self.output).as_mut() {
                Some(output) => packed.and_then(|packed| match (&job, packed) {
                    (Job::Chunk(chunk), Some(packed)) => output.chunk(chunk, packed),
                    (Job::Attachment(attachment), _) => output.attach(attachment),
                    (Job::Metadata(name, metadata), _) => output.metadata(name, metadata),
                    (Job::Show(..), _) if self.not_shown.get().is_some() => Ok(()),
                    (Job::Show(bytes, defined), _) => {
                        let _ = output.show(bytes, *defined).map_err(|error| self.not_shown.set(Arc::new(error)));
                        Ok(())
                    }
                    (Job::Chunk(_), None) => Ok(()),
                }),
                None => Ok(()),
            };
            if let Err(error) = written {
                return self.fail(error);
            }
            let mut state = lock(&self.state);
            state.turn += 1;
            match job {
                Job::Chunk(mut chunk) => {
                    chunk.clear();
                    state.spare.push(chunk);
                }
                Job::Show(mut bytes, _) => {
                    bytes.clear();
                    state.buffers.push(bytes);
                }
                Job::Attachment(_) | Job::Metadata(..) => {}
            }
            drop(state);
            self.progress.notify_all();
        }
    }

    /// The next job; waits for one. `None` if none comes any more.
    fn take(&self) -> Option<(u64, Job)> {
        let is_idle = |state: &mut State| state.jobs.is_empty() && !state.closed;
        let waited = self.work.wait_while(lock(&self.state), is_idle);
        let job = waited.unwrap_or_else(PoisonError::into_inner).jobs.pop_front();
        self.progress.notify_all();
        job
    }
}
