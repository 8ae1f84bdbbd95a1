//! The text of a signal to a formula over slots, and what fills the slots at every step.

use formation::config::nearest;
use formation::formula::{Expression, Formula, Operand};
use formation::wiring::{Assembly, Role};
use lockstep::ChannelId;

use super::geometry::{METRICS, Nearest};

/// Most references to fields in one signal; keeps the names of slots shorter than what they stand for.
const MOST_SLOTS: usize = 64;

/// Consecutive words of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    channel: ChannelId,
    offset: usize,
    length: usize,
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

    /// Its words in this step.
    pub(super) fn of<'s>(&self, sample: &impl Fn(ChannelId) -> &'s [f64]) -> &'s [f64] {
        &sample(self.channel)[self.offset..self.offset + self.length]
    }
}

impl Fold {
    const ALL: [(&str, Fold); 4] =
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
pub(super) fn compile(text: &str, assembly: &Assembly, agent: usize) -> Result<(Formula, Vec<Slot>), Mistake> {
    let mut scanner =
        Scanner { text, at: 0, rewritten: String::with_capacity(text.len()), slots: Vec::new(), assembly, agent };
    scanner.scan()?;
    let Scanner { rewritten, mut slots, .. } = scanner;
    let references = slots.len();
    let mut reason = None;
    let compiled = Expression::parse(&rewritten).and_then(|expression| {
        expression.compile(|name| {
            if let Some(index) = name.strip_prefix('_') {
                return index.parse().ok().filter(|index| *index < references).map(Operand::Slot);
            }
            let slot = match metric(name, assembly, agent) {
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
fn metric(name: &str, assembly: &Assembly, agent: usize) -> Option<Result<Slot, String>> {
    if name == "tracking" {
        let find = |topic, field| Span::find(assembly, agent, topic, field);
        let place = find("reference", "desired_position").or_else(|_| find("reference", "position"));
        let slot = find("state", "position").and_then(|own| Ok(Slot::Folded(Fold::Norm, own, Some(place?))));
        return Some(slot);
    }
    Nearest::named(name, assembly, agent).map(|nearest| nearest.map(Slot::Nearest))
}

/// Replaces what formulas do not know by names of slots that are as long, so that offsets stay.
struct Scanner<'a> {
    text: &'a str,
    at: usize,
    rewritten: String,
    slots: Vec<Slot>,
    assembly: &'a Assembly,
    agent: usize,
}

impl<'a> Scanner<'a> {
    fn scan(&mut self) -> Result<(), Mistake> {
        while let Some(character) = self.peek() {
            let start = self.at;
            if character.is_ascii_digit() {
                self.skip(|c| c.is_ascii_alphanumeric() || c == '.');
            } else if character == '_' {
                return Err(self.mistake(start, "expected a name that starts with a letter"));
            } else if character.is_ascii_alphabetic() {
                let word = self.word();
                if self.peek() == Some('.') {
                    self.at = start;
                    let span = self.reference()?;
                    if span.length != 1 {
                        let message = format!(
                            "expected a number, found a vector of {}: name a component, as in [0], or fold it, as in norm(...)",
                            span.length
                        );
                        return Err(self.mistake(start, message));
                    }
                    self.replace(start, Slot::Word(span))?;
                    continue;
                }
                let fold = Fold::ALL.into_iter().find(|(name, _)| *name == word).map(|(_, fold)| fold);
                if let (Some(fold), Some('(')) = (fold, self.text[self.at..].trim_start().chars().next()) {
                    self.spaces();
                    self.at += 1;
                    let slot = self.folded(fold)?;
                    self.replace(start, slot)?;
                    continue;
                }
            } else {
                self.at += character.len_utf8();
            }
            self.rewritten.push_str(&self.text[start..self.at]);
        }
        Ok(())
    }

    /// The argument of a fold and the parenthesis behind it.
    fn folded(&mut self, fold: Fold) -> Result<Slot, Mistake> {
        let first = self.reference()?;
        self.spaces();
        let mut less = None;
        if self.peek() == Some('-') {
            self.at += 1;
            self.spaces();
            let start = self.at;
            let second = self.reference()?;
            if second.length != first.length {
                let message = format!(
                    "expected {} values to subtract, found {}; choose some of them, as in [0:{}]",
                    first.length,
                    second.length,
                    first.length.min(second.length)
                );
                return Err(self.mistake(start, message));
            }
            less = Some(second);
            self.spaces();
        }
        if self.peek() != Some(')') {
            return Err(
                self.mistake(self.at, "expected `)`, or `-` and another field: a fold takes one field or a difference")
            );
        }
        self.at += 1;
        Ok(Slot::Folded(fold, first, less))
    }

    /// `state.position`, `state.position[2]` or `state.position[0:3]`.
    fn reference(&mut self) -> Result<Span, Mistake> {
        self.spaces();
        let start = self.at;
        let topic = self.word();
        if topic.is_empty() || self.peek() != Some('.') {
            return Err(self.mistake(start, "expected a field of a topic, such as state.position"));
        }
        self.at += 1;
        let field = self.word();
        let whole =
            Span::find(self.assembly, self.agent, topic, field).map_err(|message| self.mistake(start, message))?;
        if self.peek() != Some('[') {
            return Ok(whole);
        }
        let bracket = self.at;
        let end = self.text[bracket..].find(']').map(|length| bracket + length);
        let inside = end.map(|end| &self.text[bracket + 1..end]).unwrap_or_default();
        let (first, last) = match inside.split_once(':') {
            Some((first, last)) => (first.trim().parse().ok(), last.trim().parse().ok()),
            None => {
                let index: Option<usize> = inside.trim().parse().ok();
                (index, index.and_then(|index| index.checked_add(1)))
            }
        };
        match (first, last, end) {
            (Some(first), Some(last), Some(end)) if first < last && last <= whole.length => {
                self.at = end + 1;
                Ok(Span { offset: whole.offset + first, length: last - first, ..whole })
            }
            _ => {
                let message = format!(
                    "expected an index [K] or a range [FIRST:END] within the {} values of {topic}.{field}, counted from 0",
                    whole.length
                );
                Err(self.mistake(bracket, message))
            }
        }
    }

    /// Puts the name of a new slot in the place of what was read since `start`.
    fn replace(&mut self, start: usize, slot: Slot) -> Result<(), Mistake> {
        if self.slots.len() == MOST_SLOTS {
            return Err(self.mistake(start, format!("expected at most {MOST_SLOTS} fields in one signal, found more")));
        }
        let name = format!("_{}", self.slots.len());
        self.rewritten.push_str(&format!("{name:<width$}", width = self.at - start));
        self.slots.push(slot);
        Ok(())
    }

    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn spaces(&mut self) {
        self.skip(|character| character == ' ');
    }

    fn word(&mut self) -> &'a str {
        let start = self.at;
        self.skip(|character| character.is_ascii_alphanumeric() || character == '_');
        &self.text[start..self.at]
    }

    fn skip(&mut self, belongs: impl Fn(char) -> bool) {
        self.at += self.text[self.at..].chars().take_while(|c| belongs(*c)).map(char::len_utf8).sum::<usize>();
    }

    fn mistake(&self, offset: usize, message: impl Into<String>) -> Mistake {
        Mistake { offset, message: message.into() }
    }
}
