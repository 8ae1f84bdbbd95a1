//! The place of a participant in a planned network, and what builds it there, for programs that take the place of one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lockstep::{Network, Node, Participant, Plan, Slice};

use super::assembly::node_name;
use super::components::read_component;
use super::unbound::{Bound, zeroed};
use super::{Bind, Interface, Kind, Refusal, Role, Signals, ranges};
use crate::config::{Problem, Problems, read_text};
use crate::data::DataSource;
use crate::scenario::{Context, Scenario, Selection, agents_in};

/// Name of the effective scenario in the run directory, from which every process builds its participants.
pub const SCENARIO_FILE: &str = "scenario.toml";

/// Environment variable with the folder of the scenario file, which paths for programs start from.
pub const SCENARIO_FOLDER: &str = "PHALANX_SCENARIO_FOLDER";

/// Environment variable with the path of the run directory.
const RUN_DIRECTORY: &str = "PHALANX_RUN_DIR";

/// The text of the effective scenario of the run that this process is part of.
///
/// # Errors
/// Says why it cannot be read, or that it is not the one that the run was started with; outside a run there is none.
pub fn scenario_text() -> Result<String, String> {
    let directory = std::env::var_os(RUN_DIRECTORY).ok_or_else(|| format!("{RUN_DIRECTORY} is not set"))?;
    let path = Path::new(&directory).join(SCENARIO_FILE);
    let text = read_text(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let plan = Plan::read(Path::new(&directory)).map_err(|error| error.to_string())?;
    plan.check_source(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(text)
}

/// What a process of a run chooses of the effective scenario: nothing but the data files in the run directory.
pub fn run_selection() -> Selection {
    let directory = std::env::var_os(RUN_DIRECTORY).map_or(DataSource::None, |path| DataSource::Folder(path.into()));
    Selection { data: directory, ..Selection::default() }
}

/// What builds the participants of a process: from the plan of the run and the numbers of the nodes to host.
pub type Built = Result<Vec<Box<dyn Participant>>, String>;

/// For `processes::serve`: any participants of `role` whose component is one of `kinds`.
pub fn kinds(role: Role, kinds: &'static [Kind]) -> impl FnOnce(&Plan, &[usize]) -> Built {
    move |plan, nodes| {
        let scenario = load_scenario()?;
        let mut problems = Problems::default();
        let Some((_, kind, component)) = read_component(&scenario, role, kinds, &mut problems) else {
            return Err(first(problems.into_vec()));
        };
        let site = Site { scenario: &scenario, plan, role, signals: Arc::new(signals_of(&plan.network)) };
        nodes
            .iter()
            .map(|&node| site.build(node, kind.name, |agents, bind| component.build(&scenario.context, agents, bind)))
            .collect()
    }
}

/// For `processes::serve`: one participant of a user's program.
///
/// `make` is given the [`Interface`] of the participant, which has its place in the run, the numbers of the scenario, the graph,
/// and the signals that the replaced component reads and writes.
///
/// ```no_run
/// use formation::wiring::{Role, participant};
/// use lockstep::{Fault, In, Io, Out, Participant, Step};
///
/// struct Tracking { position: In<3>, velocity: In<3>, target: In<3>, target_velocity: In<3>, input: Out<3> }
///
/// impl Participant for Tracking {
///     fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
///         let (x, v) = (io.get(self.position), io.get(self.velocity));
///         let (r, w) = (io.get(self.target), io.get(self.target_velocity));
///         io.set(self.input, std::array::from_fn(|j| 4.0 * (r[j] - x[j]) + 4.0 * (w[j] - v[j])));
///         Ok(())
///     }
/// }
///
/// let controller = participant(Role::Controller, |me| Ok(Tracking {
///     position: me.state("position")?,
///     velocity: me.state("velocity")?,
///     target: me.reference("position")?,
///     target_velocity: me.reference("velocity")?,
///     input: me.out("input")?,
/// }));
/// # let _: Box<dyn FnOnce(&lockstep::Plan, &[usize]) -> formation::wiring::Built> = Box::new(controller);
/// // The whole `main` of the program: processes::serve(controller)
/// ```
pub fn participant<P: Participant + 'static>(
    role: Role,
    make: impl Fn(&Interface) -> Result<P, Refusal>,
) -> impl FnOnce(&Plan, &[usize]) -> Built {
    move |plan, nodes| {
        let scenario = load_scenario()?;
        let site = Site { scenario: &scenario, plan, role, signals: Arc::new(signals_of(&plan.network)) };
        let built = nodes.iter().map(|&node| {
            let me = Interface::new(scenario.clone(), site.station(node)?, plan.dt, plan.steps);
            let participant = make(&me).map_err(|refusal| refusal.to_string())?;
            Ok(site.guarded(node, zeroed(Box::new(participant), me.unbound())))
        });
        built.collect()
    }
}

/// For `processes::serve`: a participant of `role` that also does something at the end of a step, the second of its nodes,
/// which publishes nothing.
/// `make` is given the scenario's context, the number of the agent (from 0), and a [`Bind`] for each of both.
pub fn pair(
    role: Role,
    make: impl FnOnce(&Context, usize, &mut Bind, &mut Bind) -> Result<[Box<dyn Participant>; 2], Refusal>,
) -> impl FnOnce(&Plan, &[usize]) -> Built {
    move |plan, nodes| {
        let [first, second] = *nodes else { return Err(format!("{} nodes are planned, expected 2", nodes.len())) };
        let scenario = load_scenario()?;
        let signals = signals_of(&plan.network);
        let agents = agents_of(&scenario, role, &plan.network.nodes[first].name)?;
        let [agent] = agents[..] else { return Err(format!("it serves one agent, not {}", agents.len())) };
        let planned = [first, second].map(|node| &plan.network.nodes[node]);
        let bound = [Bound::default(), Bound::default()];
        let bind = |at: usize| Bind::adopt(&signals, role, "own program", planned[at], &bound[at]);
        let (mut head, mut tail) = (bind(0), bind(1));
        let made = make(&scenario.context, agent, &mut head, &mut tail).map_err(|refusal| refusal.to_string())?;
        let unbound = planned.iter().zip(&bound).map(|(node, bound)| bound.unbound(&signals, &node.outputs));
        Ok(made.into_iter().zip(unbound).map(|(participant, unbound)| zeroed(participant, unbound)).collect())
    }
}

/// The effective scenario of the run that this process is part of: variant and overrides are in it.
///
/// # Errors
/// Says why it cannot be read; outside a run there is none.
pub fn load_scenario() -> Result<Scenario, String> {
    let mut scenario = Scenario::load(SCENARIO_FILE, &scenario_text()?, &run_selection()).map_err(first)?;
    scenario.folder = std::env::var_os(SCENARIO_FOLDER).map(PathBuf::from);
    Ok(scenario)
}

fn first(problems: Vec<Problem>) -> String {
    problems.first().map(Problem::to_string).unwrap_or_default()
}

/// The place that a participant of another program takes in a planned network.
#[derive(Clone, Debug)]
pub struct Station {
    /// The agents (from 0) that it serves.
    pub agents: Vec<usize>,
    /// Its node as planned.
    pub node: Node,
    signals: Arc<Signals>,
    role: Role,
    /// What is bound of its outputs.
    bound: Bound,
}

impl Station {
    /// The place of node number `node`.
    ///
    /// # Errors
    /// Says that the node is of another role.
    pub fn new(scenario: &Scenario, plan: &Plan, role: Role, node: usize) -> Result<Self, String> {
        Site { scenario, plan, role, signals: Arc::new(signals_of(&plan.network)) }.station(node)
    }

    /// Its role.
    pub fn role(&self) -> Role {
        self.role
    }

    /// Whether it serves all agents, and not one of them.
    pub fn serves_all(&self) -> bool {
        self.node.name == self.role.name()
    }

    /// Offers the signals that the planned node reads and writes, to a participant that messages call `kind`.
    pub fn bind<'a>(&'a self, kind: &'a str) -> Bind<'a> {
        Bind::adopt(&self.signals, self.role, kind, &self.node, &self.bound)
    }

    /// The parts of its outputs that nothing was bound to so far.
    pub fn unbound(&self) -> Vec<Slice> {
        self.bound.unbound(&self.signals, &self.node.outputs)
    }
}

/// The run that a process takes part in; its signals are the same for all nodes of the process.
struct Site<'a> {
    scenario: &'a Scenario,
    plan: &'a Plan,
    role: Role,
    signals: Arc<Signals>,
}

