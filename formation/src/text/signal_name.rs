//! Names of signals.

/// Whether `name` can be a field of a ROS 2 message, as all signals are: lower-case letters, digits and single `_` inside,
/// beginning with a letter.
pub fn is_signal_name(name: &str) -> bool {
    let letters = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    letters && name.starts_with(|c: char| c.is_ascii_lowercase()) && !name.ends_with('_') && !name.contains("__")
}
