//! Binding of signals by name.

use std::collections::BTreeMap;

use lockstep::{Channel, ChannelId, In, Input, Layout, Node, Out, Slice, Timing};

use super::Role;
use super::instruments::original;
use super::links::{carried, reads_over_links};
use super::unbound::Bound;
use crate::effects::LINK_FIELDS;

/// Why a component cannot be used here.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refusal(pub String);

impl Refusal {
    /// A refusal because of the field `path` of the component: it is shown there.
    pub fn at(path: &str, message: impl std::fmt::Display) -> Self {
        Self(format!("{path}: {message}"))
    }

    /// The field that it is about, and the rest of its message; `is_field` knows the fields.
    pub(super) fn placed(&self, is_field: impl Fn(&str) -> bool) -> Option<(&str, &str)> {
        self.0.split_once(": ").filter(|(path, _)| !path.contains(' ') && is_field(path))
    }
}

/// The channels of a scenario by role and agent.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    pub(super) channels: Vec<Channel>,
    /// Role and agent of each channel; `None` for a channel of another kind.
    pub(super) ids: Vec<Option<(Role, usize)>>,
    /// The same the other way round.
    places: BTreeMap<(Role, usize), ChannelId>,
    /// The roles whose signals other agents receive over links.
    linked: Vec<Role>,
    /// The channel for which each channel of a sensor, an actuator or a link stands.
    sources: BTreeMap<ChannelId, ChannelId>,
}

impl Signals {
    /// Channels with the role and the agent (from 0) of each.
    pub(super) fn new(channels: Vec<Channel>, ids: Vec<Option<(Role, usize)>>) -> Self {
        let known = ids.iter().enumerate().filter_map(|(channel, id)| Some(((*id)?, ChannelId(channel))));
        let places = known.collect();
        Self { channels, ids, places, linked: Vec::new(), sources: BTreeMap::new() }
    }

    /// The same, with links that are not among the channels yet and carry the signals of these roles.
    pub(super) fn with_links(self, linked: Vec<Role>) -> Self {
        Self { linked, ..self }
    }

    /// The same, with the links that are among the channels.
    pub(super) fn with_sources(self) -> Self {
        let by_topic: BTreeMap<&str, usize> =
            self.channels.iter().zip(0..).map(|(channel, place)| (channel.topic.as_str(), place)).collect();
        let source = |topic: &str| {
            let stands_for = carried(topic).or_else(|| original(topic))?;
            by_topic.get(stands_for.as_str()).map(|source| ChannelId(*source))
        };
        let known = self.channels.iter().enumerate();
        let sources = known.filter_map(|(place, channel)| Some((ChannelId(place), source(&channel.topic)?))).collect();
        Self { sources, ..self }
    }

    /// The channel for which this one stands, or itself.
    fn source(&self, channel: ChannelId) -> ChannelId {
        self.sources.get(&channel).copied().unwrap_or(channel)
    }

    /// The channel on which `role` publishes for `agent` (from 0).
    pub fn find(&self, role: Role, agent: usize) -> Option<ChannelId> {
        self.places.get(&(role, agent)).copied()
    }

    /// Layout of a channel.
    pub fn layout(&self, channel: ChannelId) -> &Layout {
        &self.channels[channel.0].layout
    }
}

/// What tells the inputs of a component apart.
fn key(input: &Input) -> (ChannelId, bool) {
    (input.channel, input.timing == Timing::Delayed)
}

/// Collects the inputs that a component asks for while it is built.
#[derive(Debug)]
pub struct Bind<'a> {
    signals: &'a Signals,
    role: Role,
    component: &'a str,
    inputs: Vec<Input>,
    outputs: Vec<ChannelId>,
    /// The port of every input, by channel and whether it is read delayed.
    input_ports: BTreeMap<(ChannelId, bool), usize>,
    /// The port of every output.
    output_ports: BTreeMap<ChannelId, usize>,
    /// The inputs are given, and no others can be had.
    fixed: bool,
    /// The outputs that were asked for.
    bound: Bound,
}

impl<'a> Bind<'a> {
    pub(super) fn new(signals: &'a Signals, role: Role, component: &'a str, agents: &[usize]) -> Self {
        let outputs = agents.iter().filter_map(|&agent| signals.find(role, agent)).collect();
        Self::with(signals, role, component, Vec::new(), outputs, false)
    }

    /// Binds on the ports that a planned node has already. The outputs that are asked for are added to those that are `bound`.
    pub(super) fn adopt(signals: &'a Signals, role: Role, component: &'a str, node: &Node, bound: &Bound) -> Self {
        let bind = Self::with(signals, role, component, node.inputs.clone(), node.outputs.clone(), true);
        Self { bound: bound.clone(), ..bind }
    }

