//! Parameters for programs: `[controller.with]` and its siblings, and `with` of an agent. They are free; what they mean is up to
//! the program.

use schemars::{Schema, SchemaGenerator, json_schema};

use super::{LookupError, Scenario};
use crate::config::{Node, Problems, Value, did_you_mean, nearest};
use crate::role::Role;

/// The key of the table.
pub(super) const WITH: &str = "with";

/// Reports what cannot be handed to a program: names that cannot be part of a dotted name, numbers that are not finite.
pub(super) fn check_with(root: &Node, problems: &mut Problems) {
    for role in Role::ALL {
        check_table(root, &format!("{role}.{WITH}"), problems);
    }
    let agents = root.at("agents").and_then(Node::as_array).map_or(0, <[Node]>::len);
    (1..=agents).for_each(|agent| check_table(root, &format!("agents.{agent}.{WITH}"), problems));
    let of_role = |role: Role| root.at(&format!("{role}.{WITH}")).and_then(Node::as_table);
    let known: Vec<&str> =
        Role::ALL.into_iter().filter_map(of_role).flat_map(|table| table.iter()).map(|(name, _)| name).collect();
    for agent in 1..=agents {
        let path = format!("agents.{agent}.{WITH}");
        for (name, _) in root.at(&path).and_then(Node::as_table).into_iter().flat_map(|table| table.iter()) {
            // A program may have parameters that only agents give, but not one that is nearly another.
            let hint = did_you_mean(name, known.iter().copied());
            if !known.contains(&name) && !hint.is_empty() {
                problems.at(root, &format!("{path}.{name}"), format!("no section has a parameter of this name{hint}"));
            }
        }
    }
}

fn check_table(root: &Node, path: &str, problems: &mut Problems) {
    let Some(node) = root.at(path) else { return };
    match node.as_table() {
        Some(_) => check(root, path, node, problems),
        None => {
            let message =
                format!("expected a table such as {{ gain = 2, model = \"x.xml\" }}, found {}", node.describe());
            problems.at(root, path, message);
        }
    }
}

fn check(root: &Node, path: &str, node: &Node, problems: &mut Problems) {
    match &node.value {
        Value::Float(value) if !value.is_finite() => {
            problems.at(root, path, format!("expected a finite number, found {value}"));
        }
        Value::Array(elements) => {
            for (number, element) in (1..).zip(elements) {
                check(root, &format!("{path}.{number}"), element, problems);
            }
        }
        Value::Table(table) => {
            for (name, node) in table.iter() {
                let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
                if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() || !name.chars().all(is_plain) {
                    let message =
                        format!("{name:?}: expected a name of letters, digits and `_` that starts with no digit");
                    problems.at(root, path, message);
                } else {
                    check(root, &format!("{path}.{name}"), node, problems);
                }
            }
        }
        _ => {}
    }
}

impl Scenario {
    /// The dotted name of the parameter `name` of a program that plays `role`: that of its agent (from 0) if it has one, else that
    /// of the section. [`Scenario::number`], [`Scenario::text`] and [`Scenario::length`] read it.
    ///
    /// # Errors
    /// [`LookupError`] if there is no such parameter.
    pub fn parameter(&self, role: Role, agent: Option<usize>, name: &str) -> Result<String, LookupError> {
        let of_agent = agent.map(|agent| format!("agents.{}.{WITH}.{name}", agent + 1));
        let of_role = format!("{role}.{WITH}.{name}");
        let known = |path: &String| !name.is_empty() && self.section(path).is_some();
        if let Some(path) = of_agent.into_iter().chain([of_role.clone()]).find(known) {
            return Ok(path);
        }
        let section = self.section(&format!("{role}.{WITH}")).and_then(Node::as_table);
        let names = section.into_iter().flat_map(|table| table.iter().map(|(name, _)| name));
        let near = nearest(name, names).map(|near| format!("{role}.{WITH}.{near}"));
        Err(LookupError::Missing { kind: "parameter", name: of_role, near })
    }
}

