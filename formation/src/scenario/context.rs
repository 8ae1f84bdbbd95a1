//! What every component of a run may know of its scenario.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::agents::read_agents;
use super::formulas::Formulas;
use super::model::{Surroundings, Vehicles};
use super::topology::read_topology;
use super::{ACTUATORS, Agent, Disturbance, Instruments, Links, Obstacles, Proximity, SENSORS, Timing};
use crate::config::{Node, PerAgent, Problem, Problems, Sort, did_you_mean, read};
use crate::data::{DataCurves, Library};
use crate::formula::{Expression, Formula, Jet};
use crate::math::TopologySchedule;
use crate::vehicle::Actuator;

/// The parts of a scenario that are not parameters of one component.
#[derive(Clone, Debug)]
pub struct Context {
    /// The agents in order.
    pub agents: Vec<Agent>,
    /// The names of `[vehicles]`, whether an agent has one or not.
    pub vehicles: Vec<String>,
    /// Who receives from whom, over time.
    pub topology: TopologySchedule,
    /// The graph need not be strongly connected: the scenario says so, or only some of its agents were chosen.
    pub any_graph: bool,
    /// Links that appear when agents come close; `None` if the scenario has none or has switched them off.
    pub proximity: Option<Proximity>,
    /// The clock.
    pub timing: Timing,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Every input is clipped to [-limit, limit]; `None`: not at all.
    pub input_limit: Option<f64>,
    /// What else the actuators do to the inputs, if the scenario says anything about it.
    pub actuator: Option<Actuator>,
    /// Named numbers of the scenario, for formulas.
    pub parameters: BTreeMap<String, f64>,
    /// For each agent, the formulas of its reference coordinates over the slot 0 = t.
    pub reference: Vec<Vec<Formula>>,
    /// For each agent, what disturbs it.
    pub disturbance: Vec<Disturbance>,
    /// What the agents must not run into, if there is anything.
    pub obstacles: Option<Obstacles>,
    /// What observers and controllers see of the plant, if it is not what it publishes.
    pub sensors: Option<Instruments>,
    /// What becomes of the commands on their way to the plant, if they do not stay as they are.
    pub actuators: Option<Instruments>,
    /// What agents receive of each other, if it is not what the others publish.
    pub links: Option<Links>,
    /// The data files of formulas in the sections of roles.
    pub curves: DataCurves,
}

impl Context {
    /// Number of coordinates of the references of the thesis's vehicles; with others, a reference has as many as it is given.
    pub const REFERENCE_COORDINATES: usize = 3;

    /// Reads everything, data files from `library`; what is wrong goes to `problems`.
    pub(super) fn read(root: &Node, seed: u64, library: &RefCell<Library>, problems: &mut Problems) -> Option<Self> {
        let timing = read_timing(root, problems);
        let parameters = match root.at("parameters") {
            Some(node) => read_parameters(node, problems),
            None => BTreeMap::new(),
        };
        for (name, value) in parameters.iter().filter(|(_, value)| !value.is_finite()) {
            problems.at(root, &format!("parameters.{name}"), format!("expected a finite number, found {value}"));
        }
        let vehicles = Vehicles::read(root, problems)?;
        let (input_limit, actuator) =
            vehicles.standard().map_or((None, None), |section| (section.input_limit, section.actuator));
        if let Some(limit) = input_limit.filter(|limit| limit.is_nan() || *limit <= 0.0) {
            problems.at(root, "vehicle.UM", format!("expected a limit > 0, found {limit}"));
        }
        for (field, message) in actuator.iter().flat_map(|actuator| actuator.bouc_wen.findings()) {
            problems.at(root, &format!("vehicle.actuator.bouc_wen.{field}"), message);
        }
        let agents = read_agents(Surroundings { root, parameters: &parameters, seed, library }, &vehicles, problems);
        let links = read_topology(root, &agents, seed, timing.dt, problems);
        let named = root.at("vehicles").and_then(Node::as_table);
        let named = named.into_iter().flat_map(|table| table.iter()).map(|(name, _)| name.to_string());
        let mut context = Self {
            agents,
            vehicles: named.collect(),
            topology: links.topology,
            any_graph: links.any_graph,
            proximity: links.proximity,
            timing,
            seed,
            input_limit,
            actuator,
            parameters,
            reference: Vec::new(),
            disturbance: Vec::new(),
            obstacles: Obstacles::read(root, problems),
            sensors: None,
            actuators: None,
            links: None,
            curves: DataCurves::default(),
        };
        let ids: Vec<u32> = context.agents.iter().map(|agent| agent.id).collect();
        context.sensors = Instruments::read(root, SENSORS, &ids, problems);
        context.actuators = Instruments::read(root, ACTUATORS, &ids, problems);
        context.links = Links::read(root, &ids, library, problems);
        context.compile_reference(root, vehicles.are_standard(), library, problems);
        context.compile_disturbance(root, library, problems);
        Some(context)
    }

