//! A running simulation, monitored from outside: in the browser and in the terminal.
//!
//! [`RunMonitor`] looks at the samples of a run through a [`processes::Monitor`], which the run does not notice, and keeps
//! what it has seen, and what the log of the run says of the time before. [`Web`] shows that as the page of a report that grows, [`Screen`] on one screen of the terminal.

mod curves;
mod monitor;
mod past;
mod screen;
mod sparkline;
mod status;
mod web;

pub(crate) use monitor::{Errors, RunMonitor};
pub(crate) use past::NoPast;
pub(crate) use screen::Screen;
pub(crate) use status::LiveStatus;
pub(crate) use web::Web;
