//! From a scenario to the network of its participants.

use lockstep::{Channel, Layout, LoopError, Network, Node, Participant};
use std::borrow::Cow;

use super::components::read_components;
use super::instruments::{self, InstrumentNode};
use super::links::{self, AskedLink, LinkNode};
use super::named_participants::{apply_edges, check_failure_policy, check_groups, check_swaps};
use super::node_role::NodeRole;
use super::present::add_variants_with;
use super::ranges;
use super::{Bind, Component, Kind, Signals, Swapped, external, swapped};
use crate::config::{Problem, Problems, Sort};
use crate::role::Role;
use crate::scenario::{Scenario, Selection, foreign, list_of};

/// The components that exist, by role. A program of your own starts from those of this repository and adds its own:
///
/// ```
/// # use formation::wiring::{Kind, Role, Roles};
/// # const OURS: Roles = Roles::NONE;
/// # fn mine() -> Vec<Kind> { Vec::new() }
/// let mut roles = OURS;
/// roles.add(Role::Controller, mine());
/// ```
#[derive(Clone)]
pub struct Roles {
    /// Plants.
    pub plant: Cow<'static, [Kind]>,
    /// Planners.
    pub planner: Cow<'static, [Kind]>,
    /// Observers.
    pub observer: Cow<'static, [Kind]>,
    /// Controllers.
    pub controller: Cow<'static, [Kind]>,
}

impl Roles {
    /// No component at all.
    pub const NONE: Self = Self::new(&[], &[], &[], &[]);

    /// These components.
    pub const fn new(
        plant: &'static [Kind],
        planner: &'static [Kind],
        observer: &'static [Kind],
        controller: &'static [Kind],
    ) -> Self {
        Self {
            plant: Cow::Borrowed(plant),
            planner: Cow::Borrowed(planner),
            observer: Cow::Borrowed(observer),
            controller: Cow::Borrowed(controller),
        }
    }

    /// The components of a role: its own, and behind them the kind `external`, which every catalog has.
    pub fn of(&self, role: Role) -> impl Iterator<Item = &Kind> {
        let own = self.own(role);
        let external = Some(&external::KIND).filter(|kind| own.iter().all(|known| known.name != kind.name));
        own.iter().chain(external)
    }

    fn own(&self, role: Role) -> &[Kind] {
        match role {
            Role::Plant => &self.plant,
            Role::Planner => &self.planner,
            Role::Observer => &self.observer,
            Role::Controller => &self.controller,
        }
    }

    /// Adds components to a role. One that has the name of an earlier one takes its place.
    pub fn add(&mut self, role: Role, kinds: impl IntoIterator<Item = Kind>) {
        let list = match role {
            Role::Plant => &mut self.plant,
            Role::Planner => &mut self.planner,
            Role::Observer => &mut self.observer,
            Role::Controller => &mut self.controller,
        };
        for kind in kinds {
            let list = list.to_mut();
            list.retain(|known| known.name != kind.name);
            list.push(kind);
        }
    }
}

/// A checked scenario with its components, ready to build participants from.
pub struct Assembly {
    /// The scenario.
    pub scenario: Scenario,
    /// The step graph.
    pub network: Network,
    /// Role and agents of the nodes of the network. Those of sensors, actuators and links stand behind
    /// them in the network, and have none.
    pub nodes: Vec<NodeRole>,
    /// The nodes of the network behind those of roles: sensors, actuators, and then links.
    instruments: Vec<InstrumentNode>,
    links: Vec<LinkNode>,
    signals: Signals,
    components: Vec<(Role, Kind, Box<dyn Component>)>,
    /// The roles whose only node serves all agents.
    serving_all: Vec<Role>,
}

impl Assembly {
    /// Reads the components of `scenario`, checks them, and connects them.
    ///
    /// # Errors
    /// Everything that is wrong with the components or does not fit together.
    pub fn new(scenario: Scenario, roles: &Roles) -> Result<Self, Vec<Problem>> {
        let mut problems = Problems::default();
        let components = read_components(&scenario, roles, &mut problems);
        if problems.is_empty() { Self::of(scenario, components) } else { Err(problems.into_vec()) }
    }

    /// Reads the scenario in `text` with its components, checks and connects all of it. `file` is what messages call it.
    ///
    /// # Errors
    /// Everything that is wrong with the file and its components, or what does not fit together.
    pub fn load(file: &str, text: &str, selection: &Selection, roles: &Roles) -> Result<Self, Vec<Problem>> {
        let mut problems = Problems::default();
        let scenario = Scenario::collect(file, text, selection, &mut problems);
        let components = scenario.as_ref().map(|scenario| read_components(scenario, roles, &mut problems));
        match (scenario, components) {
            (Some(scenario), Some(components)) if problems.is_empty() => Self::of(scenario, components),
            _ => {
                let mut problems = problems.into_vec();
                add_variants_with(file, text, selection, roles, &mut problems);
                for problem in problems.iter_mut().filter(|problem| problem.sort == Sort::Unknown) {
                    if let Some(help) = foreign(&problem.path) {
                        problem.help = Some(help.into());
                    }
                }
                Err(problems)
            }
        }
    }

