//! `[vehicle]` with equations as it is written: names, units and limits, before the formulas are compiled for an agent.

use super::section::{EquationsSection, InputTable, StateTable};
use crate::config::{Node, PerAgent, Problems, Sort, Table, did_you_mean, is_signal_name, read};
use crate::formula::{Expression, FORMULA_NAMES};
use crate::vehicle::Variable;

/// Names that rows of agents and conditions use for something else.
const OF_ROWS: [&str; 6] = ["id", "vehicle", "with", "and", "or", "not"];

/// Most bytes of the name of a signal.
pub(super) const LONGEST_NAME: usize = 64;

/// Most numbers of the position of an agent.
const MOST_COORDINATES: usize = 3;

/// What a section says, as far as all agents have it in common.
#[derive(Debug)]
pub(super) struct Description {
    /// Dotted path of the section.
    pub(super) path: String,
    /// What messages call the vehicle.
    pub(super) kind: String,
    pub(super) states: Vec<StateEntry>,
    pub(super) inputs: Vec<InputEntry>,
    pub(super) parameters: Vec<(String, PerAgent)>,
    /// Which states are angles.
    pub(super) angles: Vec<bool>,
}

#[derive(Debug)]
pub(super) struct StateEntry {
    pub(super) variable: Variable,
    pub(super) initial: Option<f64>,
}

#[derive(Debug)]
pub(super) struct InputEntry {
    pub(super) variable: Variable,
    /// Least and greatest value.
    pub(super) limits: (f64, f64),
}

impl Description {
    /// Reads the section at `path`; what is wrong goes to `problems`. The formulas are not compiled.
    pub(super) fn read(root: &Node, path: &str, problems: &mut Problems) -> Option<Self> {
        let node = root.at(path)?;
        let before = problems.len();
        let section = read::<EquationsSection>(node, path, problems)?;
        let mut names = Names { root, problems, known: Vec::new() };
        let states = names.states(&format!("{path}.states"));
        let inputs = names.inputs(&format!("{path}.inputs"));
        let parameters = names.parameters(&format!("{path}.parameters"));
        names.keys(&format!("{path}.define"));
        let is_state = |name: &str| states.iter().any(|state| state.variable.name == name);
        let state_names = || states.iter().map(|state| state.variable.name.as_str());
        for (place, name) in section.angles.iter().enumerate().filter(|(_, name)| !is_state(name)) {
            let hint = did_you_mean(name, state_names());
            let path = format!("{path}.angles.{}", place + 1);
            problems.at(root, &path, format!("no state is called `{name}`{hint}"));
        }
        check_rates(root, path, &state_names().collect::<Vec<_>>(), problems);
        for field in ["position", "velocity"] {
            check_coordinates(root, &format!("{path}.{field}"), problems);
        }
        let angles = state_names().map(|name| section.angles.iter().any(|angle| angle == name)).collect();
        let kind = section.name.unwrap_or(section.kind);
        let description = Self { path: path.into(), kind, angles, states, inputs, parameters };
        (problems.len() == before).then_some(description)
    }

    /// The numbers of the states that `field` (`position` or `velocity`) consists of, if it consists of states.
    pub(super) fn plain(&self, root: &Node, field: &str) -> Option<Vec<usize>> {
        let elements = root.at(&format!("{}.{field}", self.path))?.as_array()?;
        elements.iter().map(|node| self.state(node.as_str()?.trim())).collect()
    }

    /// The number of the state of this name.
    pub(super) fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|state| state.variable.name == name)
    }
}

/// Reads what has names, all of which must differ.
struct Names<'a> {
    root: &'a Node,
    problems: &'a mut Problems,
    known: Vec<String>,
}

