//! The interface of a participant for programs of users: its place in the run, numbers of the scenario, graph, signals.

use std::path::{Path, PathBuf};

use lockstep::{In, Out, Slice, Timing};

use super::{Refusal, Role, Station};
use crate::scenario::{AgentNumber, Context, Disturbance, Graph, LookupError, Scenario};

/// What messages call the component of a program.
const KIND: &str = "own program";

/// What a program of a user can read and write in the place of a participant. Agents count from 1.
#[derive(Clone, Debug)]
pub struct Interface {
    scenario: Scenario,
    station: Station,
    dt: f64,
    steps: u64,
}

impl From<LookupError> for Refusal {
    fn from(error: LookupError) -> Self {
        Self(error.to_string())
    }
}

impl Interface {
    /// The interface of the participant at `station`, for `steps` steps of `dt` seconds.
    pub fn new(scenario: Scenario, station: Station, dt: f64, steps: u64) -> Self {
        Self { scenario, station, dt, steps }
    }

    /// Name of the participant in the run, `controller_3`.
    pub fn name(&self) -> &str {
        &self.station.node.name
    }

    /// The agent that it serves.
    ///
    /// # Errors
    /// [`Refusal`] if it serves several agents, or all of them.
    pub fn agent(&self) -> Result<AgentNumber, Refusal> {
        match self.station.agents[..] {
            [agent] if !self.station.serves_all() => Ok(AgentNumber::at(agent)),
            _ if self.station.serves_all() => {
                Err(Refusal("this participant serves all agents; name one, counting from 1".into()))
            }
            _ => Err(Refusal(format!("{} serves several agents; name one, counting from 1", self.name()))),
        }
    }

    /// The agents that it serves, ascending: one, some, or all.
    pub fn served(&self) -> impl ExactSizeIterator<Item = AgentNumber> {
        self.station.agents.iter().map(|&agent| AgentNumber::at(agent))
    }

    /// All agents of the scenario, in order.
    pub fn agents(&self) -> impl ExactSizeIterator<Item = AgentNumber> + use<> {
        (0..self.context().agents.len()).map(AgentNumber::at)
    }

    /// The agent of this number.
    ///
    /// # Errors
    /// [`Refusal`] if the scenario has no such agent.
    pub fn agent_called(&self, number: usize) -> Result<AgentNumber, Refusal> {
        let agents = self.context().agents.len();
        let known = AgentNumber::new(number).filter(|agent| agent.index() < agents);
        known.ok_or_else(|| Refusal(format!("there is no agent {number}; the scenario has {agents}, counted from 1")))
    }

    /// Length of a step, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// Number of steps of the run.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// What every component may know of the scenario.
    pub fn context(&self) -> &Context {
        &self.scenario.context
    }

    /// Whether the scenario as it is run, with variant, overrides and defaults, has a value of this dotted name.
    pub fn has(&self, name: &str) -> bool {
        self.scenario.has(name)
    }

    /// A number of the scenario as it is in force, see [`Scenario::number`].
    ///
    /// # Errors
    /// [`Refusal`] if there is no such number.
    pub fn number(&self, name: &str) -> Result<f64, Refusal> {
        Ok(self.scenario.number(name)?)
    }

    /// A text of the scenario.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such text.
    pub fn text(&self, name: &str) -> Result<&str, Refusal> {
        Ok(self.scenario.text(name)?)
    }

    /// Number of elements of a list of the scenario.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such list.
    pub fn length(&self, name: &str) -> Result<usize, Refusal> {
        Ok(self.scenario.length(name)?)
    }

    /// The dotted name of a parameter of this program: that of an agent (`with` in its row) or else that of the section
    /// (`[controller.with]`). [`Interface::number`], [`Interface::text`], [`Interface::path`] and [`Interface::length`] read it.
    /// Without an agent, it is that of its own agent, if it serves one.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such parameter.
    pub fn parameter(&self, agent: Option<AgentNumber>, name: &str) -> Result<String, Refusal> {
        let agent = agent.or_else(|| self.agent().ok()).map(AgentNumber::index);
        Ok(self.scenario.parameter(self.station.role(), agent, name)?)
    }

    /// A text of the scenario that is a path, meant from the folder of its file; absolute.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such text, or the current folder, which stands in for that of a scenario without a file, is not
    /// known.
    pub fn path(&self, name: &str) -> Result<PathBuf, Refusal> {
        let folder = self.scenario.folder.as_deref().unwrap_or(Path::new(""));
        let path = folder.join(self.scenario.text(name)?);
        std::path::absolute(&path).map_err(|error| Refusal(format!("{}: {error}", path.display())))
    }

    /// What a controller may know of the vehicle of `agent`, under the name that formulas use: `m`, `R`, `Jx`.
    ///
    /// # Errors
    /// [`Refusal`] if its model has no such number.
    pub fn model(&self, agent: AgentNumber, name: &str) -> Result<f64, Refusal> {
        let number = self.row(agent)?.nominal.parameter(name);
        number.ok_or_else(|| Refusal(format!("the model of agent {agent} has no number called `{name}`")))
    }

