//! For tests of components: one by itself, between signals that the test sets.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use lockstep::{Channel, ChannelId, Fault, Field, Io, Layout, Participant, Ports, Step, Store};

use super::components::read_component;
use super::{Bind, Kind, Role, Signals};
use crate::config::{Problem, Problems};
use crate::math::SplitMix64;
use crate::scenario::{Context, Scenario, Selection};

/// A component by itself: a test sets what its participant reads, and sees what it publishes.
///
/// The other roles publish the usual signals (`position`, `velocity`, `disturbance`, `input`, ...) of every agent, 0 at first.
/// They stay as they are set. A planner or plant serves all agents, an observer or controller the first one.
///
/// `low_level_ctrl/src/consensus.rs` has a test to begin with.
pub struct TestBench {
    participant: Box<dyn Participant>,
    role: Role,
    agents: Vec<usize>,
    signals: Signals,
    ports: Ports,
    store: Store,
    next: u64,
    dt: f64,
}

impl TestBench {
    /// The component of `role` in the scenario `text`, which is one of `kinds`.
    ///
    /// # Errors
    /// What is wrong with the scenario or the component.
    pub fn new(text: &str, role: Role, kinds: &[Kind]) -> Result<Self, Vec<Problem>> {
        let scenario = Scenario::load("test.toml", text, &Selection::default())?;
        Self::of(&scenario, role, kinds).map(|(_, bench)| bench)
    }

    /// The component of `role` in a scenario, with the name of its kind.
    fn of(scenario: &Scenario, role: Role, kinds: &[Kind]) -> Result<(&'static str, Self), Vec<Problem>> {
        let mut problems = Problems::default();
        let component = read_component(scenario, role, kinds, &mut problems);
        let Some((_, kind, component)) = component.filter(|_| problems.is_empty()) else {
            problems.push(scenario.problem(role.name(), "no component of this role can be read"));
            return Err(problems.into_vec());
        };
        let context = &scenario.context;
        let signals = declare(context, |other, agent| {
            if other == role { component.outputs(context, agent) } else { usual(context, other, agent) }
        });
        let agents = match role {
            Role::Plant | Role::Planner => (0..context.agents.len()).collect(),
            Role::Observer | Role::Controller => vec![0],
        };
        let mut bind = Bind::new(&signals, role, kind.name, &agents);
        let built = component.build(context, &agents, &mut bind);
        let (inputs, outputs) = bind.into_edges();
        let participant = built.map_err(|refusal| vec![scenario.problem(role.name(), refusal.to_string())])?;
        let inputs = inputs.into_iter().map(|input| (input.channel, input.timing)).collect();
        let store = Store::new(signals.channels.iter().map(|channel| &channel.layout));
        let dt = context.timing.dt;
        let ports = Ports { inputs, outputs };
        Ok((kind.name, Self { participant, role, agents, signals, ports, store, next: 0, dt }))
    }

    /// Sets a signal of another role, for an agent counted from 0.
    ///
    /// # Panics
    /// If there is no such signal of so many values.
    pub fn set(&mut self, role: Role, agent: usize, name: &str, values: &[f64]) {
        let (channel, first, length) = self.find(role, agent, name);
        assert_eq!(length, values.len(), "the length of {name}");
        for step in [0, 1] {
            self.store.write(channel, step)[first..first + length].copy_from_slice(values);
        }
    }

    /// Lets the participant take one step.
    ///
    /// # Errors
    /// What the participant says.
    pub fn step(&mut self) -> Result<(), Fault> {
        for &output in &self.ports.outputs {
            self.store.write(output, self.next).fill(f64::NAN);
        }
        let step = Step { index: self.next, dt: self.dt };
        self.participant.step(&step, &mut Io::new(&mut self.store, &self.ports, self.next))?;
        self.next += 1;
        Ok(())
    }

    /// What was published in the last step, for an agent counted from 0; NaN what was not written.
    ///
    /// # Panics
    /// If there was no step, or there is no such output.
    pub fn output(&self, agent: usize, name: &str) -> &[f64] {
        assert!(self.next > 0, "no step was taken");
        let (channel, first, length) = self.find(self.role, agent, name);
        &self.store.read(channel, self.next - 1)[first..first + length]
    }

    fn find(&self, role: Role, agent: usize, name: &str) -> (ChannelId, usize, usize) {
        let channel = self.signals.find(role, agent);
        let field = channel.and_then(|channel| Some((channel, self.signals.layout(channel).find(name)?)));
        let (channel, (first, length)) =
            field.unwrap_or_else(|| panic!("the {role} of agent {} has no signal {name}", agent + 1));
        (channel, first, length)
    }

