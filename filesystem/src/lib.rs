//! Names, locks and temporary folders in the file system, for programs whose files must survive ordinary mistakes.
//!
//! - [`HeldDirectory`]: a folder that a process holds while it lives; what a killed process has left is swept.
//! - [`lock_holder`], [`holder`]: which process holds the lock of a file.
//! - [`follow`], [`is_same_file`]: whether two paths mean one file, by links and hard links too.
//! - [`draft_name`], [`draft_of`]: the name under which a file grows until it takes its place.
//!
//! Linux only. It knows nothing of Phalanx, so that the log is read and written without the rest of it.

mod held;
mod lock;
mod names;

pub use held::{Found, HeldDirectory, is_at, open_own};
pub use lock::{holder, lock_holder};
pub use names::{draft_name, draft_of, follow, is_same, is_same_file};
