//! The log of a run: one MCAP file that every ROS 2 tool opens.
//!
//! - [`Recorder`] writes it while the run goes on; the same run gives the same bytes.
//! - [`Log`] reads it back, also if the run was killed in the middle of it.
//! - [`recover`] turns the log of a killed run into a finished file, for viewers that refuse a cut one.
//!
//! A sample is stored as CDR, which is what a [`lockstep::Layout`] lays out already. The schema next to it says what the
//! bytes mean, so a log needs no program of ours to be read.

mod cdr;
mod chunk;
mod compare;
pub(crate) mod definitions;
mod digest;
mod encode;
mod error;
mod header;
mod live;
mod numbers;
mod output;
mod past;
mod pipeline;
mod place;
mod reader;
mod record;
mod recorder;
mod recover;
mod ros;
mod schema;
mod series;
mod sink;
mod stream;
mod summary;
mod target;
mod walk;

pub(crate) use cdr::Cdr;
pub use compare::{Comparison, Difference, compare, ulps};
pub(crate) use digest::file_digest;
pub use error::LogError;
pub(crate) use past::play_log;
pub use place::{LogPlace, is_same_file};
pub(crate) use place::{draft_name, draft_of, follow, is_being_written, starts_as_log};
pub use reader::{Log, LogChannel, Unfinished};
pub(crate) use recorder::UNSETTLED;
pub use recorder::{DEFAULT_FLUSH_EVERY, ExtraChannel, Recorder, RunInfo};
pub use recover::{Recovered, recover};
pub use ros::Lasting;
pub(crate) use schema::own_type;
pub use series::Series;
pub use sink::Summary;
pub use stream::{Head, Stream};

#[cfg(test)]
mod tests;

/// Name of the attachment that holds the effective scenario.
const SCENARIO: &str = "scenario.toml";
/// Name of the metadata record that holds what the caller says about the run.
const METADATA: &str = "phalanx";
/// Name of the metadata records that say what played a participant in the place of Phalanx.
pub(crate) const PLAYER: &str = "phalanx-player";
/// What stands before the header of every message: CDR, little-endian, no options.
pub(crate) const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
