//! The text of a signal to a formula over slots, and what fills the slots at every step.

use formation::config::nearest;
use formation::formula::{Expression, Formula, Operand};
use formation::wiring::{Assembly, Role};
use lockstep::ChannelId;

use super::geometry::{Geometry, METRICS, Nearest};
use super::scan::scan;

/// Consecutive words of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    channel: ChannelId,
    offset: usize,
    pub(super) length: usize,
}

/// How a vector becomes a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fold {
    Norm,
    Peak,
    Largest,
    Smallest,
}

/// What a slot of a formula holds.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    Time,
    Word(Span),
    Folded(Fold, Span, Option<Span>),
    Nearest(Nearest),
}

/// What is wrong with a signal, and at which byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Mistake {
    pub(super) offset: usize,
    pub(super) message: String,
}

impl Span {
    /// A whole field of a topic of the agent at this place.
    pub(super) fn find(assembly: &Assembly, agent: usize, topic: &str, field: &str) -> Result<Self, String> {
        let hint = |found: Option<&str>| found.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        let Some(role) = Role::ALL.into_iter().find(|role| role.channel() == topic) else {
            let topics = Role::ALL.map(Role::channel);
            let near = hint(nearest(topic, topics));
            return Err(format!(
                "no topic of an agent is called `{topic}`, expected one of {}{near}",
                topics.join(", ")
            ));
        };
        let wanted = format!("/agent_{}/{topic}", agent + 1);
        let channels = &assembly.network.channels;
        let Some(channel) = channels.iter().position(|channel| channel.topic == wanted) else {
            return Err(format!("nobody publishes {wanted}: this scenario has no {role}"));
        };
        let layout = &channels[channel].layout;
        let Some((offset, length)) = layout.find(field) else {
            let names: Vec<&str> = layout.fields().iter().map(|field| field.name.as_str()).collect();
            let near = hint(nearest(field, names.iter().copied()));
            return Err(format!("{wanted} has no field `{field}`, only {}{near}", names.join(", ")));
        };
        Ok(Self { channel: ChannelId(channel), offset, length })
    }

    /// At most this many words from its start.
    pub(super) fn first(self, length: usize) -> Self {
        Self { length: self.length.min(length), ..self }
    }

    /// Its words from `first` up to but not including `end`, both counted from its start and within it.
    pub(super) fn part(self, first: usize, end: usize) -> Self {
        Self { offset: self.offset + first, length: end - first, ..self }
    }

    /// Its words in this step.
    pub(super) fn of<'s>(&self, sample: &impl Fn(ChannelId) -> &'s [f64]) -> &'s [f64] {
        &sample(self.channel)[self.offset..self.offset + self.length]
    }
}

impl Fold {
    pub(super) const ALL: [(&str, Fold); 4] =
        [("norm", Fold::Norm), ("peak", Fold::Peak), ("largest", Fold::Largest), ("smallest", Fold::Smallest)];

    fn of(self, values: impl Iterator<Item = f64>) -> f64 {
        match self {
            Fold::Norm => values.map(|value| value * value).sum::<f64>().sqrt(),
            Fold::Peak => values.fold(0.0, |peak, value| peak.max(value.abs())),
            Fold::Largest => values.fold(f64::NEG_INFINITY, f64::max),
            Fold::Smallest => values.fold(f64::INFINITY, f64::min),
        }
    }
}

impl Slot {
    /// What it holds at `time`, in s.
    pub(super) fn value<'s>(&self, time: f64, sample: &impl Fn(ChannelId) -> &'s [f64]) -> f64 {
        match self {
            Slot::Time => time,
            Slot::Word(span) => span.of(sample)[0],
            Slot::Folded(fold, span, None) => fold.of(span.of(sample).iter().copied()),
            Slot::Folded(fold, span, Some(less)) => {
                fold.of(span.of(sample).iter().zip(less.of(sample)).map(|(a, b)| a - b))
            }
            Slot::Nearest(nearest) => nearest.value(sample),
        }
    }
}

/// Compiles the signal `text` of the agent at this place.
///
/// # Errors
/// The first [`Mistake`].
pub(super) fn compile(
    text: &str,
    assembly: &Assembly,
    geometry: &Geometry,
    agent: usize,
) -> Result<(Formula, Vec<Slot>), Mistake> {
    let (rewritten, mut slots) = scan(text, assembly, agent)?;
    let references = slots.len();
    let mut reason = None;
    let compiled = Expression::parse(&rewritten).and_then(|expression| {
        expression.compile(|name| {
            if let Some(index) = name.strip_prefix('_') {
                return index.parse().ok().filter(|index| *index < references).map(Operand::Slot);
            }
            let slot = match metric(name, assembly, geometry, agent) {
                _ if name == "t" => Slot::Time,
                Some(Ok(slot)) => slot,
                Some(Err(why)) => {
                    reason.get_or_insert(why);
                    return None;
                }
                None => return constant(name, assembly, agent).map(Operand::Constant),
            };
            slots.push(slot);
            Some(Operand::Slot(slots.len() - 1))
        })
    });
    match compiled {
        Ok(formula) => Ok((formula, slots)),
        Err(error) => {
            let unknown: String = text[error.offset.min(text.len())..]
                .chars()
                .take_while(|character| character.is_ascii_alphanumeric() || *character == '_')
                .collect();
            let names = METRICS.iter().map(|(name, _)| *name).chain(Fold::ALL.map(|(name, _)| name)).chain(["t", "UM"]);
            let hint = nearest(&unknown, names).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            let message = reason.unwrap_or_else(|| format!("{}{hint}", error.message));
            Err(Mistake { offset: error.offset, message })
        }
    }
}

/// The value of a name that does not vary during a run.
pub(super) fn constant(name: &str, assembly: &Assembly, agent: usize) -> Option<f64> {
    let context = &assembly.scenario.context;
    if name == "UM" {
        return context.input_limit;
    }
    context.constant(&context.agents[agent], name)
}

/// A metric by its name; a reason if the scenario lacks what it needs.
fn metric(name: &str, assembly: &Assembly, geometry: &Geometry, agent: usize) -> Option<Result<Slot, String>> {
    if name == "tracking" {
        let find = |topic, field| Span::find(assembly, agent, topic, field);
        let place = find("reference", "desired_position").or_else(|_| find("reference", "position"));
        let slot = find("state", "position").and_then(|own| Ok(Slot::Folded(Fold::Norm, own, Some(place?))));
        return Some(slot);
    }
    Nearest::named(name, assembly, geometry, agent).map(|nearest| nearest.map(Slot::Nearest))
}
