//! The log of a run: one MCAP file that every ROS 2 tool opens, written and read without the program `phalanx`.
//!
//! - [`Recorder`] writes it while the run goes on; the same run gives the same bytes. [`LogPlace`] keeps two runs from writing
//!   into one file.
//! - [`Log`] reads it back whole, [`Stream`] step by step, both also if the run goes on or was killed.
//! - [`recover()`] turns the log of a killed run into a finished file, for viewers that refuse a file without an end.
//! - [`compare()`] finds where two logs differ, [`file_digest`] gives the SHA-256 of a file.
//! - [`Cdr`] and [`definitions`] write messages of standard ROS 2 types, for channels of one's own.
//!
//! A sample is stored as CDR, which is what a [`lockstep::Layout`] lays out already. The schema next to it says what the
//! bytes mean, so that a log is read by other programs, too.
//!
//! This crate uses `lockstep` for the samples and `filesystem` for locks. It does not depend on iceoryx2, on scenarios, or on the
//! command line.
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use lockstep::{Channel, ChannelId, Field, Header, Layout, Network, Period, Status, Store};
//! use recording::{DEFAULT_FLUSH_EVERY, Log, Recorder, RunInfo};
//!
//! let layout = Layout::new([Field::vector("position", 2, "m")]);
//! let channel = Channel { topic: "/agent_1/state".into(), agent: 1, layout, initial: vec![] };
//! let network = Network { channels: vec![channel], ..Network::default() };
//! let period = Period::from_seconds(0.01).expect("a period");
//! let metadata = BTreeMap::from([("scenario".to_string(), "circle".to_string())]);
//! let run =
//!     RunInfo { network: &network, period, scenario: "", metadata: &metadata, flush_every: DEFAULT_FLUSH_EVERY };
//!
//! let path = std::env::temp_dir().join(format!("circle-{}.mcap", std::process::id()));
//! let mut recorder = Recorder::create(&path, &run)?;
//! let mut store = Store::of(&network);
//! for step in 0..100 {
//!     let angle = period.time(step);
//!     store.write(ChannelId(0), step).copy_from_slice(&[angle.cos(), angle.sin()]);
//!     recorder.record(step, &store, |_| Header::new(step, period, 1, Status::Fresh))?;
//! }
//! recorder.finish()?;
//!
//! let log = Log::open(&path)?;
//! let position = log.signal("/agent_1/state", "position").expect("it was recorded");
//! assert_eq!(log.steps(), 0..100);
//! assert_eq!(position.row(0), [1.0, 0.0]);
//! # std::fs::remove_file(&path).expect("it is removed");
//! # Ok::<(), recording::LogError>(())
//! ```

mod cdr;
mod chunk;
mod compare;
pub mod definitions;
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

pub use cdr::Cdr;
pub use compare::{Comparison, Difference, compare, ulps};
pub use digest::file_digest;
pub use error::LogError;
pub use past::play_log;
pub use place::{LogPlace, is_being_written, starts_as_log};
pub use reader::{Log, LogChannel, Unfinished};
pub use recorder::{DEFAULT_FLUSH_EVERY, ExtraChannel, Recorder, RunInfo, UNSETTLED};
pub use recover::{Recovered, recover};
pub use ros::Durability;
pub use schema::own_type;
pub use series::Series;
pub use sink::Summary;
pub use stream::{Head, Stream};

#[cfg(test)]
mod tests;

/// Name of the attachment that holds the effective scenario.
const SCENARIO: &str = "scenario.toml";
/// What the names of attachments that are data files of the scenario begin with.
const DATA: &str = "data/";
/// Name of the metadata record that holds what the caller says about the run.
const METADATA: &str = "phalanx";
/// Name of the metadata records that say what played a participant in the place of Phalanx.
pub const PLAYER: &str = "phalanx-player";
/// What stands before the header of every message: CDR, little-endian, no options.
pub const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
