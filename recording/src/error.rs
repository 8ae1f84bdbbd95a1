//! What can go wrong with a log, in words for its reader.

use std::path::{Path, PathBuf};
use std::{io, sync::Arc};

/// Why a log could not be written or read.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LogError {
    /// The file could not be created or written: no space, no permission.
    #[error("cannot write log {}: {source}", .path.display())]
    Write {
        /// The log.
        path: PathBuf,
        /// What the operating system says.
        source: Arc<io::Error>,
    },
    /// Another process writes a log there.
    #[error("cannot write log {}: {writer} is writing it; wait for its end, or name another file", .path.display())]
    Busy {
        /// The log.
        path: PathBuf,
        /// Which process.
        writer: String,
    },
    /// A log cannot stand there.
    #[error("cannot write log {}: {what}; name another file", .path.display())]
    NoPlace {
        /// Where.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The file could not be opened or read.
    #[error("cannot read log {}: {source}", .path.display())]
    Read {
        /// The log.
        path: PathBuf,
        /// What the operating system says.
        source: Arc<io::Error>,
    },
    /// The file is no MCAP file at all.
    #[error("{} is not an MCAP file: {what}; give a log that `phalanx` recorded", .path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        what: &'static str,
    },
    /// The file is MCAP, but of another program.
    #[error(
        "{} is an MCAP file, but not of this program: it has neither metadata `phalanx` nor a channel with the sample \
         header; give a log that `phalanx` recorded",
        .path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The file is MCAP of another writer, whose compression is not read.
    #[error(
        "{} is an MCAP file, but not a log of Phalanx: its chunks are compressed with {compression:?}, those of Phalanx with \
         \"zstd\"; give a log that `phalanx` recorded",
        .path.display()
    )]
    Compression {
        /// The file.
        path: PathBuf,
        /// The compression.
        compression: String,
    },
    /// The file contradicts itself: bits were flipped, or it was edited.
    #[error(
        "log {} is damaged at byte {at}: {what}; `phalanx recover` keeps what stands before that place",
        .path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Offset of the record (or of the chunk that holds it), bytes.
        at: u64,
        /// What is wrong there.
        what: String,
    },
    /// A sample is missing, doubled, or out of order.
    #[error("log {}: topic {topic} lacks its sample of step {expected}: {found}", .path.display())]
    Step {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The step whose sample was due.
        expected: u64,
        /// What came instead.
        found: String,
    },
    /// Samples of a channel do not have the shape that its schema promises.
    #[error("log {}: topic {topic}: {what}", .path.display())]
    Topic {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What is wrong with it.
        what: String,
    },
    /// A layout that cannot be written as a ROS 2 message.
    #[error(
        "topic {topic} cannot be logged: its layout is no valid ROS 2 message; field names are lower-case letters, \
         digits and single underscores, differ from each other and from stamp, step, agent and status, vectors have 1 \
         to {} values, units are one line",
        super::schema::WORDS_MAX
    )]
    Layout {
        /// The topic.
        topic: String,
    },
    /// Two definitions for one type name: a reader of the file could not tell which one holds.
    #[error("schema {name} is already defined in this log, with another text")]
    SchemaConflict {
        /// The type name.
        name: String,
    },
    /// MCAP numbers channels and schemas with 16 bits.
    #[error("a log holds at most 65535 channels and schemas")]
    TooManyChannels,
    /// The caller skipped or repeated a step.
    #[error("step {found} was given to the log where step {expected} was due")]
    StepOrder {
        /// The step that was due.
        expected: u64,
        /// The step that was given.
        found: u64,
    },
    /// Source and target of a recovery are the same file.
    #[error("cannot recover {} into itself; name another file for the result", .path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
}

impl LogError {
    pub(super) fn write(path: &Path, source: io::Error) -> Self {
        Self::Write { path: path.into(), source: Arc::new(source) }
    }

    pub(super) fn read(path: &Path, source: io::Error) -> Self {
        Self::Read { path: path.into(), source: Arc::new(source) }
    }

    pub(super) fn damaged(path: &Path, at: u64, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.into(), at, what: what.into() }
    }
}
