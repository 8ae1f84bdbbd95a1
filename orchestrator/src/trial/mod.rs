//! Trying a user's program: against a recording, against its contract, and from a template.

pub mod conform;
pub mod replay;
pub mod scaffold;
