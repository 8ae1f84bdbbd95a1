//! From the description of a vehicle to the model of an agent: its parameters are in place, its formulas are compiled.

use std::cell::RefCell;
use std::collections::BTreeMap;

use lockstep::{Field, MAX_WORDS};

use super::description::{Description, LONGEST_NAME};
use crate::config::{Node, Problem, Problems, around, did_you_mean, is_signal_name};
use crate::data::Library;
use crate::formula::Formula;
use crate::scenario::formulas::{Formulas, order_problem};
use crate::vehicle::{Model, ModelOutput, units};

/// Fields of the row of an agent that are no states or parameters.
const ROW_FIELDS: &[&str] = &["id", "vehicle", "position", "with"];

/// What the formulas of a vehicle may use of the scenario.
#[derive(Clone, Copy)]
pub(in crate::scenario) struct Surroundings<'a> {
    /// The whole scenario.
    pub(in crate::scenario) root: &'a Node,
    /// Its named numbers.
    pub(in crate::scenario) parameters: &'a BTreeMap<String, f64>,
    /// Its seed.
    pub(in crate::scenario) seed: u64,
    /// Its data files.
    pub(in crate::scenario) library: &'a RefCell<Library>,
}

/// An agent as its row gives it.
pub(super) struct Row<'a> {
    /// Its row.
    pub(super) node: &'a Node,
    /// The dotted path of the row.
    pub(super) path: String,
    /// Its place among the agents, from 0, how many there are, and the `i` of formulas.
    pub(super) place: usize,
    pub(super) count: usize,
    pub(super) id: u32,
}

impl Description {
    /// The model of an agent. What is wrong goes to `problems`.
    pub(super) fn model(&self, around: Surroundings, row: &Row, problems: &mut Problems) -> Option<Model> {
        let Surroundings { root, parameters: constants, seed, library } = around;
        let before = problems.len();
        self.check_row(root, row, problems);
        let parameters = self.parameters(root, row, problems);
        let initial = self.initial(root, row, problems);
        if problems.len() > before {
            return None;
        }
        let known = |name: &str| match name {
            "i" => Some(f64::from(row.id)),
            "N" => Some(row.count as f64),
            _ => parameters
                .iter()
                .find(|(own, _)| own == name)
                .map(|(_, value)| *value)
                .or_else(|| constants.get(name).copied())
                .or_else(|| (name == "seed").then_some(seed as f64)),
        };
        let states = self.states.iter().map(|state| state.variable.clone()).collect::<Vec<_>>();
        let inputs = self.inputs.iter().map(|input| input.variable.clone()).collect::<Vec<_>>();
        let names = states.iter().chain(&inputs).map(|variable| variable.name.as_str());
        let variables = std::iter::once("t").chain(names).zip(0..).collect();
        let mut compiler = Compiler {
            formulas: Formulas { root, section: &self.path, library: Some(library), variables },
            constant: &known,
            problems,
            texts: Vec::new(),
        };
        let definitions = compiler.definitions()?;
        let rates =
            states.iter().map(|state| compiler.one(&format!("d.{}", state.name))).collect::<Option<Vec<_>>>()?;
        let position = compiler.list("position")?;
        let plain = self.plain(root, "position");
        let mut velocity = compiler.list("velocity")?;
        if velocity.is_empty()
            && let Some(coordinates) = &plain
        {
            velocity = coordinates.iter().map(|&state| rates[state].clone()).collect();
        }
        let outputs = compiler.outputs()?;
        let texts = compiler.texts;
        let leading = self.plain(root, "velocity").unwrap_or_default();
        let model = Model {
            kind: self.kind.clone(),
            limits: self.inputs.iter().map(|input| input.limits).collect(),
            units: self.units(plain.as_deref(), &leading),
            position_states: plain.clone().unwrap_or_default(),
            position_angles: plain.iter().flatten().map(|&state| self.angles[state]).collect(),
            leading: (0..states.len()).map(|state| leading.contains(&state)).collect(),
            angles: self.angles.clone(),
            parameters,
            initial,
            states,
            inputs,
            definitions,
            rates,
            position,
            velocity,
            outputs,
        };
        self.check(root, row, &model, &texts, problems).then_some(model)
    }

    /// Units of position and velocity: those of their states. Other formulas have none, as nobody can tell.
    fn units(&self, position: Option<&[usize]>, velocity: &[usize]) -> [String; 2] {
        let unit = |&state: &usize| self.states[state].variable.unit.as_str();
        let position_unit = units(position.unwrap_or_default().iter().map(unit));
        let velocity_unit = match position {
            _ if !velocity.is_empty() => units(velocity.iter().map(unit)),
            Some(_) if !position_unit.is_empty() && !position_unit.contains(',') => format!("{position_unit}/s"),
            _ => String::new(),
        };
        [position_unit, velocity_unit]
    }

