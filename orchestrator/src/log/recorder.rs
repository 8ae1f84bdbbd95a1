//! Writing the log of a run without holding up its steps.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};

use lockstep::{ChannelId, Header, Network, Store};

use super::batch::Batch;
use super::schema::Schemas;
use super::sink::{ChannelRecord, SchemaRecord, Sink, Summary};
use super::{LogError, METADATA, SCENARIO};

/// Steps after which a log is flushed if nobody says otherwise: more often costs time, less often costs a killed run data.
pub const DEFAULT_FLUSH_EVERY: u64 = 100;
/// Steps that go to the writer thread at once.
const BATCH_STEPS: u64 = 64;
/// Payload that goes to the writer thread even if it is fewer steps, bytes.
const BATCH_BYTES: usize = 1 << 20;
/// Batches that may wait for the writer thread before a step waits for it.
const QUEUE_BATCHES: usize = 8;

/// Steps that a settled log may lack: those of the open chunk, and those of the batch that is not sent yet.
pub(crate) const UNSETTLED: u64 = DEFAULT_FLUSH_EVERY + BATCH_STEPS;

/// What a log says about its run besides the samples.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a> {
    /// The channels, in the order of their messages within a step.
    pub network: &'a Network,
    /// Simulated time from one step to the next, ns.
    pub period_ns: u64,
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

/// Work for the writer thread, done in this order.
enum Job {
    Batch(Batch),
    Channel(Option<SchemaRecord>, ChannelRecord),
    /// To be answered once all before it is written.
    Settle(SyncSender<()>),
    Metadata(String, BTreeMap<String, String>),
}

/// Records a run into an MCAP file.
///
/// [`Recorder::record`] only copies the samples into a buffer; a thread of its own compresses and writes. If the disk cannot
/// keep up, the run waits for it. A recorder that is dropped leaves a readable file; only [`Recorder::finish`] says whether
/// all of it was written.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    channels: usize,
    schemas: Schemas,
    /// The step recorded last.
    last: Option<u64>,
    batch: Batch,
    batch_steps: u64,
    flush_every: u64,
    extra_channels: usize,
    jobs: Option<SyncSender<Job>>,
    spare: Receiver<Batch>,
    failure: Arc<OnceLock<Arc<io::Error>>>,
    writer: Option<JoinHandle<Option<Summary>>>,
}

impl Recorder {
    /// Starts the log `path`, replacing a file of that name.
    ///
    /// # Errors
    /// [`LogError::Write`] if the file cannot be created or written, [`LogError::Layout`] if a channel's layout has no ROS 2
    /// message, [`LogError::TooManyChannels`].
    pub fn create(path: &Path, run: &RunInfo<'_>) -> Result<Self, LogError> {
        let file = File::create(path).map_err(|error| LogError::write(path, error))?;
        Self::on(file, path, run)
    }

    /// The same on any output; `path` is only a name.
    pub(super) fn on(output: impl Write + Send + 'static, path: &Path, run: &RunInfo<'_>) -> Result<Self, LogError> {
        let failed = |error| LogError::write(path, error);
        let library = concat!("phalanx ", env!("CARGO_PKG_VERSION"));
        let mut sink = Sink::new(output, "ros2", library, run.flush_every).map_err(failed)?;
        sink.metadata(METADATA, run.metadata).map_err(failed)?;
        sink.attach(SCENARIO, "application/toml", run.scenario.as_bytes()).map_err(failed)?;
        // A full disk is reported now, not after the first steps.
        sink.flush().map_err(failed)?;
        let mut schemas = Schemas::default();
        for (index, channel) in run.network.channels.iter().enumerate() {
            let id = u16::try_from(index).map_err(|_| LogError::TooManyChannels)?;
            let (schema, name, new) = schemas.of_layout(&channel.topic, &channel.layout)?;
            if new {
                sink.schema(&schema_record(schema, &name, &channel.layout.ros2msg())).map_err(failed)?;
            }
            sink.channel(&channel_record(id, schema, &channel.topic)).map_err(failed)?;
        }

        let (jobs, queue) = sync_channel(QUEUE_BATCHES);
        let (used, spare) = channel();
        let failure = Arc::new(OnceLock::new());
        let work = Writing { sink, queue, used, failure: failure.clone(), path: path.into(), period_ns: run.period_ns };
        let writer = thread::Builder::new().name("log".into()).spawn(move || work.run()).map_err(failed)?;
        Ok(Self {
            path: path.into(),
            channels: run.network.channels.len(),
            schemas,
            last: None,
            batch: Batch::default(),
            batch_steps: 0,
            flush_every: run.flush_every.max(1),
            extra_channels: 0,
            jobs: Some(jobs),
            spare,
            failure,
            writer: Some(writer),
        })
    }

    /// Records the samples of `step` of all channels, with the header that `header` gives for each.
    ///
    /// The first step may have any number; each further one is its predecessor plus 1.
    ///
    /// # Errors
    /// [`LogError::StepOrder`] for another step, [`LogError::Write`] if writing failed since the last call.
    pub fn record(&mut self, step: u64, store: &Store, header: impl Fn(ChannelId) -> Header) -> Result<(), LogError> {
        self.check()?;
        if let Some(expected) = self.last.map(|last| last + 1)
            && step != expected
        {
            return Err(LogError::StepOrder { expected, found: step });
        }
        // Here and not at the end of a step: prepared messages of a step follow its samples.
        let flushes = step.is_multiple_of(self.flush_every);
        if self.batch_steps >= BATCH_STEPS || self.batch.bytes() >= BATCH_BYTES || flushes {
            self.send_batch(true)?;
        }
        for index in 0..self.channels {
            let channel = ChannelId(index);
            self.batch.push_sample(index as u16, step, &header(channel), store.read(channel, step));
        }
        self.last = Some(step);
        self.batch_steps += 1;
        Ok(())
    }

