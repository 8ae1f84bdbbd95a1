//! From the texts of a law to its code: names become slots.

use std::cell::Cell;
use std::sync::Arc;

use formation::config::{FormulaText, FormulaTexts};
use formation::formula::{Cursor, Curve, DataCall, DataError, Expression, Formula, FormulaError, Operand, Operands};
use formation::scenario::{AdjacencyRow, Agent, Context};
use formation::vehicle::Vehicle;
use formation::wiring::{Bind, Refusal, Role};
use lockstep::{Slice, Timing};

use super::Formulas;
use super::law::{Neighbour, Part, Program};

/// The names of the inputs of a vehicle: those of its equations, or u1, u2, ...
pub(super) fn inputs(vehicle: &Vehicle) -> Vec<String> {
    match vehicle.model() {
        Some(model) => model.inputs.iter().map(|input| input.name.clone()).collect(),
        None => (1..=vehicle.inputs()).map(|number| format!("u{number}")).collect(),
    }
}

/// The sources that a formula names, with the role that publishes them and the sample that is read.
const SOURCES: [(&str, Role, Timing); 4] = [
    ("state", Role::Plant, Timing::SameStep),
    ("reference", Role::Planner, Timing::SameStep),
    ("estimate", Role::Observer, Timing::SameStep),
    ("command", Role::Controller, Timing::Delayed),
];

/// What a name of a signal in a formula stands for.
#[derive(Clone, PartialEq)]
struct Reading {
    role: Role,
    timing: Timing,
    name: String,
    element: usize,
}

/// Compiles a law.
struct Compiler<'a, 'b> {
    context: &'a Context,
    agent: usize,
    /// A neighbour, whose signals are those of all; another agent if there is none.
    example: usize,
    bind: &'a mut Bind<'b>,
    /// Number of slots so far. Slot 0 is the time, slots 1 and 2 are a_ij and j, slot 3 is b_i.
    slots: usize,
    /// What is read of the own agent, with the slot of it.
    own: Vec<(Reading, Slice, usize)>,
    /// What is read of each neighbour, with the slot of it.
    of_neighbour: Vec<(Reading, usize)>,
    parts: Vec<(Part, usize)>,
    /// Definitions and states of the controller.
    named: Vec<(String, usize)>,
}

const LINK: [usize; 2] = [1, 2];
const REFERENCE_WEIGHT: usize = 3;

impl Program {
    /// Compiles the law of `agent` and binds what it reads.
    pub(super) fn read(law: &Formulas, context: &Context, agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        let row = AdjacencyRow::new(&context.topology, context.proximity.clone(), agent);
        let heard = row.heard().to_vec();
        let mut compiler = Compiler {
            context,
            agent,
            example: heard.first().copied().unwrap_or((agent + 1) % context.agents.len()),
            bind,
            slots: REFERENCE_WEIGHT + 1,
            own: Vec::new(),
            of_neighbour: Vec::new(),
            parts: Vec::new(),
            named: Vec::new(),
        };
        let mut initial = Vec::new();
        for (name, state) in law.states.iter() {
            let slot = compiler.slot();
            compiler.named.push((name.into(), slot));
            initial.push((slot, state.initial));
        }
        for (name, text) in law.define.iter() {
            let formula = compiler.formula(&format!("define.{name}"), text)?;
            let slot = compiler.slot();
            compiler.parts.push((Part::Value(formula), slot));
            compiler.named.push((name.into(), slot));
        }
        let (section, texts) = law.law_of(&context.agents[agent].vehicle_name);
        let (mut results, mut texts_of_results) = (Vec::new(), Vec::new());
        let mut result = |compiler: &mut Compiler, path: String, text: &FormulaText| {
            results.push(compiler.formula(&path, text)?);
            texts_of_results.push((path, text.0.clone()));
            Ok::<(), Refusal>(())
        };
        for input in inputs(&context.agents[agent].vehicle) {
            // A missing one has been reported by the check.
            let Some(text) = texts.get(&input) else { continue };
            result(&mut compiler, format!("{section}.{input}"), text)?;
        }
        for (name, texts) in law.signals.iter() {
            let path = format!("signals.{name}");
            match texts {
                FormulaTexts::One(text) => result(&mut compiler, path, text)?,
                FormulaTexts::Several(all) => {
                    for (place, text) in all.iter().enumerate() {
                        result(&mut compiler, format!("{path}.{}", place + 1), text)?;
                    }
                }
            }
        }
        let mut states = Vec::new();
        for (place, (name, state)) in law.states.iter().enumerate() {
            states.push((initial[place].0, compiler.formula(&format!("states.{name}.d"), &state.d)?));
        }
        compiler.finish(row, &heard, states, (results, texts_of_results), initial)
    }
}