impl Names<'_> {
    fn states(&mut self, path: &str) -> Vec<StateEntry> {
        let Some(table) = self.table(path) else {
            let message = "missing: the states with their units, such as states = { x = \"m\", v = \"m/s\" }";
            self.problems.at(self.root, path, message).sort = Sort::Missing;
            return Vec::new();
        };
        if table.is_empty() {
            self.problems.at(self.root, path, "expected at least one state, such as x = \"m\"");
        }
        let mut states = Vec::new();
        for (name, node) in table.iter() {
            let path = format!("{path}.{name}");
            self.signal(name, &path);
            let Some(StateTable { unit, initial }) = self.entry(node, &path, |unit| StateTable { unit, initial: None })
            else {
                continue;
            };
            if initial.is_some_and(|value| !value.is_finite()) {
                self.problems.at(self.root, &format!("{path}.initial"), "expected a finite number");
            }
            states.push(StateEntry { variable: Variable { name: name.into(), unit }, initial });
        }
        states
    }

    fn inputs(&mut self, path: &str) -> Vec<InputEntry> {
        let mut inputs = Vec::new();
        for (name, node) in self.table(path).iter().flat_map(Table::iter) {
            let path = format!("{path}.{name}");
            self.name(name, &path);
            let table = |unit| InputTable { unit, low: None, high: None };
            let Some(InputTable { unit, low, high }) = self.entry(node, &path, table) else { continue };
            let limits = (low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY));
            let is_range = limits.0 < limits.1;
            if !is_range {
                let message = format!("expected low < high, found {} and {}", limits.0, limits.1);
                self.problems.at(self.root, &path, message);
            }
            inputs.push(InputEntry { variable: Variable { name: name.into(), unit }, limits });
        }
        inputs
    }

    fn parameters(&mut self, path: &str) -> Vec<(String, PerAgent)> {
        let mut parameters = Vec::new();
        for (name, node) in self.table(path).iter().flat_map(Table::iter) {
            let path = format!("{path}.{name}");
            self.name(name, &path);
            if let Some(value) = read::<PerAgent>(node, &path, self.problems) {
                parameters.push((name.to_string(), value));
            }
        }
        parameters
    }

    fn keys(&mut self, path: &str) {
        for (name, _) in self.table(path).iter().flat_map(Table::iter) {
            self.name(name, &format!("{path}.{name}"));
        }
    }

    /// The table at `path`, if there is one; anything else is reported.
    fn table(&mut self, path: &str) -> Option<Table> {
        let node = self.root.at(path)?;
        if node.as_table().is_none() {
            self.problems.at(self.root, path, format!("expected a table of names, found {}", node.describe()));
        }
        Some(node.as_table().cloned().unwrap_or_default())
    }

    /// An entry that is its unit only, or a table.
    fn entry<T: serde::de::DeserializeOwned>(
        &mut self,
        node: &Node,
        path: &str,
        plain: impl Fn(String) -> T,
    ) -> Option<T> {
        match (node.as_str(), node.as_table()) {
            (Some(unit), _) => Some(plain(unit.into())),
            (None, Some(_)) => read::<T>(node, path, self.problems),
            (None, None) => {
                let message = format!("expected a unit such as \"m\", or a table with it, found {}", node.describe());
                self.problems.at(self.root, path, message);
                None
            }
        }
    }

    /// A name that becomes one of a signal, too.
    fn signal(&mut self, name: &str, path: &str) {
        self.name(name, path);
        if !is_signal_name(name) || name.len() > LONGEST_NAME {
            let message = "expected lower-case letters, digits and single `_` inside, beginning with a letter: a state is a signal, too";
            self.problems.at(self.root, path, message);
        }
    }

    fn name(&mut self, name: &str, path: &str) {
        let is_name = Expression::parse(name).is_ok_and(|expression| expression.names() == [name]);
        let is_word = name.starts_with(char::is_alphabetic) && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if FORMULA_NAMES.contains(&name) || OF_ROWS.contains(&name) || (is_word && !is_name) {
            let message = format!("`{name}` stands for something else in formulas: expected another name");
            self.problems.at(self.root, path, message);
        } else if !is_name {
            self.problems.at(self.root, path, "expected a name of letters, digits and `_` that begins with a letter");
        } else if name.ends_with("_j") {
            let message = "expected another end than `_j`, which means the signal of a neighbour in laws";
            self.problems.at(self.root, path, message);
        } else if self.known.iter().any(|known| known == name) {
            self.problems.at(self.root, path, format!("`{name}` stands for something else in this vehicle already"));
        }
        self.known.push(name.into());
    }
}

/// Every state needs a time derivative, and nothing else has one.
fn check_rates(root: &Node, path: &str, states: &[&str], problems: &mut Problems) {
    let path = format!("{path}.d");
    let table = root.at(&path).and_then(Node::as_table);
    if let Some(name) = states.iter().find(|name| table.is_none_or(|table| table.get(name).is_none())) {
        let message = format!("missing: the time derivative of the state `{name}`, such as d.{name} = \"-{name}\"");
        problems.at(root, &format!("{path}.{name}"), message).sort = Sort::Missing;
    }
    for (name, _) in table.iter().flat_map(|table| table.iter()).filter(|(name, _)| !states.contains(name)) {
        let hint = did_you_mean(name, states.iter().copied());
        let message = format!("no state is called `{name}`, expected one of {}{hint}", states.join(", "));
        problems.at(root, &format!("{path}.{name}"), message).sort = Sort::Unknown;
    }
}

fn check_coordinates(root: &Node, path: &str, problems: &mut Problems) {
    let Some(node) = root.at(path) else { return };
    if !node.as_array().is_some_and(|elements| (1..=MOST_COORDINATES).contains(&elements.len())) {
        let message = format!("expected a list of 1 to {MOST_COORDINATES} formulas, found {}", node.describe());
        problems.at(root, path, message);
    }
}