    fn of(scenario: Scenario, components: Vec<(Role, Kind, Box<dyn Component>)>) -> Result<Self, Vec<Problem>> {
        let signals = declare(&scenario, &components);
        check_units(&scenario, &signals)?;
        let nodes = node_roles(&scenario, &components);
        let serving_all = serving_all(&scenario, &nodes);
        let mut assembly = Self {
            scenario,
            network: Network { channels: signals.channels.clone(), nodes: Vec::new() },
            serving_all,
            nodes,
            instruments: Vec::new(),
            links: Vec::new(),
            signals,
            components,
        };
        assembly.connect()?;
        Ok(assembly)
    }

    /// Builds the participants of these nodes, in this order.
    pub fn participants(&self, nodes: &[usize]) -> Result<Vec<Box<dyn Participant>>, Vec<Problem>> {
        nodes.iter().map(|&node| self.participant(node)).collect()
    }

    fn participant(&self, node: usize) -> Result<Box<dyn Participant>, Vec<Problem>> {
        match node.checked_sub(self.nodes.len()) {
            None => self.build(node).map(|(_, participant)| participant),
            Some(place) => match self.instruments.get(place) {
                Some(instruments) => instruments.build(&self.scenario, &self.signals),
                None => {
                    let links = &self.links[place - self.instruments.len()];
                    Ok(Box::new(links.build(&self.scenario.context)))
                }
            },
        }
    }

    /// The effective scenario with the defaults of all parameters of its components, for the processes of a run.
    pub fn to_toml(&self) -> String {
        let defaults = self.components.iter().map(|(role, kind, _)| (*role, kind.defaults()));
        self.scenario.with_defaults(defaults)
    }

    /// What the scenario asks of the links between agents, in the order of the network.
    pub fn links(&self) -> Vec<AskedLink> {
        self.links.iter().flat_map(LinkNode::asked).collect()
    }

    /// Whether the component of `role` has no law, so that programs must take the places of its participants.
    pub fn is_external(&self, role: Role) -> bool {
        self.components.iter().any(|(known, _, component)| *known == role && component.is_external())
    }

    /// The participants that these names of `[swap]` or `--swap` mean, such as `controller.3`, `controller.*` or `plant.1,3-6`.
    ///
    /// # Errors
    /// The number of a name that means none, or that names a participant twice, with the reason.
    pub fn swapped(&self, names: &[&str]) -> Result<Vec<Swapped>, (usize, String)> {
        swapped::resolve(&self.network, &self.nodes, names)
    }

    fn connect(&mut self) -> Result<(), Vec<Problem>> {
        let mut problems = ranges::check(&self.scenario, &self.signals);
        let mut starters = Vec::new();
        for index in 0..self.nodes.len() {
            match self.build(index) {
                Ok((node, participant)) => {
                    self.network.nodes.push(node);
                    // Before a run, no command acts: what is read of one that is not there yet is 0.
                    if self.nodes[index].role != Role::Controller || self.is_external(Role::Controller) {
                        starters.push((index, participant));
                    }
                }
                Err(found) => problems.extend(found),
            }
        }
        if !problems.is_empty() {
            problems.dedup_by(|a, b| a.path == b.path); // the same component fails for every agent
            return Err(problems);
        }
        apply_edges(&self.scenario, &mut self.network)?;
        check_groups(&self.scenario, &self.network)?;
        check_failure_policy(&self.scenario, &self.network)?;
        check_swaps(&self.scenario, &self.network, &self.nodes)?;
        let mut ids = self.signals.ids.clone();
        let (scenario, signals) = (&self.scenario, &self.signals);
        self.instruments = instruments::insert(scenario, signals, &self.nodes, &mut self.network, &mut ids)?;
        self.links = links::insert(scenario, signals, &self.nodes, &mut self.network, &ids)?;
        for index in self.nodes.len()..self.network.nodes.len() {
            starters.push((index, self.participant(index)?));
        }
        let dt = self.scenario.context.timing.dt;
        let begun = lockstep::initial::set(&mut self.network, starters, dt);
        begun.map_err(|error| vec![self.of_loop(&error)])
    }

    /// A loop, with the advice how to open it.
    fn of_loop(&self, error: &LoopError) -> Problem {
        let role_of = |name: &String| Role::ALL.into_iter().find(|role| name.split('_').next() == Some(role.name()));
        let external = error.0.iter().filter_map(role_of).find(|role| self.is_external(*role));
        let Some(role) = external else { return self.scenario.problem("", error.to_string()) };
        let advice = format!("in `reads` of `[{role}]`, write `@before` behind one of them to read its step before");
        self.scenario.problem(&format!("{role}.reads"), error.to_string()).with_help(advice)
    }