impl Compiler<'_, '_> {
    fn slot(&mut self) -> usize {
        self.slots += 1;
        self.slots - 1
    }

    fn formula(&mut self, path: &str, text: &FormulaText) -> Result<Formula, Refusal> {
        let text = text.0.as_str();
        let compiled = self.compile(text, false);
        compiled.map_err(|error| {
            let names = self.names();
            Refusal::at(path, error.with_hint(text, names.iter().map(String::as_str)).within(text))
        })
    }

    fn compile(&mut self, text: &str, of_neighbours: bool) -> Result<Formula, FormulaError> {
        let expression = Expression::parse_with(text, &mut Reader { compiler: self, of_neighbours })?;
        expression.compile(|name| self.name(name, of_neighbours))
    }

    /// What a name without more stands for, if it is no signal.
    fn name(&self, name: &str, of_neighbours: bool) -> Option<Operand> {
        let agent = &self.context.agents[self.agent];
        if let Some((_, slot)) = self.named.iter().rev().find(|(known, _)| known == name) {
            return Some(Operand::Slot(*slot));
        }
        match name {
            "t" => Some(Operand::Slot(0)),
            "dt" => Some(Operand::Constant(self.context.timing.dt)),
            "b_i" => Some(Operand::Slot(REFERENCE_WEIGHT)),
            "a_ij" if of_neighbours => Some(Operand::Slot(LINK[0])),
            "j" if of_neighbours => Some(Operand::Slot(LINK[1])),
            _ => self.constant(agent, name).map(Operand::Constant),
        }
    }

    fn constant(&self, agent: &Agent, name: &str) -> Option<f64> {
        // What a controller knows of the vehicle.
        agent.nominal.parameter(name).or_else(|| self.context.constant(agent, name))
    }

    /// All names that a formula may use, for hints.
    fn names(&self) -> Vec<String> {
        let model = self.context.agents[self.agent].vehicle.model();
        let states = model.iter().flat_map(|model| model.states.iter().map(|state| state.name.clone()));
        let parameters = model.iter().flat_map(|model| model.parameters.iter().map(|(name, _)| name.clone()));
        let named = self.named.iter().map(|(name, _)| name.clone());
        let scenario = self.context.parameters.keys().cloned();
        let fixed = ["t", "dt", "i", "N", "b_i", "a_ij", "state", "reference", "estimate", "command", "sum", "pi"];
        states.chain(parameters).chain(named).chain(scenario).chain(fixed.map(String::from)).collect()
    }

    /// The slot of a signal of the own agent.
    fn own(&mut self, reading: Reading) -> Result<usize, Refusal> {
        if let Some((.., slot)) = self.own.iter().find(|(known, ..)| *known == reading) {
            return Ok(*slot);
        }
        let slice = reading.bind(self.agent, self.bind)?;
        let slot = self.slot();
        self.own.push((reading, slice, slot));
        Ok(slot)
    }

    /// The slot of a signal of the neighbour whose turn it is.
    fn of_neighbour(&mut self, reading: Reading) -> usize {
        if let Some((_, slot)) = self.of_neighbour.iter().find(|(known, _)| *known == reading) {
            return *slot;
        }
        let slot = self.slot();
        self.of_neighbour.push((reading, slot));
        slot
    }

    fn finish(
        self,
        row: AdjacencyRow,
        heard: &[usize],
        states: Vec<(usize, Formula)>,
        (results, texts): (Vec<Formula>, Vec<(String, String)>),
        initial: Vec<(usize, f64)>,
    ) -> Result<Program, Refusal> {
        let Self { context, agent, bind, slots, own, of_neighbour, parts, .. } = self;
        let by_distance = context.proximity.is_some();
        let mut position = |agent: usize| {
            let length = bind.length(Role::Plant, agent, "position").filter(|_| by_distance);
            length.map(|length| bind.slice(Role::Plant, agent, "position", length, Timing::SameStep)).transpose()
        };
        let own_position = position(agent)?;
        let mut positions = heard.iter().map(|&other| position(other)).collect::<Result<Vec<_>, _>>()?.into_iter();
        let neighbours = heard.iter().map(|&other| {
            let signals = of_neighbour.iter().map(|(reading, _)| Ok((reading.bind(other, bind)?, reading.element)));
            let id = context.agents[other].id;
            Ok(Neighbour {
                agent: other,
                id,
                signals: signals.collect::<Result<_, Refusal>>()?,
                position: positions.next().flatten(),
            })
        });
        let neighbours = neighbours.collect::<Result<_, Refusal>>()?;
        Ok(Program {
            slots,
            own: own.into_iter().map(|(reading, slice, slot)| (slice, reading.element, slot)).collect(),
            of_neighbour: of_neighbour.iter().map(|(_, slot)| *slot).collect(),
            neighbours,
            row,
            position: own_position,
            link: LINK,
            reference_weight: REFERENCE_WEIGHT,
            parts,
            states,
            results,
            texts,
            initial,
        })
    }
}