    fn with(
        signals: &'a Signals,
        role: Role,
        component: &'a str,
        inputs: Vec<Input>,
        outputs: Vec<ChannelId>,
        fixed: bool,
    ) -> Self {
        // A link, a sensor or an actuator stands for another channel.
        let source = |input: &Input| Input { channel: signals.source(input.channel), ..*input };
        let input_ports = inputs.iter().map(|input| key(&source(input))).zip(0..).collect();
        let output_ports = outputs.iter().copied().zip(0..).collect();
        Self { signals, role, component, inputs, outputs, input_ports, output_ports, fixed, bound: Bound::default() }
    }

    pub(super) fn into_edges(self) -> (Vec<Input>, Vec<ChannelId>) {
        (self.inputs, self.outputs)
    }

    /// A signal of the plant, of this step.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such signal with `D` values; so for the other three.
    pub fn state<const D: usize>(&mut self, agent: usize, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Plant, agent, name, Timing::SameStep)
    }

    /// A signal of the planner, of this step.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub fn reference<const D: usize>(&mut self, agent: usize, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Planner, agent, name, Timing::SameStep)
    }

    /// A signal of an observer, of this step.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub fn estimate<const D: usize>(&mut self, agent: usize, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Observer, agent, name, Timing::SameStep)
    }

    /// A signal of a controller, of the step before: the command that was in force until now.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub fn command_before<const D: usize>(&mut self, agent: usize, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Controller, agent, name, Timing::Delayed)
    }

    /// Whether `role` publishes a signal called `name` for `agent`.
    pub fn offers(&self, role: Role, agent: usize, name: &str) -> bool {
        self.signals.find(role, agent).is_some_and(|channel| self.signals.layout(channel).find(name).is_some())
    }

    /// Number of values of the signal called `name` that `role` publishes for `agent`, or that tells about the link to it.
    pub fn length(&self, role: Role, agent: usize, name: &str) -> Option<usize> {
        let channel = self.signals.find(role, agent)?;
        let field = self.signals.layout(channel).find(name).map(|(_, length)| length);
        field.or_else(|| self.about_link(role, agent, channel, name).map(|_| 1))
    }

    /// The signals that `role` publishes for `agent`, in words: `one of position (2), x (1)`, or that there are none.
    pub fn signals_of(&self, role: Role, agent: usize) -> String {
        match self.signals.find(role, agent) {
            Some(channel) => format!("one of {}", offered(self.signals.layout(channel))),
            None => format!("but this scenario has no {role}"),
        }
    }

    /// Whether `role` publishes anything for `agent`.
    pub(super) fn publishes(&self, role: Role, agent: usize) -> bool {
        self.signals.find(role, agent).is_some()
    }

    /// All signals of `role` for `agent`, for a program that chooses among them later.
    ///
    /// # Errors
    /// [`Refusal`] if the scenario has no such participant.
    pub(super) fn whole(&mut self, role: Role, agent: usize, timing: Timing) -> Result<(), Refusal> {
        let missing = || format!("the {} `{}` reads the {role}, but this scenario has none", self.role, self.component);
        let channel = self.signals.find(role, agent).ok_or_else(|| Refusal(missing()))?;
        let input = Input { channel, timing };
        if !self.input_ports.contains_key(&key(&input)) {
            self.input_ports.insert(key(&input), self.inputs.len());
            self.inputs.push(input);
        }
        Ok(())
    }

    /// Any signal of `D` values.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub fn read<const D: usize>(
        &mut self,
        role: Role,
        agent: usize,
        name: &str,
        timing: Timing,
    ) -> Result<In<D>, Refusal> {
        let slice = self.read_slice(role, agent, name, D, timing)?;
        Ok(In::new(slice.0, slice.1))
    }

    /// Any signal of `length` values.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub fn slice(
        &mut self,
        role: Role,
        agent: usize,
        name: &str,
        length: usize,
        timing: Timing,
    ) -> Result<Slice, Refusal> {
        let (port, offset) = self.read_slice(role, agent, name, length, timing)?;
        Ok(Slice::new(port, offset, length))
    }

    /// Like [`Bind::slice`], but a planned edge of the other timing does not count.
    ///
    /// # Errors
    /// See [`Bind::state`].
    pub(super) fn slice_exactly(
        &mut self,
        role: Role,
        agent: usize,
        name: &str,
        length: usize,
        timing: Timing,
    ) -> Result<Slice, Refusal> {
        let (port, offset) = self.read_slice(role, agent, name, length, timing)?;
        let Input { channel, timing: planned } = self.inputs[port];
        if planned == timing {
            return Ok(Slice::new(port, offset, length));
        }
        let [asked, there] = [timing, planned].map(|timing| match timing {
            Timing::SameStep => "this step",
            Timing::Delayed => "the step before",
        });
        let topic = &self.signals.channels[channel.0].topic;
        Err(Refusal(format!(
            "`{name}` of {topic} was asked for of {asked}, but this participant reads that of {there}"
        )))
    }

    /// How many values a signal has.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such signal.
    pub(super) fn size(&self, role: Role, agent: usize, name: &str) -> Result<usize, Refusal> {
        self.length(role, agent, name).ok_or_else(|| {
            let offered = self.signals_of(role, agent);
            Refusal(format!("the {role} of agent {} has no signal `{name}`, {offered}", agent + 1))
        })
    }

    /// A signal of `D` values that this component publishes for `agent`.
    ///
    /// # Errors
    /// [`Refusal`] if [`Component::outputs`](super::Component::outputs) does not declare it so.
    pub fn out<const D: usize>(&self, agent: usize, name: &str) -> Result<Out<D>, Refusal> {
        let slice = self.out_slice(agent, name, D)?;
        Ok(Out::new(slice.0, slice.1))
    }

    /// A signal of `length` values that this component publishes for `agent`.
    ///
    /// # Errors
    /// See [`Bind::out`].
    pub fn slice_out(&self, agent: usize, name: &str, length: usize) -> Result<Slice, Refusal> {
        let (port, offset) = self.out_slice(agent, name, length)?;
        Ok(Slice::new(port, offset, length))
    }

    fn out_slice(&self, agent: usize, name: &str, length: usize) -> Result<(usize, usize), Refusal> {
        let place = self.signals.find(self.role, agent).and_then(|channel| {
            let port = *self.output_ports.get(&channel)?;
            Some((port, self.offset(channel, name, length)?))
        });
        let declared = place.ok_or_else(|| {
            let what = format!("{} `{}` does not declare the output `{name}` ({length})", self.role, self.component);
            Refusal(format!("{what}{}", self.outputs_of(agent)))
        });
        let (port, offset) = declared?;
        self.bound.add([port, offset, length]);
        Ok((port, offset))
    }

    /// The outputs that may be written for an agent, in words.
    fn outputs_of(&self, agent: usize) -> String {
        let own = self.signals.find(self.role, agent).filter(|channel| self.outputs.contains(channel));
        match own {
            Some(channel) => {
                format!(" of agent {}; it declares {}", agent + 1, offered(self.signals.layout(channel)))
            }
            None => format!(" of agent {}; it writes nothing for this agent", agent + 1),
        }
    }

    fn read_slice(
        &mut self,
        role: Role,
        agent: usize,
        name: &str,
        length: usize,
        timing: Timing,
    ) -> Result<(usize, usize), Refusal> {
        let needs = || {
            let values = if length == 1 { "one value".to_string() } else { format!("{length} values") };
            format!(
                "the {} `{}` needs the signal `{name}` ({values}) from the {role} of agent {}",
                self.role,
                self.component,
                agent + 1
            )
        };
        let Some(channel) = self.signals.find(role, agent) else {
            return Err(Refusal(format!("{}, but this scenario has no {role} there", needs())));
        };
        let about_link = || self.about_link(role, agent, channel, name).filter(|_| length == 1);
        let Some(offset) = self.offset(channel, name, length).or_else(about_link) else {
            return Err(Refusal(format!("{}, which offers only {}", needs(), offered(self.signals.layout(channel)))));
        };
        let input = Input { channel, timing };
        let (_, delayed) = key(&input);
        let exact = self.input_ports.get(&(channel, delayed));
        // A scenario may have changed the timing of a planned edge.
        let planned = || self.input_ports.get(&(channel, !delayed)).filter(|_| self.fixed);
        match exact.or_else(planned) {
            Some(&port) => Ok((port, offset)),
            None if self.fixed => {
                let how = "`reads` of a section with `kind = \"external\"` adds it";
                Err(Refusal(format!("{}, which the participant that it replaces does not read; {how}", needs())))
            }
            None => {
                self.input_ports.insert(key(&input), self.inputs.len());
                self.inputs.push(input);
                Ok((self.inputs.len() - 1, offset))
            }
        }
    }

    /// Where a number about the link stands over which `channel` is read, behind the numbers of the channel.
    fn about_link(&self, role: Role, agent: usize, channel: ChannelId, name: &str) -> Option<usize> {
        let place = LINK_FIELDS.iter().position(|(known, _)| *known == name)?;
        let is_linked = if self.fixed {
            let ports = [true, false].into_iter().filter_map(|delayed| self.input_ports.get(&(channel, delayed)));
            ports
                .map(|port| self.inputs[*port].channel.0)
                .any(|input| carried(&self.signals.channels[input].topic).is_some())
        } else {
            let is_own = self.outputs.iter().any(|output| self.signals.ids[output.0] == Some((self.role, agent)));
            reads_over_links(self.role) && !is_own && self.signals.linked.contains(&role)
        };
        is_linked.then(|| self.signals.layout(channel).words() + place)
    }

    fn offset(&self, channel: ChannelId, name: &str, length: usize) -> Option<usize> {
        let (offset, found) = self.signals.layout(channel).find(name)?;
        (found == length).then_some(offset)
    }
}

/// The fields of a channel with their lengths.
fn offered(layout: &Layout) -> String {
    let fields = layout.fields().iter().map(|field| format!("{} ({})", field.name, field.shape.words()));
    fields.collect::<Vec<_>>().join(", ")
}
