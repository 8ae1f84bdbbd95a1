//! From a scenario file to a run, its log, and what comes out of it: the framework behind the program `phalanx`.
//!
//! It knows no scheme: [`main`] is given a [`Catalog`]. So a program with schemes of your own is
//!
//! ```no_run
//! fn main() -> std::process::ExitCode {
//!     let mut catalog = orchestrator::Catalog::empty();
//!     // catalog.roles.add(Role::Controller, [Kind::of::<Mine>("mine", "what it does")]);
//!     // catalog.scenarios.push(...); catalog.metrics.push(...);
//!     orchestrator::main(&catalog)
//! }
//! ```
//!
//! `examples/own-catalog` is a complete package.
//!
//! | module | what it does |
//! |---|---|
//! | [`cli`], `commands` | the command line, one file a command |
//! | `files` | files that commands write, besides logs |
//! | [`run`] | carries out one run: processes, control, observers of a step, recovery |
//! | [`recorded`] | a recorded run as an input: its scenario, its samples |
//! | [`trial`] | tries a user's program: replay, conformance test, project templates |
//! | [`judge`] | what a run is worth: metrics, assertions, claims, verdict |
//! | [`show`] | what a person sees: report, figures, exports, live view |
//! | [`catalog`] | what a program brings along: components, scenarios, metrics, figures |
//! | [`campaign`] | all scenarios of a catalog with all variants, their regression ranges and claims |

// First, so that its macros are known in all that follows.
#[macro_use]
mod terminal;

pub mod campaign;
pub mod catalog;
pub mod cli;
mod commands;
pub mod failure;
mod files;
pub mod judge;
pub mod logging;
pub mod recorded;
pub mod run;
pub mod show;
pub mod trial;
mod unanswered;

pub use catalog::Catalog;
pub use cli::main;
pub use formation;
pub use lockstep;
