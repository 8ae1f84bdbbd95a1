//! What is shown of a run: the quantities that a person looks at first, derived from whatever signals a log holds.
//!
//! - [`LoggedRun`] is a log with the scenario that it holds.
//! - [`panels`] derives the plots of a run; the report and the figures draw the same ones.
//! - [`Grid`] thins a run out without losing its extremes.
//!
//! Nothing here knows a scheme. A quantity is shown when the signals that it is made of are there.

mod events;
mod grid;
mod logged_run;
mod panel;
mod panels;
mod select;
mod space;

pub use events::{Link, links};
pub use grid::Grid;
pub use logged_run::LoggedRun;
pub use panel::{Curve, Kind, Limit, Panel, View};
pub use panels::panels;
pub use select::{Signal, signals, topics};
pub use space::Obstacle;
