//! All scenarios with all variants, held against the thesis: what `phalanx thesis` does.

mod campaign;
mod claims;
mod job;
mod table;

pub use campaign::{Campaign, Selected, run_all};
pub use claims::ClaimRow;
pub use job::{Job, JobResult};
pub use table::{as_json, as_markdown, as_text};
