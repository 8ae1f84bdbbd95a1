//! Making a finished file out of the log of a killed run.

use std::path::Path;

use filesystem::is_same_file;

use super::LogError;
use super::place::LogPlace;
use super::record::Record;
use super::sink::{ChannelRecord, Refusal, SchemaRecord, Sink, Summary};
use super::target::LogFile;
use super::walk::{Ending, walk};

/// What [`recover`] saved.
#[derive(Clone, Debug)]
pub struct Recovered {
    /// The new file.
    pub file: Summary,
    /// Channels in it.
    pub channels: u64,
    /// Attachments in it.
    pub attachments: u64,
    /// Metadata records in it.
    pub metadata: u64,
    /// Whether the source was a finished file already.
    pub was_complete: bool,
    /// Where the source is damaged, if it is more than cut; what stands behind that place is not in the new file.
    pub damage: Option<LogError>,
    /// Bytes at the end of the source that are not in the new file, because they are no whole record or are damaged.
    pub lost: u64,
    /// Simulated time of the last message, ns; `None` if there is none.
    pub until_ns: Option<u64>,
}

/// Copies all that is whole in the log `path` into a new file `out`, which takes the place of a log of that name when it is done.
///
/// # Errors
/// [`LogError::SameFile`] if both are one file, those of [`LogPlace::claim`], [`LogError::Read`] and [`LogError::NotMcap`] for the source,
/// [`LogError::Write`] for the result.
pub fn recover(path: &Path, out: &Path) -> Result<Recovered, LogError> {
    if is_same_file(path, out) {
        return Err(LogError::SameFile { path: path.into() });
    }
    let mut copy = Copy { path, out, sink: None, channels: 0, attachments: 0, metadata: 0, until_ns: None };
    let (ending, damage) = match walk(path, |at, record| copy.take(at, record)) {
        Ok(ending) => (ending, None),
        Err(LogError::Damaged { path, at, what }) => (Ending::Cut { at }, Some(LogError::Damaged { path, at, what })),
        Err(other) => return Err(other),
    };
    let length = std::fs::metadata(path).map_err(|error| LogError::read(path, error))?.len();
    let lost = match ending {
        Ending::Complete => 0,
        Ending::Cut { at } => length.saturating_sub(at),
    };
    let was_complete = ending == Ending::Complete;
    let empty = LogError::NotMcap { path: path.into(), what: "it ends within its header" };
    let sink = copy.sink.ok_or(empty)?;
    let failed = |source| LogError::Write { path: out.into(), source };
    let (file, written) = sink.finish(out.into());
    written.map_err(failed)?;
    let nothing =
        || LogError::NoPlace { path: out.into(), what: format!("{} holds no step to replace it with", path.display()) };
    let file = file.ok_or_else(nothing)?;
    let Copy { channels, attachments, metadata, until_ns, .. } = copy;
    Ok(Recovered { file, channels, attachments, metadata, was_complete, damage, lost, until_ns })
}

/// A copy in progress.
struct Copy<'a> {
    path: &'a Path,
    out: &'a Path,
    /// There from the header on, which says what the new header says.
    sink: Option<Sink<LogFile>>,
    channels: u64,
    attachments: u64,
    metadata: u64,
    until_ns: Option<u64>,
}

impl Copy<'_> {
    fn take(&mut self, at: u64, record: Record<'_>) -> Result<(), LogError> {
        if let Record::Header { profile, library } = record {
            if self.sink.is_some() {
                return Err(LogError::damaged(self.path, at, "there is a second header"));
            }
            let place = LogPlace::claim(self.out)?;
            // Chunks are copied one by one, so there is nothing to show in between.
            let sink = LogFile::new(place).and_then(|file| Sink::new(file, profile, library));
            self.sink = Some(sink.map_err(|error| LogError::write(self.out, error))?);
            return Ok(());
        }
        let Some(sink) = &mut self.sink else {
            return Err(LogError::damaged(self.path, at, "a record stands before the header"));
        };
        let copied = match record {
            Record::Header { .. } => Ok(()),
            Record::Schema { id, name, encoding, text } => {
                sink.schema(SchemaRecord { id, name: name.into(), encoding: encoding.into(), text: text.into() })
            }
            Record::Channel { id, schema, topic, encoding, metadata } => {
                self.channels += 1;
                let (topic, encoding) = (topic.into(), encoding.into());
                sink.channel(ChannelRecord { id, schema, topic, encoding, metadata })
            }
            Record::Message { channel, sequence, log_time, publish_time, data } => {
                self.until_ns = self.until_ns.max(Some(log_time));
                sink.message(channel, sequence, [log_time, publish_time], data)
            }
            Record::Attachment { name, media_type, data } => {
                self.attachments += 1;
                sink.attach(name, media_type, data)
            }
            Record::Metadata { name, metadata } => {
                self.metadata += 1;
                sink.metadata(name, &metadata)
            }
            Record::ChunkEnd => sink.flush(),
        };
        copied.map_err(|refusal| match refusal {
            Refusal::Contradiction(what) => LogError::damaged(self.path, at, what),
            Refusal::Write(source) => LogError::Write { path: self.out.into(), source },
        })
    }
}
