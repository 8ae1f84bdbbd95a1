//! A controller by formulas: the law as a paper writes it, in the scenario file.

mod law;
mod read;

use formation::config::{FormulaText, FormulaTexts, Ordered, did_you_mean, is_signal_name};
use formation::formula::FORMULA_NAMES;
use formation::scenario::{Agent, Context};
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

use law::{Law, Program};

/// The law of every input as a formula. Formulas know `t`, `dt`, `i`, `N`, the parameters of the scenario and of the vehicle, the
/// signals of the own agent (`x`, `position[0]`, `reference.position[0]`, `estimate.x`, `command.input[0]` of the step before),
/// `b_i`, and in `sum(...)`, over the in-neighbours j, the weight `a_ij` and their signals (`x_j`, `reference_j.position[0]`).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Formulas {
    /// Names for parts of formulas; a later one may use those before it.
    #[serde(default)]
    pub define: Ordered<FormulaText>,
    /// States of the controller, such as the integral of an error.
    #[serde(default)]
    pub states: Ordered<ControllerState>,
    /// A formula for each input of the vehicle.
    #[serde(default)]
    pub law: Ordered<FormulaText>,
    /// The same by vehicle of `[vehicles]`, for agents that are not all alike.
    #[serde(default)]
    pub laws: Ordered<Ordered<FormulaText>>,
    /// What is published besides the inputs: a formula, or a list of formulas, without unit.
    #[serde(default)]
    pub signals: Ordered<FormulaTexts>,
}

/// A state of a controller.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerState {
    /// Its value at t = 0.
    #[serde(default)]
    pub initial: f64,
    /// Its time derivative, a formula; it is held over a step of the controller (explicit Euler).
    pub d: FormulaText,
}

impl Component for Formulas {
    fn check(&self, context: &Context) -> Checks {
        let mut checks = Checks::default();
        // A vehicle that could not be read has no states; that has been said.
        let is_known = |agent: &&Agent| agent.vehicle.model().is_none_or(|model| !model.states.is_empty());
        for agent in context.agents.iter().filter(is_known) {
            let (section, law) = self.law_of(&agent.vehicle_name);
            let inputs = read::inputs(&agent.vehicle);
            for input in &inputs {
                let example = format!(
                    "expected a formula for each input of the vehicle `{}`; missing: {input}",
                    agent.vehicle.kind()
                );
                checks = checks.require(law.get(input).is_some(), &section, example);
            }
            for (name, _) in law.iter().filter(|(name, _)| !inputs.iter().any(|input| input == name)) {
                let hint = did_you_mean(name, inputs.iter().map(String::as_str));
                let known = inputs.join(", ");
                let message = format!(
                    "the vehicle `{}` has no input of this name, expected one of {known}{hint}",
                    agent.vehicle.kind()
                );
                checks = checks.require(false, &format!("{section}.{name}"), message);
            }
            if !checks.findings.is_empty() {
                break; // the other agents would repeat it
            }
        }
        let names = context.agents.iter().map(|agent| agent.vehicle_name.as_str()).collect::<Vec<_>>();
        // With only some of the agents, the law of others has no use.
        let is_used = |name: &str| names.contains(&name) || context.vehicles.iter().any(|known| known == name);
        for (name, _) in self.laws.iter().filter(|(name, _)| !is_used(name)) {
            let message = format!("no agent has a vehicle `{name}` of [vehicles]");
            checks = checks.require(false, &format!("laws.{name}"), message);
        }
        let own = [("define", self.define.iter().map(|(name, _)| name).collect::<Vec<_>>())];
        let own = own.into_iter().chain([("states", self.states.iter().map(|(name, _)| name).collect())]);
        for (section, name) in own.flat_map(|(section, names)| names.into_iter().map(move |name| (section, name))) {
            let is_state = |agent: &Agent| {
                agent.vehicle.model().is_some_and(|model| model.states.iter().any(|state| state.name == name))
            };
            let is_taken = name == "sum" || FORMULA_NAMES.contains(&name) || context.agents.iter().any(is_state);
            let message = format!("`{name}` stands for something else in laws already: expected another name");
            checks = checks.require(!is_taken, &format!("{section}.{name}"), message);
        }
        for (name, _) in self.signals.iter() {
            let is_free = name != "input" && is_signal_name(name);
            let message =
                "expected lower-case letters, digits and single `_` inside, and not `input`, which the law gives";
            checks = checks.require(is_free, &format!("signals.{name}"), message);
        }
        checks
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        self.published(context, agent).fields()
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let program = Program::read(self, context, agent, bind)?;
        let outputs = self.published(context, agent).bind(agent, bind)?;
        Ok(Box::new(FormulasParticipant { law: Law::new(program), outputs }))
    }
}

impl Formulas {
    /// The law of a vehicle, and the field that holds it.
    fn law_of(&self, vehicle_name: &str) -> (String, &Ordered<FormulaText>) {
        match self.laws.get(vehicle_name) {
            Some(law) => (format!("laws.{vehicle_name}"), law),
            None => ("law".into(), &self.law),
        }
    }

    /// The outputs: the inputs of the vehicle, then the signals.
    fn published(&self, context: &Context, agent: usize) -> Outputs<Law> {
        let input = context.agents[agent].vehicle.input_field();
        let count = input.shape.words();
        let mut outputs =
            Outputs::new().any(input, |law: &Law, place| place.copy_from_slice(&law.values()[..place.len()]));
        let mut start = count;
        for (name, texts) in self.signals.iter() {
            let field = match texts {
                FormulaTexts::One(_) => Field::scalar(name, ""),
                FormulaTexts::Several(all) => Field::vector(name, all.len(), ""),
            };
            let length = field.shape.words();
            outputs = outputs.any(field, move |law, place| place.copy_from_slice(&law.values()[start..start + length]));
            start += length;
        }
        outputs
    }
}

struct FormulasParticipant {
    law: Law,
    outputs: BoundOutputs<Law>,
}

impl Participant for FormulasParticipant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.law.update(step, io);
        if let Some(fault) = self.law.fault() {
            return Err(fault);
        }
        self.outputs.write(io, &self.law);
        Ok(())
    }
}