    /// Sets all that other roles publish to numbers between -1 and 1.
    fn excite(&mut self, random: &mut SplitMix64) {
        for channel in 0..self.signals.channels.len() {
            let channel = ChannelId(channel);
            if !self.ports.outputs.contains(&channel) {
                let length = self.store.read(channel, 0).len();
                let values: Vec<f64> = (0..length).map(|_| random.symmetric()).collect();
                [0, 1].into_iter().for_each(|step| self.store.write(channel, step).copy_from_slice(&values));
            }
        }
    }
}

/// Checks how the components of a role respond to seeded inputs: for every kind, in the first scenario of the folder `scenarios`
/// and the first variant that has it, what each output is after three steps. Two outputs that are swapped, or a changed law,
/// differ from the file `expected`, which is written anew if `PHALANX_WRITE_PAGES` is set.
///
/// # Panics
/// If something differs, a kind is in none of the scenarios, or its participant fails or does not write an output.
pub fn check_responses(role: Role, kinds: &[Kind], scenarios: &Path, expected: &Path) {
    let scenarios = all_variants(scenarios);
    let mut found = String::new();
    for kind in kinds {
        let mut benches = scenarios.iter().filter_map(|scenario| TestBench::of(scenario, role, kinds).ok());
        let bench = benches.find(|(name, _)| *name == kind.name);
        let (_, bench) = bench.unwrap_or_else(|| panic!("{}: in no scenario", kind.name));
        respond(&mut found, kind.name, bench);
    }
    if std::env::var_os("PHALANX_WRITE_PAGES").is_some() {
        std::fs::write(expected, &found).unwrap_or_else(|error| panic!("{}: {error}", expected.display()));
    }
    assert_eq!(found, read(expected), "{}", expected.display());
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The scenarios of a folder, each in all its variants.
fn all_variants(folder: &Path) -> Vec<Scenario> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    let mut scenarios = Vec::new();
    for file in files.iter().filter(|file| file.extension().is_some_and(|extension| extension == "toml")) {
        let text = read(file);
        let load = |variant: Option<String>| {
            let selection = Selection { variant, ..Selection::default() };
            let loaded = Scenario::load(&file.display().to_string(), &text, &selection);
            loaded.unwrap_or_else(|problems| panic!("{}", problems[0]))
        };
        let first = load(None);
        let others = first.variants.iter().filter(|variant| **variant != first.variant);
        let others: Vec<Scenario> = others.map(|variant| load(Some(variant.clone()))).collect();
        scenarios.push(first);
        scenarios.extend(others);
    }
    scenarios
}

fn respond(text: &mut String, kind: &str, mut bench: TestBench) {
    let mut random = SplitMix64::new(1);
    for _ in 0..3 {
        bench.excite(&mut random);
        bench.step().unwrap_or_else(|fault| panic!("{kind}: {fault}"));
    }
    // One agent shows what the table of outputs does.
    let channel = bench.ports.outputs[0];
    for Field { name, .. } in bench.signals.layout(channel).fields() {
        let values = bench.output(bench.agents[0], name);
        assert!(values.iter().all(|value| !value.is_nan()), "{kind}: {name} is not written");
        let shown: Vec<String> = values.iter().take(3).map(|value| format!("{value:.9e}")).collect();
        // Writing to a string does not fail.
        let _ = writeln!(text, "{kind} {name} {}", shown.join(" "));
    }
}

/// The channels of all roles for all agents.
fn declare(context: &Context, fields: impl Fn(Role, usize) -> Vec<Field>) -> Signals {
    let places = Role::ALL.into_iter().flat_map(|role| (0..context.agents.len()).map(move |agent| (role, agent)));
    let channels = places.clone().map(|(role, agent)| Channel {
        topic: format!("/agent_{}/{}", agent + 1, role.channel()),
        agent: agent as u32 + 1,
        layout: Layout::new(fields(role, agent)),
        initial: Vec::new(),
    });
    Signals::new(channels.collect(), places.map(Some).collect())
}

/// What components of this role publish in one scheme or another.
fn usual(context: &Context, role: Role, agent: usize) -> Vec<Field> {
    let vehicle = &context.agents[agent].vehicle;
    let vectors = |names: &[&str], length: usize| names.iter().map(|name| Field::vector(name, length, "")).collect();
    match role {
        Role::Plant => vectors(&["position", "velocity", "acceleration"], vehicle.coordinates()),
        Role::Planner => vectors(&["position", "velocity", "acceleration", "jerk"], 3),
        Role::Observer => {
            let rates = ["disturbance_rate", "mismatched", "mismatched_rate"];
            let references = ["reference_velocity", "reference_acceleration"];
            let names = [&["position", "velocity", "disturbance"][..], &rates, &references].concat();
            vectors(&names, vehicle.coordinates())
        }
        Role::Controller => vec![vehicle.input_field()],
    }
}
