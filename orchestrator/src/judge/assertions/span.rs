//! Numbers of a channel that a signal names.

use formation::config::did_you_mean;
use formation::wiring::{Assembly, Role};
use lockstep::ChannelId;

/// Consecutive words of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    channel: ChannelId,
    offset: usize,
    pub(super) length: usize,
}

impl Span {
    /// A whole field of a topic of the agent at this place.
    pub(super) fn find(assembly: &Assembly, agent: usize, topic: &str, field: &str) -> Result<Self, String> {
        let Some(role) = Role::ALL.into_iter().find(|role| role.channel() == topic) else {
            let topics = Role::ALL.map(Role::channel);
            let (known, hint) = (topics.join(", "), did_you_mean(topic, topics));
            return Err(format!("no topic of an agent is called `{topic}`, expected one of {known}{hint}"));
        };
        let wanted = format!("/agent_{}/{topic}", agent + 1);
        let channels = &assembly.network.channels;
        // A role publishes for all agents in a row.
        let agents = assembly.scenario.context.agents.len().max(1);
        let mut of_agent = (agent..channels.len()).step_by(agents);
        let found = of_agent.find(|&channel| channels[channel].topic == wanted);
        let Some(channel) = found.or_else(|| channels.iter().position(|channel| channel.topic == wanted)) else {
            return Err(format!("{wanted} is not published: this scenario has no {role}"));
        };
        let layout = &channels[channel].layout;
        let Some((offset, length)) = layout.find(field) else {
            let names: Vec<&str> = layout.fields().iter().map(|field| field.name.as_str()).collect();
            let hint = did_you_mean(field, names.iter().copied());
            return Err(format!("{wanted} has no field `{field}`, only {}{hint}", names.join(", ")));
        };
        Ok(Self { channel: ChannelId(channel), offset, length })
    }

    /// Of each link to the agent at this place, age, messages sent and messages lost; a reason if there is none.
    pub(super) fn of_links(assembly: &Assembly, agent: usize) -> Result<Vec<[Self; 3]>, String> {
        let stem = format!("/agent_{}/from_", agent + 1);
        let channels = assembly.network.channels.iter().enumerate();
        let links = channels.filter(|(_, channel)| channel.topic.starts_with(&stem)).filter_map(|(place, channel)| {
            let field = |name: &str| {
                let (offset, length) = channel.layout.find(name)?;
                Some(Self { channel: ChannelId(place), offset, length })
            };
            Some([field("link_age")?, field("link_sent")?, field("link_lost")?])
        });
        if !assembly.network.channels.iter().any(|channel| channel.topic.contains("/from_")) {
            return Err("there are no links: a section `[links]` with readers of other agents makes them".into());
        }
        Ok(links.collect())
    }

    /// At most this many words from its start.
    pub(super) fn first(self, length: usize) -> Self {
        Self { length: self.length.min(length), ..self }
    }

    /// Its words from `first` up to but not including `end`, both counted from its start and within it.
    pub(super) fn part(self, first: usize, end: usize) -> Self {
        Self { offset: self.offset + first, length: end - first, ..self }
    }

    /// Words of the first channel.
    #[cfg(test)]
    pub(super) fn of_test(offset: usize, length: usize) -> Self {
        Self { channel: ChannelId(0), offset, length }
    }

    /// Its words in this step.
    pub(super) fn of<'s>(&self, sample: &impl Fn(ChannelId) -> &'s [f64]) -> &'s [f64] {
        &sample(self.channel)[self.offset..self.offset + self.length]
    }
}
