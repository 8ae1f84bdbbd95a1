//! What a person or another tool sees of a run: report, figures, exports, layouts, live view.

pub(crate) mod drawing;
pub(crate) mod export;
pub(crate) mod figures;
pub mod glossary;
pub(crate) mod layouts;
pub mod report;
pub mod schema;
pub mod traffic;
pub mod view;
pub(crate) mod watch;