impl Site<'_> {
    /// The place of node number `node`.
    fn station(&self, node: usize) -> Result<Station, String> {
        let planned = &self.plan.network.nodes[node];
        let agents = agents_of(self.scenario, self.role, &planned.name)?;
        let (signals, bound) = (Arc::clone(&self.signals), Bound::default());
        Ok(Station { agents, node: planned.clone(), signals, role: self.role, bound })
    }

    /// Builds the participant of a node on the ports that the plan gives it.
    fn build(
        &self,
        node: usize,
        kind: &str,
        make: impl FnOnce(&[usize], &mut Bind) -> Result<Box<dyn Participant>, Refusal>,
    ) -> Result<Box<dyn Participant>, String> {
        let station = self.station(node)?;
        let participant = make(&station.agents, &mut station.bind(kind)).map_err(|refusal| refusal.to_string())?;
        Ok(self.guarded(node, zeroed(participant, station.unbound())))
    }

    /// The participant with the ranges that the scenario declares for its outputs.
    fn guarded(&self, node: usize, participant: Box<dyn Participant>) -> Box<dyn Participant> {
        ranges::guard(self.scenario, &self.signals, self.role, &self.plan.network.nodes[node], participant)
    }
}

/// The agents (from 0) that the node called `name` serves.
fn agents_of(scenario: &Scenario, role: Role, name: &str) -> Result<Vec<usize>, String> {
    let count = scenario.context.agents.len();
    if name == role.name() {
        return Ok((0..count).collect());
    }
    let agents = name.rsplit('_').next().and_then(agents_in);
    let agents = agents.filter(|agents| agents.iter().all(|&agent| agent <= count));
    let agents: Option<Vec<usize>> = agents.map(|agents| agents.into_iter().map(|agent| agent - 1).collect());
    let found = agents.filter(|agents| node_name(role, agents, false) == name);
    found.ok_or_else(|| format!("`{name}` is no {role}; this program serves as {role} only"))
}

fn signals_of(network: &Network) -> Signals {
    let owner = |topic: &str| {
        let (number, name) = topic.strip_prefix("/agent_")?.split_once('/')?;
        let role = Role::ALL.into_iter().find(|role| name == role.channel())?;
        Some((role, number.parse::<usize>().ok()?.checked_sub(1)?))
    };
    let ids = network.channels.iter().map(|channel| owner(&channel.topic)).collect();
    Signals::new(network.channels.clone(), ids).with_sources()
}