/// The table for an editor.
pub(super) fn schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "object" })
}

#[cfg(test)]
mod tests {
    use crate::role::Role;
    use crate::scenario::{Scenario, Selection};

    const TEXT: &str = r#"
name = "two"
agents = [{ position = [0, 0, 0], with = { gain = 5 } }, { position = [2, 0, 0] }]
[timing]
dt = 0.1
duration = 1
[vehicle]
kind = "integrator"
[topology]
b = 1
[reference]
position = [0, 0, 0]
[plant]
kind = "vehicles"
[planner]
kind = "reference"
[controller]
kind = "external"
with = { gain = "pi/2", model = "x.xml", levels = [1, 2], on = true, limits = { max = 3 } }
"#;

    fn load(text: &str, overrides: &[&str]) -> Result<Scenario, String> {
        let overrides = overrides.iter().map(|text| text.to_string()).collect();
        let loaded = Scenario::load("two.toml", text, &Selection { overrides, ..Selection::default() });
        loaded.map_err(|problems| problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    }

    #[test]
    fn an_agent_overrides_the_section() {
        let scenario = load(TEXT, &[]).unwrap();
        let number = |agent, name: &str| {
            let path = scenario.parameter(Role::Controller, agent, name)?;
            scenario.number(&path)
        };
        assert_eq!(number(Some(0), "gain"), Ok(5.0));
        assert_eq!(number(Some(1), "gain"), Ok(std::f64::consts::FRAC_PI_2));
        assert_eq!(number(None, "gain"), Ok(std::f64::consts::FRAC_PI_2));
        assert_eq!(
            (number(None, "on"), number(None, "limits.max"), number(None, "levels.2")),
            (Ok(1.0), Ok(3.0), Ok(2.0))
        );
        assert_eq!(scenario.text("controller.with.model"), Ok("x.xml"));
        let missing = number(Some(1), "gein").unwrap_err().to_string();
        assert_eq!(
            missing,
            "the scenario has no parameter called `controller.with.gein`; did you mean `controller.with.gain`?"
        );
        assert!(scenario.parameter(Role::Plant, None, "gain").is_err());
    }

    #[test]
    fn the_command_line_sets_parameters() {
        let scenario =
            load(TEXT, &["controller.with.gain=3", "plant.with.model=\"y.xml\"", "agents.2.with.gain=7"]).unwrap();
        assert_eq!(scenario.number("controller.with.gain"), Ok(3.0));
        assert_eq!(scenario.text("plant.with.model"), Ok("y.xml"));
        assert_eq!(scenario.parameter(Role::Controller, Some(1), "gain").unwrap(), "agents.2.with.gain");
    }

    #[test]
    fn mistakes_have_their_place() {
        for (from, to, place, expected) in [
            ("gain = \"pi/2\"", "gain = nan", "controller.with.gain", "a finite number"),
            ("levels = [1, 2]", "levels = [1, inf]", "controller.with.levels.2", "a finite number"),
            ("gain = \"pi/2\"", "\"a gain\" = 1", "controller.with", "\"a gain\": expected a name"),
            ("with = { gain = 5 }", "with = 5", "agents.1.with", "expected a table such as"),
        ] {
            let message = load(&TEXT.replacen(from, to, 1), &[]).unwrap_err();
            assert!(message.contains(&format!("{place}:")) && message.contains(expected), "{to}: {message}");
        }
    }

    #[test]
    fn a_text_among_the_parameters_leaves_the_others_known() {
        let text = TEXT.replace(
            "[reference]\nposition = [0, 0, 0]",
            "[parameters]\nphase = 1\n[reference]\nposition = [\"phase\", 0, 0]",
        );
        let message = load(&text, &["parameters.model=\"x.xml\""]).unwrap_err();
        assert!(message.contains("parameters.model: expected a number, found the string \"x.xml\""), "{message}");
        assert!(message.contains("`[controller.with]`"), "{message}");
        assert!(!message.contains("phase") && !message.contains("0.5"), "{message}");
    }
}