    /// The number that `rule` gives each agent, in order.
    ///
    /// # Errors
    /// See [`PerAgent::resolve`].
    pub fn resolve(&self, rule: &PerAgent) -> Result<Vec<f64>, String> {
        let ids: Vec<u32> = self.agents.iter().map(|agent| agent.id).collect();
        rule.resolve(self.agents.len(), &ids)
    }

    /// The number that `rule` gives the agent at `place` (from 0).
    ///
    /// # Errors
    /// See [`PerAgent::value`].
    pub fn value(&self, rule: &PerAgent, place: usize) -> Result<f64, String> {
        rule.value(self.agents.len(), place, self.agents[place].id)
    }

    /// Value of a name that does not vary during a run, for the formulas of one agent.
    pub fn constant(&self, agent: &Agent, name: &str) -> Option<f64> {
        match name {
            "i" => Some(f64::from(agent.id)),
            "N" => Some(self.agents.len() as f64),
            _ => {
                let own = self.parameters.get(name).copied().or_else(|| agent.vehicle.parameter(name));
                own.or_else(|| (name == "seed").then_some(self.seed as f64))
            }
        }
    }

    fn compile_reference(
        &mut self,
        root: &Node,
        is_standard: bool,
        library: &RefCell<Library>,
        problems: &mut Problems,
    ) {
        let given = root.at("reference.position").and_then(Node::as_array).map_or(0, <[Node]>::len);
        let coordinates = if is_standard { Self::REFERENCE_COORDINATES } else { given.max(1) };
        if !is_standard && root.at("reference").is_none() {
            return;
        }
        let is_table = root.at("reference").is_none_or(|node| node.as_table().is_some());
        if is_table && root.at("reference.position").is_none() {
            problems.at(root, "reference", "missing field `position`: a list of formulas of t and i");
            return;
        }
        check_keys(root, "reference", &["position", "define"], problems);
        let formulas = Formulas { root, section: "reference", library: Some(library), variables: vec![("t", 0)] };
        let finding = |formula: &Formula| {
            let jet = formula.evaluate_jet(&[Jet::time(0.0)]);
            let named = [("value", jet.value), ("velocity", jet.rate), ("acceleration", jet.acceleration)];
            named.iter().find(|(_, value)| !value.is_finite()).map(|(name, value)| format!("its {name} is {value}"))
        };
        let mut is_finite = problems.is_empty();
        for agent in &self.agents {
            let constant = |name: &str| self.constant(agent, name);
            let Some(compiled) = formulas.compile("position", coordinates, &constant, problems) else {
                return;
            };
            // Only the first agent is reported, and only if the numbers are those of the scenario.
            is_finite =
                is_finite && formulas.check_start("position", agent.number, &compiled, &constant, &finding, problems);
            self.reference.push(compiled);
        }
    }