    /// Adds a channel of prepared CDR messages to the log, of the type `schema_name` that `schema_text` (ros2msg) defines.
    ///
    /// # Errors
    /// [`LogError::SchemaConflict`] if the type name has another text already, [`LogError::TooManyChannels`],
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn add_channel(&mut self, topic: &str, schema_name: &str, schema_text: &str) -> Result<ExtraChannel, LogError> {
        self.check()?;
        let id = u16::try_from(self.channels + self.extra_channels).map_err(|_| LogError::TooManyChannels)?;
        let (schema, new) = self.schemas.of_name(schema_name, schema_text)?;
        self.extra_channels += 1;
        self.send_batch(false)?;
        let definition = new.then(|| schema_record(schema, schema_name, schema_text));
        self.send(Job::Channel(definition, channel_record(id, schema, topic)))?;
        Ok(ExtraChannel(id))
    }

    /// Writes a prepared message at `step`, the one recorded last. `payload` is CDR with its 4 bytes of encapsulation.
    ///
    /// # Errors
    /// [`LogError::StepOrder`] for another step, [`LogError::Write`] if writing failed since the last call.
    pub fn write(&mut self, channel: ExtraChannel, step: u64, payload: &[u8]) -> Result<(), LogError> {
        self.check()?;
        let expected = self.last.unwrap_or(0);
        if self.last != Some(step) {
            return Err(LogError::StepOrder { expected, found: step });
        }
        self.batch.push_payload(channel.0, step, payload);
        Ok(())
    }

    /// Waits until the file holds all steps but the last [`UNSETTLED`].
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub(crate) fn settle(&self) -> Result<(), LogError> {
        let (answer, settled) = sync_channel(1);
        self.send(Job::Settle(answer))?;
        // The thread that does not answer has failed, which is told here.
        let _ = settled.recv();
        self.check()
    }

    /// Writes a metadata record; nothing in it may differ between two runs of the same thing.
    ///
    /// # Errors
    /// [`LogError::Write`] if writing failed since the last call.
    pub fn note(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.check()?;
        self.send_batch(true)?;
        self.send(Job::Metadata(name.into(), metadata.clone()))
    }

    /// Writes the rest and closes the file.
    ///
    /// # Errors
    /// [`LogError::Write`] if not everything could be written.
    pub fn finish(mut self) -> Result<Summary, LogError> {
        self.close()
    }

    fn close(&mut self) -> Result<Summary, LogError> {
        let sent = self.send_batch(true);
        self.jobs = None;
        let summary = self.writer.take().and_then(|writer| writer.join().ok().flatten());
        self.check()?;
        sent?;
        summary.ok_or_else(|| LogError::write(&self.path, io::Error::other("the writing thread ended early")))
    }

    fn send_batch(&mut self, ends_step: bool) -> Result<(), LogError> {
        if self.batch.is_empty() {
            return Ok(());
        }
        let mut batch = std::mem::replace(&mut self.batch, self.spare.try_recv().unwrap_or_default());
        batch.ends_step = ends_step;
        self.batch_steps = 0;
        self.send(Job::Batch(batch))
    }

    fn send(&self, job: Job) -> Result<(), LogError> {
        if self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok()) {
            return Ok(());
        }
        self.check()?;
        Err(LogError::write(&self.path, io::Error::other("the writing thread ended early")))
    }

    /// Reports what went wrong in the writer thread, now and at every later call.
    fn check(&self) -> Result<(), LogError> {
        match self.failure.get() {
            Some(source) => Err(LogError::Write { path: self.path.clone(), source: source.clone() }),
            None => Ok(()),
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // Nobody is left to hear of an error; whoever cares calls `finish`.
        let _ = self.close();
    }
}

/// What the writer thread owns.
struct Writing<W: Write> {
    sink: Sink<W>,
    queue: Receiver<Job>,
    used: Sender<Batch>,
    failure: Arc<OnceLock<Arc<io::Error>>>,
    path: PathBuf,
    period_ns: u64,
}

impl<W: Write> Writing<W> {
    /// Writes until there is nobody left to send; `None` if that failed.
    fn run(mut self) -> Option<Summary> {
        let summary = self.write().and_then(|()| self.sink.finish(self.path));
        // The queue closes after this, so that whoever finds it closed also finds the reason.
        summary.map_err(|error| self.failure.set(Arc::new(error))).ok()
    }

    fn write(&mut self) -> io::Result<()> {
        while let Ok(job) = self.queue.recv() {
            match job {
                Job::Batch(mut batch) => {
                    self.sink.batch(&batch, self.period_ns)?;
                    batch.clear();
                    // Fails if the recorder is closing, which needs no batch any more.
                    let _ = self.used.send(batch);
                }
                Job::Channel(schema, channel) => {
                    if let Some(schema) = schema {
                        self.sink.schema(&schema)?;
                    }
                    self.sink.channel(&channel)?;
                }
                // Whoever asked may have given up.
                Job::Settle(answer) => drop(answer.send(())),
                Job::Metadata(name, metadata) => self.sink.metadata(&name, &metadata)?,
            }
        }
        Ok(())
    }
}

fn schema_record(id: u16, name: &str, text: &str) -> SchemaRecord {
    SchemaRecord { id, name: name.into(), encoding: "ros2msg".into(), text: text.into() }
}

fn channel_record(id: u16, schema: u16, topic: &str) -> ChannelRecord {
    ChannelRecord { id, schema, topic: topic.into(), encoding: "cdr".into(), metadata: BTreeMap::new() }
}
