//! A copy of every channel for programs that monitor a run: iceoryx2 publish/subscribe, which never waits for a reader.

mod service;

use std::collections::VecDeque;
use std::fs;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::service::{ServiceError, error};
use crate::{RunDirectory, keep_off_core};
use lockstep::{ChannelId, Header, Network, Store};
use service::Services;
pub use service::TapHeader;

/// Steps that may wait for the publishing thread; the oldest gives way to the newest. As many as a reader may be behind.
const STEPS: usize = 64;
/// How long the publishing thread sleeps between two looks for samples, while there are readers ...
const PAUSE: Duration = Duration::from_millis(1);
/// ... and between two looks for readers.
const LONG_PAUSE: Duration = Duration::from_millis(20);

/// Publishes samples as services of the run's iceoryx2 that are named like the topics, such as `/agent_1/state`.
///
/// A sample is a slice of `f64`, the words of the channel's layout, with a [`TapHeader`] (`PhalanxHeader`) as its user header.
/// The file `config/iceoryx2.toml` in the run directory says how to get there; the program `iox2` finds it when it is started
/// in that directory.
///
/// The caller only copies, and only while there is a reader; a thread of its own publishes, within about a millisecond. Readers that are slow, stopped or dead
/// lose samples, and so do all if that thread is kept from running; the run does not wait for them.
pub struct Tap {
    shared: Arc<Shared>,
    channels: Vec<ChannelId>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    /// Signalled when the tap is closed.
    end: Condvar,
    /// Whether there is a reader.
    watched: AtomicBool,
}

#[derive(Default)]
struct Queue {
    frames: VecDeque<Frame>,
    spare: Vec<Frame>,
    closed: bool,
}

/// The samples of a step.
#[derive(Default)]
struct Frame {
    /// `None`: the channel has no sample yet.
    headers: Vec<Option<Header>>,
    /// Of all channels, one behind the other.
    words: Vec<f64>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Tap {
    /// Creates the services of all channels of a run, and the thread that publishes, which stays off a core if one is given.
    /// Must be dropped before the directory is removed.
    ///
    /// # Errors
    /// [`ServiceError`] if iceoryx2 or the operating system refuse something.
    pub fn start(directory: &RunDirectory, network: &Network, off: Option<usize>) -> Result<Self, ServiceError> {
        let shared = Arc::new(Shared::default());
        let (ready, answer) = channel();
        let work = {
            let (shared, network) = (Arc::clone(&shared), network.clone());
            let (path, name) = (directory.path().to_path_buf(), directory.name().to_string());
            move || {
                // A tap on the core of the participants is slower, no more.
                let _ = off.map(keep_off_core);
                let services = Services::create(&path, &name, &network);
                serve(services, &shared, &ready);
            }
        };
        let thread = thread::Builder::new().name("tap".into()).spawn(work).map_err(error("start the tap".into()))?;
        let channels = (0..network.channels.len()).map(ChannelId).collect();
        let tap = Self { shared, channels, thread: Some(thread) };
        let config = answer.recv().unwrap_or_else(|gone| Err(error("start the tap".into())(gone)))?;
        let tell = || -> io::Result<()> {
            let folder = directory.path().join("config");
            fs::create_dir_all(&folder)?;
            fs::write(folder.join("iceoryx2.toml"), config)
        };
        directory.protect().map_err(error("protect the tap".into()))?;
        tell().map_err(error("tell readers where the tap is".into()))?;
        Ok(tap)
    }

    /// Takes a copy of the samples of `step`.
    pub fn publish(&self, store: &Store, step: u64) {
        if !self.shared.watched.load(Relaxed) {
            return;
        }
        let mut queue = self.shared.lock();
        let oldest = if queue.frames.len() == STEPS { queue.frames.pop_front() } else { queue.spare.pop() };
        let mut frame = oldest.unwrap_or_default();
        frame.headers.clear();
        frame.words.clear();
        for &channel in &self.channels {
            frame.headers.push(store.header(channel, step).copied());
            frame.words.extend_from_slice(store.read(channel, step));
        }
        queue.frames.push_back(frame);
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.end.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of it has done no harm to the run.
            let _ = thread.join();
        }
    }
}

/// What the thread does: answers with the configuration for readers, then publishes whatever there is.
fn serve(services: Result<Services, ServiceError>, shared: &Shared, ready: &Sender<Result<String, ServiceError>>) {
    let services = match services {
        Ok(services) => services,
        Err(error) => return drop(ready.send(Err(error))),
    };
    let _ = ready.send(Ok(services.config()));
    let mut frames = VecDeque::new();
    loop {
        let watched = services.are_read();
        shared.watched.store(watched, Relaxed);
        let queue = shared.lock();
        let pause = if watched { PAUSE } else { LONG_PAUSE };
        let waited = shared.end.wait_timeout_while(queue, pause, |queue| !queue.closed);
        let (mut queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let closed = queue.closed;
        std::mem::swap(&mut queue.frames, &mut frames);
        drop(queue);
        for frame in &frames {
            services.publish(&frame.headers, &frame.words);
        }
        shared.lock().spare.extend(frames.drain(..));
        if closed {
            return;
        }
    }
}