    fn compile_disturbance(&mut self, root: &Node, library: &RefCell<Library>, problems: &mut Problems) {
        let keys = ["matched", "matched_first_order", "mismatched", "define"];
        check_keys(root, "disturbance", &keys, problems);
        for agent in &self.agents {
            let vehicle = &agent.vehicle;
            if let Some(model) = vehicle.model() {
                let all_are_models = || self.agents.iter().all(|agent| agent.vehicle.model().is_some());
                if root.at("disturbance").is_some() && all_are_models() {
                    let message = format!(
                        "the vehicle `{}` is given by equations: write what disturbs it into them, as in d.v = \"u/m + 0.1*sin(t)\"",
                        model.kind
                    );
                    problems.at(root, "disturbance", message);
                    return;
                }
                self.disturbance.push(Disturbance::default());
                continue;
            }
            let length = vehicle.coordinates();
            let generic: Vec<String> =
                (1..=length).map(|j| format!("x{j}")).chain((1..=length).map(|j| format!("v{j}"))).collect();
            let named = vehicle.coordinate_names().iter().chain(vehicle.velocity_names()).copied();
            let variables = std::iter::once(("t", 0))
                .chain(named.zip(1..))
                .chain(generic.iter().map(String::as_str).zip(1..))
                .collect();
            let formulas = Formulas { root, section: "disturbance", library: Some(library), variables };
            let before = problems.len();
            let is_sound = problems.is_empty();
            let constant = |name: &str| self.constant(agent, name);
            let slots: Vec<f64> = [0.0].iter().chain(&agent.position).chain(&agent.velocity).copied().collect();
            let finding = |formula: &Formula| {
                let value = formula.evaluate(&slots);
                (!value.is_finite()).then(|| format!("its value is {value}"))
            };
            let mut list = |field: &str| {
                let compiled = formulas.compile(field, length, &constant, problems).unwrap_or_default();
                if is_sound {
                    formulas.check_start(field, agent.number, &compiled, &constant, &finding, problems);
                }
                compiled
            };
            let first_order = vehicle.order() == 1 && root.at("disturbance.matched_first_order").is_some();
            let matched = list(if first_order { "matched_first_order" } else { "matched" });
            let mismatched = if vehicle.order() == 1 { Vec::new() } else { list("mismatched") };
            self.disturbance.push(Disturbance { matched, mismatched });
            if problems.len() > before {
                return; // the other agents would repeat it
            }
        }
    }
}

fn section<T: serde::de::DeserializeOwned>(root: &Node, name: &str, problems: &mut Problems) -> Option<T> {
    match root.at(name) {
        Some(node) => read(node, name, problems),
        None => {
            problems.at(root, "", format!("missing section `[{name}]`"));
            None
        }
    }
}

/// The named numbers; a dummy where one is wrong, which is reported, so that formulas know the name.
fn read_parameters(node: &Node, problems: &mut Problems) -> BTreeMap<String, f64> {
    let Some(table) = node.as_table() else {
        return read::<BTreeMap<String, f64>>(node, "parameters", problems).unwrap_or_default();
    };
    let number = |(name, node): (&str, &Node)| {
        let path = format!("parameters.{name}");
        let is_formula = |text: &str| Expression::parse(text).is_ok_and(|parsed| parsed.names().is_empty());
        if node.as_str().is_some_and(|text| !is_formula(text)) {
            let message = format!("expected a number, found {}", node.describe());
            let help = "texts and paths for a program belong to its role, as in `[controller.with]`";
            problems.push(Problem::new(Some(node.origin.clone()), path, message).with_help(help));
            return (name.to_string(), 1.0);
        }
        (name.to_string(), read::<f64>(node, &path, problems).unwrap_or(1.0))
    };
    table.iter().map(number).collect()
}

/// The clock; a dummy where something is wrong, which is reported.
fn read_timing(root: &Node, problems: &mut Problems) -> Timing {
    let dummy = Timing { dt: 1.0, duration: 1.0 };
    let Some(timing) = section::<Timing>(root, "timing", problems) else { return dummy };
    let findings = timing.findings();
    if findings.is_empty() {
        // All participants compute with the double that the step stands for.
        return Timing { dt: timing.period().seconds(), ..timing };
    }
    for (field, message) in findings {
        problems.at(root, &format!("timing.{field}"), message);
    }
    dummy
}

fn check_keys(root: &Node, section: &str, known: &[&str], problems: &mut Problems) {
    let Some(node) = root.at(section) else { return };
    let Some(table) = node.as_table() else {
        problems.at(root, section, format!("expected a table with {}, found {}", known.join(", "), node.describe()));
        return;
    };
    for (name, _) in table.iter().filter(|(name, _)| !known.contains(name)) {
        let hint = did_you_mean(name, known.iter().copied());
        let message = format!("unknown field, expected one of {}{hint}", known.join(", "));
        problems.at(root, &format!("{section}.{name}"), message).sort = Sort::Unknown;
    }
}