impl Reading {
    fn bind(&self, agent: usize, bind: &mut Bind) -> Result<Slice, Refusal> {
        let length = bind.length(self.role, agent, &self.name).unwrap_or(1);
        let slice = bind.slice(self.role, agent, &self.name, length, self.timing)?;
        let message = || {
            let name = &self.name;
            format!("`{name}` of the {} of agent {} has {length} numbers, counted from 0", self.role, agent + 1)
        };
        if self.element < length { Ok(slice) } else { Err(Refusal(message())) }
    }
}

/// Reads the operands of a law: signals and sums.
struct Reader<'a, 'b, 'c> {
    compiler: &'a mut Compiler<'b, 'c>,
    /// Inside of a sum.
    of_neighbours: bool,
}

impl Operands for Reader<'_, '_, '_> {
    fn read(&mut self, name: &str, start: usize, text: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        if name == "sum" && text.peek() == Some('(') {
            return self.sum(start, text).map(Some);
        }
        if self.compiler.name(name, self.of_neighbours).is_some() {
            return Ok(None);
        }
        let (stem, of_neighbour) = match name.strip_suffix("_j").filter(|_| self.of_neighbours) {
            Some(stem) => (stem, true),
            None => (name, false),
        };
        let source = SOURCES.iter().find(|(source, ..)| *source == stem).filter(|_| text.peek() == Some('.'));
        let Some(&(_, role, timing)) = source.or(Some(&SOURCES[0])) else { return Ok(None) };
        let signal = if source.is_some() {
            text.take('.');
            text.take_name().to_string()
        } else {
            stem.to_string()
        };
        let agent = if of_neighbour { self.compiler.example } else { self.compiler.agent };
        let Some(length) = self.compiler.bind.length(role, agent, &signal) else {
            // A mere name may be unknown for other reasons, which are said elsewhere.
            return match source {
                None => Ok(None),
                Some(_) => {
                    let offered = self.compiler.bind.signals_of(role, agent);
                    Err(FormulaError::new(
                        start,
                        format!("expected a signal of the {role}, {offered}, found '{signal}'"),
                    ))
                }
            };
        };
        let element = element(&signal, length, start, text)?;
        let reading = Reading { role, timing, name: signal, element };
        if of_neighbour {
            return Ok(Some(self.compiler.of_neighbour(reading)));
        }
        self.compiler.own(reading).map(Some).map_err(|refusal| FormulaError::new(start, refusal.to_string()))
    }

    fn curve(&mut self, call: &DataCall) -> Result<Arc<Curve>, DataError> {
        self.compiler.context.curves.curve(call)
    }
}

impl Reader<'_, '_, '_> {
    /// The sum over the neighbours that the text in parentheses describes.
    fn sum(&mut self, start: usize, text: &mut Cursor) -> Result<usize, FormulaError> {
        if self.of_neighbours {
            return Err(FormulaError::new(
                start,
                "expected no sum within a sum: neighbours of neighbours are not known",
            ));
        }
        text.take('(');
        let first = text.offset();
        let depth = Cell::new(1);
        let inner = text.take_while(|character| {
            depth.set(depth.get() + i32::from(character == '(') - i32::from(character == ')'));
            depth.get() > 0
        });
        if !text.take(')') {
            return Err(text.unexpected("')' to end the sum"));
        }
        let inner = inner.to_string();
        let compiled = self.compiler.compile(&inner, true);
        let formula = compiled.map_err(|error| FormulaError::new(first + error.offset, error.message))?;
        let slot = self.compiler.slot();
        self.compiler.parts.push((Part::Sum(formula), slot));
        Ok(slot)
    }
}

/// The index behind the name of a vector, from 0; a signal of one number needs none.
fn element(signal: &str, length: usize, start: usize, text: &mut Cursor) -> Result<usize, FormulaError> {
    if text.peek() != Some('[') {
        let message = format!("`{signal}` has {length} numbers: expected one of them, such as {signal}[0]");
        return if length == 1 { Ok(0) } else { Err(FormulaError::new(start, message)) };
    }
    text.take_index(length)
}
