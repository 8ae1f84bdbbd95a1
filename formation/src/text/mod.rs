//! Texts of messages: the name that was meant, and long texts cut short.

mod brief;
mod nearest;
mod signal_name;

pub(crate) use brief::{around, readable_problem};
pub use brief::{brief, readable};
pub(crate) use nearest::suggestion;
pub use nearest::{did_you_mean, nearest};
pub use signal_name::is_signal_name;
