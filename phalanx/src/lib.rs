//! Phalanx with schemes of your own: [`main`] with a [`Catalog`] is the whole program.
//!
//! ```no_run
//! use formation::wiring::Role;
//! use phalanx::{Catalog, MetricSet};
//!
//! fn main() -> std::process::ExitCode {
//!     let mut catalog: Catalog = phalanx::thesis::catalog();
//!     // catalog.roles.add(Role::Controller, [Kind::of::<Mine>("mine", "what it does")]);
//!     // catalog.scenarios.push(...); catalog.metrics.push(...);
//!     phalanx::main(&catalog)
//! }
//! ```
//!
//! `examples/own-catalog` is a complete package.

pub use formation;
pub use formation::scenario::Shipped;
pub use formation::shipped;
pub use formation::wiring::{Kind, Role, Roles};
pub use lockstep;
pub use orchestrator;
pub use orchestrator::catalog::Catalog;
pub use orchestrator::cli::main;
pub use orchestrator::judge::metrics::{DerivedSignal, Metric, MetricError, MetricSet, Run};
pub use thesis;
