//! Small projects for participants of one's own, with the signals of a scenario.

mod cpp;
mod order;
mod project;
mod python;
mod rust;
mod signals;
mod source;
mod vehicle;

pub use order::{Language, Order};
pub use project::create;
pub use vehicle::create_vehicle;

/// Puts values in the place of `{{key}}`.
fn fill(template: &str, values: &[(&str, String)]) -> String {
    values.iter().fold(template.to_string(), |text, (key, value)| text.replace(&format!("{{{{{key}}}}}"), value))
}
