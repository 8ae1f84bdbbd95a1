//! Writing the log of a run without holding up its steps.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
#[cfg(test)]
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lockstep::{ChannelId, Header, Network, Period, Store};

use super::place::LogPlace;
use super::ros::{BAG, Durability, channel_metadata};
use super::schema::Schemas;
use super::sink::{ChannelRecord, Refusal, SchemaRecord, Sink, Summary};
use super::target::{LogFile, Target};
use super::{DATA, LogError, METADATA, SCENARIO};

/// Default number of steps after which a log is flushed. A smaller number costs time; with a larger one, a killed run loses more.
pub const DEFAULT_FLUSH_EVERY: u64 = 100;
/// Payload after which a chunk is closed at the end of its step, bytes.
const CHUNK_BYTES: usize = 1 << 20;

/// A recorded sample reaches the file after twice this time at the latest, also while a step hangs.
const TICK: Duration = Duration::from_millis(25);
/// Steps that a settled log may lack: those of the open chunk.
pub const UNSETTLED: u64 = DEFAULT_FLUSH_EVERY;

/// What a log says about its run besides the samples.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a> {
    /// The channels, in the order of their messages within a step.
    pub network: &'a Network,
    /// Simulated time from one step to the next, ns.
    pub period: Period,
    /// The scenario with all overrides applied, TOML; attached as `scenario.toml`.
    pub scenario: &'a str,
    /// Scenario name, variant, overrides, versions; nothing that differs between two runs of the same thing.
    pub metadata: &'a BTreeMap<String, String>,
    /// Steps between flushes, at least 1; a killed run loses at most about this many. See [`DEFAULT_FLUSH_EVERY`].
    pub flush_every: u64,
}

/// A channel of prepared messages, see [`Recorder::add_channel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExtraChannel(u16);

/// Records a run into an MCAP file.
///
/// [`Recorder::record`] only copies the samples into a buffer; other threads compress and write. If they or the disk cannot
/// keep up, the run waits for them. A recorder that is dropped leaves a readable file; only [`Recorder::finish`] says whether
/// all of it was written.
///
/// The file takes its place with its first step, and holds every step 50 ms after it was recorded, also while the next one hangs.
pub struct Recorder {
    path: PathBuf,
    channels: usize,
    schemas: Schemas,
    period: Period,
    /// The step recorded last.
    last: Option<u64>,
    flush_every: u64,
    extra_channels: usize,
    open: Arc<Open>,
    /// The thread that shows what waits.
    clerk: Option<JoinHandle<()>>,
}

/// What the step thread shares with the thread that shows what waits.
struct Open {
    /// There until the file is closed.
    sink: Mutex<Option<Sink<Box<dyn Target>>>>,
    closed: Condvar,
}