    /// The communication graph at the start of the run.
    pub fn graph(&self) -> Graph {
        self.scenario.graph()
    }

    /// The communication graphs of the run, each with the step from which on it holds, in order.
    pub fn graphs(&self) -> Vec<(u64, Graph)> {
        self.scenario.graphs()
    }

    /// What disturbs `agent`, to be evaluated in any step.
    ///
    /// # Errors
    /// [`Refusal`] if the scenario has no such agent.
    pub fn disturbance(&self, agent: AgentNumber) -> Result<Disturbance, Refusal> {
        self.row(agent)?;
        Ok(self.context().disturbance[agent.index()].clone())
    }

    fn row(&self, agent: AgentNumber) -> Result<&crate::scenario::Agent, Refusal> {
        self.agent_called(agent.get())?;
        Ok(&self.context().agents[agent.index()])
    }

    /// A signal of the plant of its own agent, of this step.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such signal of `D` numbers; so for all that follow.
    pub fn state<const D: usize>(&self, name: &str) -> Result<In<D>, Refusal> {
        self.state_of(self.agent()?, name)
    }

    /// A signal of the plant of any agent, of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn state_of<const D: usize>(&self, agent: AgentNumber, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Plant, agent, name)
    }

    /// A signal of the planner for its own agent, of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn reference<const D: usize>(&self, name: &str) -> Result<In<D>, Refusal> {
        self.reference_of(self.agent()?, name)
    }

    /// A signal of the planner for any agent, of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn reference_of<const D: usize>(&self, agent: AgentNumber, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Planner, agent, name)
    }

    /// A signal of the observer of its own agent, of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn estimate<const D: usize>(&self, name: &str) -> Result<In<D>, Refusal> {
        self.estimate_of(self.agent()?, name)
    }

    /// A signal of the observer of any agent, of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn estimate_of<const D: usize>(&self, agent: AgentNumber, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Observer, agent, name)
    }

    /// A signal of the controller of its own agent, of the step before.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn command_before<const D: usize>(&self, name: &str) -> Result<In<D>, Refusal> {
        self.command_before_of(self.agent()?, name)
    }

    /// A signal of the controller of any agent, of the step before.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn command_before_of<const D: usize>(&self, agent: AgentNumber, name: &str) -> Result<In<D>, Refusal> {
        self.read(Role::Controller, agent, name)
    }

    /// A signal of its own agent to write, as the participant that is replaced declares it.
    ///
    /// # Errors
    /// [`Refusal`] if it declares no such output of `D` numbers.
    pub fn out<const D: usize>(&self, name: &str) -> Result<Out<D>, Refusal> {
        self.out_of(self.agent()?, name)
    }

    /// The same for any agent that it serves.
    ///
    /// # Errors
    /// See [`Interface::out`].
    pub fn out_of<const D: usize>(&self, agent: AgentNumber, name: &str) -> Result<Out<D>, Refusal> {
        self.station.bind(KIND).out(agent.index(), name)
    }

    /// A signal of `length` numbers to read; that of a controller is of the step before, others are of this step.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn input(&self, role: Role, agent: AgentNumber, name: &str, length: usize) -> Result<Slice, Refusal> {
        self.station.bind(KIND).slice(role, agent.index(), name, length, timing(role))
    }

    /// A signal of `length` numbers of any participant: of the step before, or of this step. The scenario must let this program
    /// read it at that time.
    ///
    /// # Errors
    /// See [`Interface::state`].
    pub fn signal(
        &self,
        role: Role,
        agent: AgentNumber,
        name: &str,
        length: usize,
        timing: Timing,
    ) -> Result<Slice, Refusal> {
        self.station.bind(KIND).slice_exactly(role, agent.index(), name, length, timing)
    }

    /// How many numbers the signal `name` of `role` for an agent has.
    ///
    /// # Errors
    /// [`Refusal`] if there is no such signal.
    pub fn size(&self, role: Role, agent: AgentNumber, name: &str) -> Result<usize, Refusal> {
        self.station.bind(KIND).size(role, agent.index(), name)
    }

    /// The role that the program plays.
    pub fn role(&self) -> Role {
        self.station.role()
    }

    /// A signal of `length` numbers to write.
    ///
    /// # Errors
    /// See [`Interface::out`].
    pub fn output(&self, agent: AgentNumber, name: &str, length: usize) -> Result<Slice, Refusal> {
        self.station.bind(KIND).slice_out(agent.index(), name, length)
    }

    /// The parts of its outputs that were not bound so far. A program in the place of a participant has to write zeros there at
    /// every step; [`participant`](super::participant) does.
    pub fn unbound(&self) -> Vec<Slice> {
        self.station.unbound()
    }

    fn read<const D: usize>(&self, role: Role, agent: AgentNumber, name: &str) -> Result<In<D>, Refusal> {
        self.station.bind(KIND).read(role, agent.index(), name, timing(role))
    }
}

fn timing(role: Role) -> Timing {
    if role == Role::Controller { Timing::Delayed } else { Timing::SameStep }
}
