//! A run while it is going on, seen from outside: for the browser and for the terminal.
//!
//! [`Spectator`] looks at the samples of a run through a [`processes::Monitor`], which the run does not notice, and keeps
//! what it has seen. [`Web`] shows that as the page of a report that grows, [`Screen`] on one screen of the terminal.

mod screen;
mod sparkline;
mod spectator;
mod status;
mod web;

pub(crate) use screen::Screen;
pub(crate) use spectator::Spectator;
pub(crate) use status::Pulse;
pub(crate) use web::Web;
