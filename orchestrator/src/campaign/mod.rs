//! All scenarios of a catalog with all their variants, compared with their bands and claims: what `phalanx campaign` does.

mod campaign;
mod claims;
mod job;
mod table;

pub use campaign::{Campaign, Selected, run_all};
pub use claims::ClaimRow;
pub use job::{Job, JobResult};
pub use table::{as_json, as_markdown, as_text};