    fn check_row(&self, root: &Node, row: &Row, problems: &mut Problems) {
        let known = || {
            let states = self.states.iter().map(|state| state.variable.name.as_str());
            let parameters = self.parameters.iter().map(|(name, _)| name.as_str());
            states.chain(parameters).chain(ROW_FIELDS.iter().copied())
        };
        for (name, _) in row.node.as_table().into_iter().flat_map(|table| table.iter()) {
            if !known().any(|field| field == name) {
                let list = known().collect::<Vec<_>>().join(", ");
                let hint = did_you_mean(name, known());
                let message = format!("unknown field of the vehicle `{}`, expected one of {list}{hint}", self.kind);
                problems.at(root, &format!("{}.{name}", row.path), message).sort = crate::config::Sort::Unknown;
            }
        }
    }

    fn parameters(&self, root: &Node, row: &Row, problems: &mut Problems) -> Vec<(String, f64)> {
        let mut parameters = Vec::new();
        for (name, rule) in &self.parameters {
            let value = match row.node.at(name) {
                Some(_) => number(root, &format!("{}.{name}", row.path), problems),
                None => match rule.value(row.count, row.place, row.id) {
                    Ok(value) if value.is_finite() => Some(value),
                    Ok(value) => {
                        let message = format!("expected a finite number, found {value}");
                        problems.at(root, &format!("{}.parameters.{name}", self.path), message);
                        None
                    }
                    Err(message) => {
                        problems.at(root, &format!("{}.parameters.{name}", self.path), message);
                        None
                    }
                },
            };
            parameters.extend(value.map(|value| (name.clone(), value)));
        }
        parameters
    }

    /// The states at t = 0: of the row by name or as `position`, or of the section.
    fn initial(&self, root: &Node, row: &Row, problems: &mut Problems) -> Vec<f64> {
        let mut position = vec![None; self.states.len()];
        if let Some(node) = row.node.at("position") {
            let path = format!("{}.position", row.path);
            match (self.plain(root, "position"), node.as_array()) {
                (None, _) => {
                    let message =
                        "the position of this vehicle does not consist of states: name initial states instead";
                    problems.at(root, &path, message);
                }
                (Some(states), Some(values)) if values.len() == states.len() => {
                    for (place, state) in states.into_iter().enumerate() {
                        position[state] = number(root, &format!("{path}.{}", place + 1), problems);
                    }
                }
                (Some(states), _) => {
                    let message = format!("expected a list of {} values, found {}", states.len(), node.describe());
                    problems.at(root, &path, message);
                }
            }
        }
        let mut initial = Vec::new();
        for (state, placed) in self.states.iter().zip(position) {
            let name = &state.variable.name;
            let path = format!("{}.{name}", row.path);
            let given = row.node.at(name).map(|_| number(root, &path, problems).unwrap_or(0.0));
            if given.is_some() && placed.is_some() {
                problems.at(root, &path, "`position` gives this state, too: expected one of both");
            }
            match given.or(placed).or(state.initial) {
                Some(value) => initial.push(value),
                None => {
                    let message =
                        format!("missing: the state `{name}` at t = 0, here or as {}.states.{name}.initial", self.path);
                    problems.at(root, &path, message).sort = crate::config::Sort::Missing;
                }
            }
        }
        initial
    }

    /// Whether all formulas are finite at t = 0, and the sample is not too large. The first that is wrong is reported.
    fn check(
        &self,
        root: &Node,
        row: &Row,
        model: &Model,
        texts: &[(String, Formula)],
        problems: &mut Problems,
    ) -> bool {
        let words = model.fields().iter().map(|field| field.shape.words()).sum::<usize>().max(model.inputs.len());
        if words > MAX_WORDS {
            let message = format!("expected at most {MAX_WORDS} numbers in a sample, found {words}");
            problems.at(root, &self.path, message);
            return false;
        }
        let slots = model.start();
        let Some((path, value)) = texts.iter().find_map(|(path, formula)| {
            let value = formula.evaluate(&slots);
            (!value.is_finite()).then_some((path, value))
        }) else {
            return true;
        };
        let Some(node) = root.at(path) else { return true };
        let text = around(node.as_str().unwrap_or_default(), 0);
        let message = format!("its value is {value} at t = 0 for agent {}: \"{text}\"", row.place + 1);
        problems.push(Problem::new(Some(node.origin.clone()), path, message));
        false
    }
}

