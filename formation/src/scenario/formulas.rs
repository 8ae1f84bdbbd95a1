//! Formulas of a scenario, compiled for each agent.

use std::cell::RefCell;

use crate::config::{Node, Problem, Problems, Table, around};
use crate::data::Library;
use crate::formula::{Expression, Formula, FormulaError, Operand};

/// A list of formulas and the names that they may use.
pub(super) struct Formulas<'a> {
    /// The whole scenario, for the places of problems.
    pub(super) root: &'a Node,
    /// Dotted path of the section that holds `define` and the lists.
    pub(super) section: &'a str,
    /// The data files that they may read, if any.
    pub(super) library: Option<&'a RefCell<Library>>,
    /// Names that vary during a run: slot k of an evaluation.
    pub(super) variables: Vec<(&'a str, usize)>,
}

impl Formulas<'_> {
    /// Compiles the list `field` of the section for one agent; `constant` gives the values of fixed names.
    pub(super) fn compile(
        &self,
        field: &str,
        length: usize,
        constant: &dyn Fn(&str) -> Option<f64>,
        problems: &mut Problems,
    ) -> Option<Vec<Formula>> {
        let path = format!("{}.{field}", self.section);
        let list = self.root.at(&path)?;
        let Some(nodes) = list.as_array() else {
            problems.at(self.root, &path, format!("expected a list of {length} formulas"));
            return None;
        };
        if nodes.len() != length {
            problems.at(self.root, &path, format!("expected {length} formulas, found {}", nodes.len()));
            return None;
        }
        let defined = self.definitions(constant, problems)?;
        let formulas = nodes
            .iter()
            .enumerate()
            .filter_map(|(index, node)| self.one(node, &format!("{path}.{}", index + 1), &defined, constant, problems));
        let formulas: Vec<Formula> = formulas.collect();
        (formulas.len() == length).then_some(formulas)
    }

    /// Reports the first of the compiled formulas of `field` whose value at the start of a run is not finite; `value` gives what
    /// is wrong with it, such as "its value is NaN". Whether all are finite.
    pub(super) fn check_start(
        &self,
        field: &str,
        agent: u32,
        formulas: &[Formula],
        constant: &dyn Fn(&str) -> Option<f64>,
        finding: &dyn Fn(&Formula) -> Option<String>,
        problems: &mut Problems,
    ) -> bool {
        let Some((index, found)) = formulas.iter().enumerate().find_map(|(k, formula)| Some((k, finding(formula)?)))
        else {
            return true;
        };
        let path = format!("{}.{field}.{}", self.section, index + 1);
        let Some(node) = self.root.at(&path) else { return true };
        let text = |node: &Node| around(node.as_str().unwrap_or_default(), 0);
        let message = format!("{found} at t = 0 for agent {agent}: \"{}\"", text(node));
        let mut problem = Problem::new(Some(node.origin.clone()), path, message);
        // A sub-formula may be to blame.
        let names = node.as_str().and_then(|text| self.parse(text).ok());
        let names: Vec<String> = names.iter().flat_map(Expression::names).map(str::to_string).collect();
        let defined = self.definitions(constant, &mut Problems::default()).unwrap_or_default();
        let to_blame = defined.iter().find(|(name, formula)| names.contains(name) && finding(formula).is_some());
        if let Some((name, _)) = to_blame {
            let path = format!("{}.define.{name}", self.section);
            let text = self.root.at(&path).map(text).unwrap_or_default();
            problem = problem.with_help(format!("because of {path}, \"{text}\""));
        }
        problems.push(problem);
        false
    }

    fn parse(&self, text: &str) -> Result<Expression, FormulaError> {
        match self.library {
            Some(library) => Expression::parse_with(text, &mut *library.borrow_mut()),
            None => Expression::parse(text),
        }
    }

    fn definitions(
        &self,
        constant: &dyn Fn(&str) -> Option<f64>,
        problems: &mut Problems,
    ) -> Option<Vec<(String, Formula)>> {
        let path = format!("{}.define", self.section);
        let mut defined = Vec::new();
        let Some(node) = self.root.at(&path) else { return Some(defined) };
        let Some(table) = node.as_table() else {
            problems.at(self.root, &path, "expected a table of named formulas");
            return None;
        };
        for (name, node) in table.iter() {
            if let Some(message) = order_problem(name, node, table) {
                problems.at(self.root, &format!("{path}.{name}"), message);
                return None;
            }
            let formula = self.one(node, &format!("{path}.{name}"), &defined, constant, problems)?;
            defined.push((name.to_string(), formula));
        }
        Some(defined)
    }

    /// Compiles one formula; `defined` are named parts of it.
    pub(super) fn one(
        &self,
        node: &Node,
        path: &str,
        defined: &[(String, Formula)],
        constant: &dyn Fn(&str) -> Option<f64>,
        problems: &mut Problems,
    ) -> Option<Formula> {
        let text = match (node.as_str(), node.as_f64()) {
            (Some(text), _) => text.to_string(),
            (None, Some(number)) => format!("{number:?}"),
            (None, None) => {
                problems.at(self.root, path, "expected a formula, such as \"0.3*sin(t)\"");
                return None;
            }
        };
        let compiled = self.parse(&text).and_then(|expression| {
            expression.compile(|name| {
                let slot = self.variables.iter().find(|(variable, _)| *variable == name);
                let inlined = || defined.iter().rev().find(|(known, _)| known == name);
                slot.map(|(_, slot)| Operand::Slot(*slot))
                    .or_else(|| inlined().map(|(_, formula)| Operand::Formula(formula.clone())))
                    .or_else(|| constant(name).map(Operand::Constant))
            })
        });
        match compiled {
            Ok(formula) => Some(formula),
            Err(error) => {
                let variables = self.variables.iter().map(|(name, _)| *name);
                let names =
                    variables.chain(defined.iter().map(|(name, _)| name.as_str())).chain(["i", "N", "pi", "seed"]);
                let message = error.with_hint(&text, names).within(&text);
                problems.push(Problem::new(Some(node.origin.clone()), path, message));
                None
            }
        }
    }
}

/// What is wrong with the order of a definition: it uses itself, or one that stands below it.
pub(crate) fn order_problem(name: &str, node: &Node, table: &Table) -> Option<String> {
    let expression = Expression::parse(node.as_str()?).ok()?;
    let used = expression.names();
    if used.contains(&name) {
        return Some(format!("`{name}` depends on itself"));
    }
    let mut below = table.iter().map(|(known, _)| known).skip_while(|known| *known != name);
    let later = below.find(|known| used.contains(known))?;
    Some(format!("uses `{later}`, which is defined below it: a definition may use those above it"))
}
