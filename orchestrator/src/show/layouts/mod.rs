//! Layouts for the viewers that people already have: which panels, with which topics of a run.

mod foxglove;
mod plotjuggler;
mod rerun;

use clap::ValueEnum;
use lockstep::Layout;

/// A viewer of logs that other people made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Viewer {
    /// A JSON file for Foxglove
    Foxglove,
    /// A JSON file for Lichtblick
    Lichtblick,
    /// An XML file for PlotJuggler
    Plotjuggler,
    /// A Python program that opens the log in Rerun
    Rerun,
}

/// A quantity that is plotted: a field that agents have alike.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    /// What it is, for people: `command input`.
    title: String,
    field: String,
    /// Numbers of a vector; `None` if it is a number itself.
    components: Option<usize>,
    /// Agents that have it, and the topic where.
    topics: Vec<(u32, String)>,
}

impl Group {
    /// Each component with what stands behind the name of the field: `[0]`, or nothing for a number.
    fn suffixes(&self) -> Vec<String> {
        self.components.map_or(vec![String::new()], |count| (0..count).map(|index| format!("[{index}]")).collect())
    }
}

/// The layout of `viewer` for a run with these channels (topic, agent, fields); `log` is where its log is or will be.
pub(crate) fn layout<'a>(
    viewer: Viewer,
    channels: impl IntoIterator<Item = (&'a str, u32, &'a Layout)>,
    log: &str,
) -> String {
    let groups = groups(channels);
    match viewer {
        Viewer::Foxglove | Viewer::Lichtblick => foxglove::layout(&groups),
        Viewer::Plotjuggler => plotjuggler::layout(&groups),
        Viewer::Rerun => rerun::script(&groups, log),
    }
}

/// What is worth a plot, the most telling first.
fn groups<'a>(channels: impl IntoIterator<Item = (&'a str, u32, &'a Layout)>) -> Vec<Group> {
    let mut found: Vec<(usize, Group)> = Vec::new();
    for (topic, agent, layout) in channels.into_iter().filter(|(_, agent, _)| *agent > 0) {
        let role = topic.rsplit('/').next().unwrap_or_default();
        for field in layout.fields() {
            let Some(rank) = rank(role, &field.name) else { continue };
            let title = format!("{role} {}", field.name.replace('_', " "));
            let components = match field.shape {
                lockstep::Shape::Scalar => None,
                lockstep::Shape::Vector(length) => Some(length),
            };
            let place = (agent, topic.to_string());
            match found.iter_mut().find(|(_, group)| group.title == title && group.components == components) {
                Some((_, group)) => group.topics.push(place),
                None => {
                    let field = field.name.clone();
                    found.push((rank, Group { title, field, components, topics: vec![place] }));
                }
            }
        }
    }
    // Stable: the order of the log among equals.
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, group)| group).collect()
}

/// How soon a field is shown; `None`: not at all.
fn rank(role: &str, field: &str) -> Option<usize> {
    let has = |word: &str| field.split('_').any(|part| part == word);
    match (role, field) {
        ("command", "input") => Some(1),
        ("state", "position") => Some(2),
        ("reference", "position") => Some(3),
        _ if has("error") => Some(0),
        _ if has("sliding") => Some(4),
        ("estimate", "disturbance") => Some(5),
        _ => None,
    }
}

/// The colour of an agent's curve: Okabe and Ito's, without black, which does not show on dark ground.
fn colour(agent: u32) -> &'static str {
    const COLOURS: [&str; 8] = ["#0072b2", "#e69f00", "#999999", "#56b4e9", "#d55e00", "#009e73", "#cc79a7", "#f0e442"];
    COLOURS[(agent as usize + COLOURS.len() - 1) % COLOURS.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lockstep::Field;

    #[test]
    fn telling_fields_come_first_and_agents_share_a_plot() {
        let state = Layout::new([Field::vector("position", 3, "m"), Field::vector("disturbance", 3, "N")]);
        let command = Layout::new([Field::vector("input", 2, "N"), Field::scalar("local_error", "")]);
        let channels =
            [("/agent_1/state", 1, &state), ("/agent_2/state", 2, &state), ("/agent_1/command", 1, &command)];
        let groups = groups(channels);
        let titles: Vec<&str> = groups.iter().map(|group| group.title.as_str()).collect();
        assert_eq!(titles, ["command local error", "command input", "state position"]);
        assert_eq!(groups[2].topics, [(1, "/agent_1/state".into()), (2, "/agent_2/state".into())]);
        assert_eq!(
            (groups[0].suffixes(), groups[1].suffixes()),
            (vec![String::new()], vec!["[0]".into(), "[1]".into()])
        );
    }
}