impl Open {
    fn lock(&self) -> MutexGuard<'_, Option<Sink<Box<dyn Target>>>> {
        self.sink.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows what waits, until the file is closed.
    fn show_late(&self) {
        let mut sink = self.lock();
        while let Some(open) = &mut *sink {
            // What goes wrong is reported at the next step.
            let _ = open.show_late();
            sink = self.closed.wait_timeout(sink, TICK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl Recorder {
    /// Starts the log `path`, which takes the place of an earlier one with its first step.
    ///
    /// # Errors
    /// Those of [`LogPlace::claim`], [`LogError::Write`] if the file cannot be written, [`LogError::Layout`] if a channel's layout has
    /// no ROS 2 message, [`LogError::TooManyChannels`].
    pub fn create(path: &Path, run: &RunInfo<'_>) -> Result<Self, LogError> {
        Self::create_at(&LogPlace::claim(path)?, run)
    }

    /// The same in a place that is claimed already.
    ///
    /// # Errors
    /// As those of [`create`](Self::create).
    pub fn create_at(place: &LogPlace, run: &RunInfo<'_>) -> Result<Self, LogError> {
        let path = place.path();
        let failed = |error| LogError::write(path, error);
        let file = LogFile::new(place.clone()).map_err(failed)?;
        let recorder = Self::to(Box::new(file), path, run)?;
        // Where no earlier log is, readers may look from the start on.
        place.publish_where_free().map_err(failed)?;
        Ok(recorder)
    }

    /// The same on any output; `path` is only a name.
    #[cfg(test)]
    pub(super) fn on(output: impl Write + Send + 'static, path: &Path, run: &RunInfo<'_>) -> Result<Self, LogError> {
        Self::to(Box::new(super::target::Plain(output)), path, run)
    }

    fn to(output: Box<dyn Target>, path: &Path, run: &RunInfo<'_>) -> Result<Self, LogError> {
        let failed = |error| LogError::write(path, error);
        let refused = |refusal| refused(path, refusal);
        let library = concat!("phalanx ", env!("CARGO_PKG_VERSION"));
        let mut sink = Sink::new(output, "ros2", library).map_err(failed)?;
        sink.metadata(METADATA, run.metadata).map_err(refused)?;
        sink.metadata(BAG, &BTreeMap::new()).map_err(refused)?;
        sink.attach(SCENARIO, "application/toml", run.scenario.as_bytes()).map_err(refused)?;
        // A full disk is reported now, not after the first steps.
        sink.settle().map_err(refused)?;
        let mut schemas = Schemas::default();
        for (index, channel) in run.network.channels.iter().enumerate() {
            let id = u16::try_from(index).map_err(|_| LogError::TooManyChannels)?;
            let (schema, name, new) = schemas.of_layout(&channel.topic, &channel.layout)?;
            if new {
                sink.schema(schema_record(schema, &name, &channel.layout.ros2msg())).map_err(refused)?;
            }
            let metadata = channel_metadata(schemas.hash(&name), Durability::Volatile);
            sink.channel(channel_record(id, schema, &channel.topic, metadata)).map_err(refused)?;
        }
        let open = Arc::new(Open { sink: Mutex::new(Some(sink)), closed: Condvar::new() });
        let shared = open.clone();
        let clerk = thread::Builder::new().name("log show".into()).spawn(move || shared.show_late()).map_err(failed)?;
        Ok(Self {
            path: path.into(),
            channels: run.network.channels.len(),
            schemas,
            period: run.period,
            last: None,
            flush_every: run.flush_every.max(1),
            extra_channels: 0,
            open,
            clerk: Some(clerk),
        })
    }

    /// Records the samples of `step` of all channels, with the header that `header` gives for each.
    ///
    /// The first step may have any number; each further one is its predecessor plus 1.
    ///
    /// # Errors
    /// [`LogError::StepOrder`] for another step, [`LogError::Write`] if writing failed since the last call.
    pub fn record(&mut self, step: u64, store: &Store, header: impl Fn(ChannelId) -> Header) -> Result<(), LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        if let Some(expected) = self.last.map(|last| last + 1)
            && step != expected
        {
            return Err(LogError::StepOrder { expected, found: step });
        }
        // Here and not at the end of a step: prepared messages of a step follow its samples. Chunks end where steps do, by
        // rules that look at nothing but the samples: equal runs, equal bytes.
        if self.last.is_some() && (step.is_multiple_of(self.flush_every) || sink.pending() >= CHUNK_BYTES) {
            sink.flush().map_err(|refusal| refused(&self.path, refusal))?;
        }
        let time = self.period.time_ns(step);
        for index in 0..self.channels {
            let channel = ChannelId(index);
            sink.sample(index as u16, step as u32, time, &header(channel), store.read(channel, step));
        }
        self.last = Some(step);
        Ok(())
    }

    /// Adds a channel of prepared CDR messages to the log, of the type `schema_name` that `schema_text` (ros2msg) defines;
    /// `durability` says whether a late reader needs its messages.
    ///
    /// # Errors
    /// [`LogError::SchemaConflict`] if the type name has another text already, [`LogError::TooManyChannels`],
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn add_channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        schema_text: &str,
        durability: Durability,
    ) -> Result<ExtraChannel, LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        let id = u16::try_from(self.channels + self.extra_channels).map_err(|_| LogError::TooManyChannels)?;
        let (schema, new) = self.schemas.of_name(schema_name, schema_text)?;
        self.extra_channels += 1;
        if new {
            let definition = schema_record(schema, schema_name, schema_text);
            sink.schema(definition).map_err(|refusal| refused(&self.path, refusal))?;
        }
        let metadata = channel_metadata(self.schemas.hash(schema_name), durability);
        sink.channel(channel_record(id, schema, topic, metadata)).map_err(|refusal| refused(&self.path, refusal))?;
        Ok(ExtraChannel(id))
    }

    /// Writes a prepared message at `step`, the one recorded last. `payload` is CDR with its 4 bytes of encapsulation.
    ///
    /// # Errors
    /// [`LogError::StepOrder`] for another step, [`LogError::Write`] if writing failed since the last call.
    pub fn write(&mut self, channel: ExtraChannel, step: u64, payload: &[u8]) -> Result<(), LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        let expected = self.last.unwrap_or(0);
        if self.last != Some(step) {
            return Err(LogError::StepOrder { expected, found: step });
        }
        let time = self.period.time_ns(step);
        let written = sink.message(channel.0, step as u32, [time; 2], payload);
        written.map_err(|refusal| refused(&self.path, refusal))
    }

