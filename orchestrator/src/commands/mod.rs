//! The commands of the program, a file each.

pub(crate) mod bridge;
pub(crate) mod check;
pub(crate) mod conform;
pub(crate) mod ctl;
pub(crate) mod doctor;
pub(crate) mod echo;
pub(crate) mod export;
pub(crate) mod graph;
pub(crate) mod info;
pub(crate) mod layout;
pub(crate) mod list;
pub(crate) mod man;
pub(crate) mod new;
pub(crate) mod participant;
pub(crate) mod plot;
pub(crate) mod profile;
pub(crate) mod recover;
pub(crate) mod replay;
pub(crate) mod report;
pub(crate) mod robot;
pub(crate) mod run;
pub(crate) mod schema;
mod select;
mod select_run;
pub(crate) mod thesis;
pub(crate) mod top;
pub(crate) mod validate;
pub(crate) mod verify;
pub(crate) mod watch;

pub(crate) use select::scenario_of;
