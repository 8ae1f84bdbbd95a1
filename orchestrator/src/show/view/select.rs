//! From what a person types to signals of a log.

use formation::config::did_you_mean;

use crate::failure::Failure;
use recording::{Log, LogChannel};

/// A field of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The topic.
    pub topic: String,
    /// The field.
    pub field: String,
    /// One of its components, from 0; `None`: all.
    pub component: Option<usize>,
}

/// Whether `text` is what `pattern` means; `*` stands for anything.
fn matches(pattern: &str, text: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == text,
        Some((start, rest)) => text.strip_prefix(start).is_some_and(|text| {
            text.char_indices().map(|(at, _)| at).chain([text.len()]).any(|at| matches(rest, &text[at..]))
        }),
    }
}

/// The topics that `pattern` means, in the order of the log; the slash in front may be left out.
///
/// # Errors
/// [`Failure::Usage`] if no topic matches.
pub fn topics<'a>(log: &'a Log, pattern: &str) -> Result<Vec<&'a LogChannel>, Failure> {
    let wanted = pattern.trim_start_matches('/');
    let bare = |channel: &LogChannel| channel.topic.trim_start_matches('/').to_string();
    let known = || log.channels().iter().filter(|channel| channel.layout.is_some());
    let found: Vec<&LogChannel> = known().filter(|channel| matches(wanted, &bare(channel))).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let mut others = log.channels().iter().filter(|channel| channel.layout.is_none());
    if let Some(channel) = others.find(|channel| matches(wanted, &bare(channel))) {
        let kind = if channel.schema.is_empty() { "without a type" } else { channel.schema.as_str() };
        return Err(Failure::Usage(format!(
            "{} in {} holds {} messages {kind}, which are no samples of numbers: Foxglove, Lichtblick, PlotJuggler and `rosbags` \
             show them",
            channel.topic,
            log.path().display(),
            channel.messages
        )));
    }
    let names: Vec<String> = known().map(bare).collect();
    let hint = did_you_mean(wanted, names.iter().map(String::as_str));
    Err(Failure::Usage(format!(
        "no topic of {} is called {wanted}{hint}; `phalanx info` lists all",
        log.path().display()
    )))
}

/// The signals that `text` means: `agent_1/state/position`, `agent_*/command/input[0]`.
///
/// # Errors
/// [`Failure::Usage`] if no signal matches, or a component is asked for that a field does not have.
pub fn signals(log: &Log, text: &str) -> Result<Vec<Signal>, Failure> {
    let malformed =
        || Failure::Usage(format!("{text}: expected TOPIC/FIELD or TOPIC/FIELD[K], as in agent_1/state/position[2]"));
    let (path, component) = match text.strip_suffix(']').and_then(|text| text.split_once('[')) {
        Some((path, number)) => (path, Some(number.parse::<usize>().map_err(|_| malformed())?)),
        None => (text, None),
    };
    let (topic, field) = path.rsplit_once('/').ok_or_else(malformed)?;
    let mut found = Vec::new();
    let mut fields: Vec<&str> = Vec::new();
    for channel in topics(log, topic)? {
        for known in channel.layout.iter().flat_map(|layout| layout.fields()) {
            fields.push(&known.name);
            if !matches(field, &known.name) {
                continue;
            }
            let length = known.shape.words();
            if let Some(component) = component.filter(|component| *component >= length) {
                let name = format!("{}/{}", channel.topic.trim_start_matches('/'), known.name);
                return Err(Failure::Usage(format!(
                    "{name} has no component [{component}]: its {length} components are counted from 0"
                )));
            }
            found.push(Signal { topic: channel.topic.clone(), field: known.name.clone(), component });
        }
    }
    if found.is_empty() {
        fields.dedup();
        let hint = did_you_mean(field, fields.iter().copied());
        let all = fields.join(", ");
        return Err(Failure::Usage(format!("{topic} has no field {field}, expected one of {all}{hint}")));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_anything() {
        assert!(
            matches("agent_*/state", "agent_12/state") && matches("*", "") && matches("*/command", "agent_1/command")
        );
        assert!(matches("a*c*", "abcde") && !matches("agent_*/state", "agent_1/reference") && !matches("a", "ab"));
    }
}
