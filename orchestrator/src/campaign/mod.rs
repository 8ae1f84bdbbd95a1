//! All scenarios of a catalog with all their variants, compared with their regression ranges, claims and the thesis: what `phalanx campaign` does.

mod claims;
mod job;
mod runs;
mod table;

pub use claims::ClaimRow;
pub use job::{Job, JobResult};
pub use runs::{Campaign, Selected, run_all};
pub use table::{as_json, as_markdown, as_text};