    /// Lets the file hold all that was recorded, for a run that does not go on for a while.
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn show(&mut self) -> Result<(), LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        sink.show().map_err(|refusal| refused(&self.path, refusal))
    }

    /// Waits until the file holds all steps but the last [`UNSETTLED`].
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn settle(&self) -> Result<(), LogError> {
        let open = self.open.lock();
        let sink = open.as_ref().ok_or_else(|| closed(&self.path))?;
        sink.drain().map_err(|source| LogError::Write { path: self.path.clone(), source })
    }

    /// Writes a metadata record; nothing in it may differ between two runs of the same thing.
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn note(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> Result<(), LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        sink.metadata(name, metadata).map_err(|refusal| refused(&self.path, refusal))
    }

    /// Attaches a data file of the scenario, which its formulas call `path`; before the first step, so that it stands in the
    /// [`Head`](super::Head) of the log.
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn attach_data(&mut self, path: &str, bytes: &[u8]) -> Result<(), LogError> {
        let mut open = self.open.lock();
        let sink = checked(&mut open, &self.path)?;
        let attached = sink.attach(&format!("{DATA}{path}"), "text/csv", bytes);
        attached.map_err(|refusal| refused(&self.path, refusal))
    }

    /// Writes the rest and closes the file. Returns `None` if no step was recorded and an earlier log stands in the place, which stays.
    ///
    /// # Errors
    /// [`LogError::Write`] if not everything could be written.
    pub fn finish(mut self) -> Result<Option<Summary>, LogError> {
        self.close().unwrap_or_else(|| Err(closed(&self.path)))
    }

    /// `None` if it is closed already.
    fn close(&mut self) -> Option<Result<Option<Summary>, LogError>> {
        let sink = self.open.lock().take();
        self.open.closed.notify_all();
        if let Some(clerk) = self.clerk.take() {
            // It does nothing that could panic, and is not in the middle of anything: the lock was free.
            let _ = clerk.join();
        }
        let (summary, result) = sink?.finish(self.path.clone());
        let written = result.map_err(|source| LogError::Write { path: self.path.clone(), source });
        Some(written.map(|()| summary))
    }
}

impl fmt::Debug for Recorder {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Recorder").field("path", &self.path).field("last", &self.last).finish_non_exhaustive()
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // A caller that needs the error calls `finish`.
        let _ = self.close();
    }
}

/// The sink, if it is there and all is well with it; what went wrong is reported at every later call, too.
fn checked<'a, W: Target + 'static>(sink: &'a mut Option<Sink<W>>, path: &Path) -> Result<&'a mut Sink<W>, LogError> {
    let sink = sink.as_mut().ok_or_else(|| closed(path))?;
    sink.check().map_err(|source| LogError::Write { path: path.into(), source })?;
    Ok(sink)
}

fn closed(path: &Path) -> LogError {
    LogError::write(path, io::Error::other("the log is closed"))
}

fn refused(path: &Path, refusal: Refusal) -> LogError {
    match refusal {
        Refusal::Contradiction(what) => LogError::write(path, io::Error::other(what)),
        Refusal::Write(source) => LogError::Write { path: path.into(), source },
    }
}

fn schema_record(id: u16, name: &str, text: &str) -> SchemaRecord {
    SchemaRecord { id, name: name.into(), encoding: "ros2msg".into(), text: text.into() }
}

fn channel_record(id: u16, schema: u16, topic: &str, metadata: BTreeMap<String, String>) -> ChannelRecord {
    ChannelRecord { id, schema, topic: topic.into(), encoding: "cdr".into(), metadata }
}