    fn build(&self, index: usize) -> Result<(Node, Box<dyn Participant>), Vec<Problem>> {
        let NodeRole { role, agents } = &self.nodes[index];
        let (_, kind, component) = self
            .components
            .iter()
            .find(|(found, ..)| found == role)
            .ok_or_else(|| vec![self.scenario.problem(role.name(), format!("this scenario has no {role}"))])?;
        let mut bind = Bind::new(&self.signals, *role, kind.name, agents);
        let participant = component.build(&self.scenario.context, agents, &mut bind).map_err(|refusal| {
            let path = |field: &str| format!("{role}.{field}");
            let placed = refusal.placed(|field| self.scenario.section(&path(field)).is_some());
            let (path, message) = match placed {
                Some((field, message)) => (path(field), message.to_string()),
                None => (role.name().to_string(), refusal.to_string()),
            };
            vec![self.scenario.problem(&path, message)]
        })?;
        let (inputs, outputs) = bind.into_edges();
        let (every, offset) = self.scenario.rate(*role);
        let name = node_name(*role, agents, self.serving_all.contains(role));
        let node = Node { name, inputs, outputs, every, offset };
        let guarded = ranges::guard(&self.scenario, &self.signals, *role, &node, participant);
        Ok((node, guarded))
    }
}

/// The roles whose only node serves all agents. The plant of an only agent may be one per agent, too.
fn serving_all(scenario: &Scenario, nodes: &[NodeRole]) -> Vec<Role> {
    let is_alone = |role: &Role| nodes.iter().filter(|node| node.role == *role).count() == 1;
    let is_together = |role: &Role| *role != Role::Plant || is_one_plant(scenario);
    [Role::Plant, Role::Planner].into_iter().filter(|role| is_alone(role) && is_together(role)).collect()
}

/// Whether one participant is the plant of all agents.
fn is_one_plant(scenario: &Scenario) -> bool {
    !scenario.plant_per_agent && scenario.plant_groups.is_empty()
}

pub(super) fn node_name(role: Role, agents: &[usize], serves_all: bool) -> String {
    match agents {
        [agent] if !serves_all => format!("{role}_{}", agent + 1),
        _ if serves_all => role.name().to_string(),
        _ => format!("{role}_{}", list_of(&agents.iter().map(|agent| agent + 1).collect::<Vec<_>>())),
    }
}

fn declare(scenario: &Scenario, components: &[(Role, Kind, Box<dyn Component>)]) -> Signals {
    let (mut channels, mut ids) = (Vec::new(), Vec::new());
    for (role, _, component) in components {
        for agent in 0..scenario.context.agents.len() {
            channels.push(Channel {
                topic: format!("/agent_{}/{}", agent + 1, role.channel()),
                agent: agent as u32 + 1,
                layout: Layout::new(component.outputs(&scenario.context, agent)),
                initial: Vec::new(),
            });
            ids.push(Some((*role, agent)));
        }
    }
    let carries = scenario.context.links.as_ref().map(|links| links.carries.clone()).unwrap_or_default();
    Signals::new(channels, ids).with_links(carries)
}

/// Units are part of texts by lines: of ROS definitions in logs, and of messages.
fn check_units(scenario: &Scenario, signals: &Signals) -> Result<(), Vec<Problem>> {
    let wrong = signals.channels.iter().zip(&signals.ids).find_map(|(channel, id)| {
        let field = channel.layout.fields().iter().find(|field| field.unit.contains(char::is_control))?;
        let is_model = *id == Some((Role::Plant, channel.agent as usize - 1)) && scenario.section("vehicle").is_some();
        let section = if is_model { "vehicle" } else { id.map_or("", |(role, _)| role.name()) };
        let message = format!("expected a unit in one line, found {:?} for the signal `{}`", field.unit, field.name);
        Some(scenario.problem(section, message))
    });
    wrong.map_or(Ok(()), |problem| Err(vec![problem]))
}

fn node_roles(scenario: &Scenario, components: &[(Role, Kind, Box<dyn Component>)]) -> Vec<NodeRole> {
    let agents: Vec<usize> = (0..scenario.context.agents.len()).collect();
    let mut nodes = Vec::new();
    for &(role, ..) in components {
        let together = match role {
            Role::Planner => true,
            Role::Plant => is_one_plant(scenario),
            Role::Observer | Role::Controller => false,
        };
        if together {
            nodes.push(NodeRole { role, agents: agents.clone() });
        } else if role == Role::Plant && !scenario.plant_groups.is_empty() {
            let group_of = |agent: &usize| scenario.plant_groups.iter().find(|group| group.contains(agent));
            let groups = agents.iter().map(|agent| group_of(agent).cloned().unwrap_or_else(|| vec![*agent]));
            let firsts = groups.enumerate().filter(|(agent, group)| group[0] == *agent);
            nodes.extend(firsts.map(|(_, agents)| NodeRole { role, agents }));
        } else {
            nodes.extend(agents.iter().map(|&agent| NodeRole { role, agents: vec![agent] }));
        }
    }
    nodes
}