/// Compiles the formulas of one section.
struct Compiler<'a> {
    formulas: Formulas<'a>,
    constant: &'a dyn Fn(&str) -> Option<f64>,
    problems: &'a mut Problems,
    /// Every formula with its path.
    texts: Vec<(String, Formula)>,
}

impl<'a> Compiler<'a> {
    fn node(&self, path: &str) -> Option<&'a Node> {
        self.formulas.root.at(path)
    }

    /// The named parts, which become slots in their order.
    fn definitions(&mut self) -> Option<Vec<Formula>> {
        let path = format!("{}.define", self.formulas.section);
        let mut definitions = Vec::new();
        let table = self.node(&path).and_then(Node::as_table);
        for (name, node) in table.into_iter().flat_map(|table| table.iter()) {
            if let Some(message) = table.and_then(|table| order_problem(name, node, table)) {
                self.problems.at(self.formulas.root, &format!("{path}.{name}"), message);
                return None;
            }
            definitions.push(self.one(&format!("define.{name}"))?);
            let slot = self.formulas.variables.len();
            self.formulas.variables.push((name, slot));
        }
        Some(definitions)
    }

    /// The formula at a path below the section.
    fn one(&mut self, field: &str) -> Option<Formula> {
        let path = format!("{}.{field}", self.formulas.section);
        let node = self.node(&path)?;
        let formula = self.formulas.one(node, &path, &[], self.constant, self.problems)?;
        self.texts.push((path, formula.clone()));
        Some(formula)
    }

    /// The list of formulas at a path below the section; empty if there is none.
    fn list(&mut self, field: &str) -> Option<Vec<Formula>> {
        let length =
            self.node(&format!("{}.{field}", self.formulas.section)).and_then(Node::as_array).map_or(0, <[_]>::len);
        (1..=length).map(|place| self.one(&format!("{field}.{place}"))).collect()
    }

    fn outputs(&mut self) -> Option<Vec<ModelOutput>> {
        let path = format!("{}.outputs", self.formulas.section);
        let Some(node) = self.node(&path) else { return Some(Vec::new()) };
        let Some(table) = node.as_table() else {
            let message = format!("expected a table of signals, found {}", node.describe());
            self.problems.at(self.formulas.root, &path, message);
            return None;
        };
        table.iter().map(|(name, node)| self.output(name, node)).collect()
    }

    fn output(&mut self, name: &str, node: &Node) -> Option<ModelOutput> {
        let path = format!("{}.outputs.{name}", self.formulas.section);
        let taken =
            ["position", "velocity"].contains(&name) || self.formulas.variables.iter().any(|(known, _)| *known == name);
        if !is_signal_name(name) || name.len() > LONGEST_NAME || taken {
            let message = if taken {
                format!("`{name}` stands for something else in this vehicle already")
            } else {
                "expected lower-case letters, digits and single `_` inside, beginning with a letter".into()
            };
            self.problems.at(self.formulas.root, &path, message);
            return None;
        }
        let unit = node.at("unit").map_or(Some(""), Node::as_str);
        let fields = node.as_table().into_iter().flat_map(|table| table.iter());
        let wrong = fields.map(|(field, _)| field).find(|field| !["value", "unit"].contains(field));
        let (field, value) = match node.as_table() {
            Some(_) => (format!("outputs.{name}.value"), node.at("value")),
            None => (format!("outputs.{name}"), Some(node)),
        };
        let (Some(unit), Some(value), None) = (unit, value, wrong) else {
            let message = "expected a formula, a list of formulas, or a table with `value` and `unit`";
            self.problems.at(self.formulas.root, &path, message);
            return None;
        };
        if value.as_array().is_some_and(<[Node]>::is_empty) {
            self.problems.at(self.formulas.root, &path, "expected at least one formula in the list, found none");
            return None;
        }
        let (shape, formulas) = match value.as_array() {
            Some(values) => (Field::vector(name, values.len(), unit), self.list(&field)?),
            None => (Field::scalar(name, unit), vec![self.one(&field)?]),
        };
        Some(ModelOutput { field: shape, formulas })
    }
}

/// The number at `path`, which may be a formula of numbers; what is wrong is reported.
fn number(root: &Node, path: &str, problems: &mut Problems) -> Option<f64> {
    let value = crate::config::read::<f64>(root.at(path)?, path, problems)?;
    if !value.is_finite() {
        problems.at(root, path, format!("expected a finite number, found {value}"));
        return None;
    }
    Some(value)
}
