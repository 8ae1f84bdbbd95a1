//! Values of a scenario by dotted name, as they are in force: defaults filled in, formulas of constants evaluated.

use super::{Agent, AgentNumber, Graph, Scenario};
use crate::config::{Node, Value, nearest};
use crate::formula::{Expression, Operand};
use crate::role::Role;
use crate::text::suggestion;

/// Why a scenario does not have a value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LookupError {
    /// There is no value of this name.
    #[error("the scenario has no {kind} called `{name}`{}", suggestion(near.as_deref()))]
    Missing {
        /// What was asked for: number, text or list.
        kind: &'static str,
        /// Its name.
        name: String,
        /// A name that there is.
        near: Option<String>,
    },
    /// The value is something else.
    #[error("`{name}` of the scenario is not {expected}, but {found}")]
    OtherKind {
        /// Its name.
        name: String,
        /// What was asked for, with its article.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// The value is not one number: it is a formula of the agent, or of the time.
    #[error("`{name}` of the scenario is {text:?}, which depends on `{variable}`{}", if variable == "i" { format!("; `{name}.K` is that of agent K") } else { String::new() })]
    Varies {
        /// Its name.
        name: String,
        /// The formula.
        text: String,
        /// What it depends on.
        variable: String,
    },
}

impl Scenario {
    /// The communication graph at the start of the run.
    pub fn graph(&self) -> Graph {
        Graph::new(self.context.topology.first(), self.context.proximity.as_ref())
    }

    /// The communication graphs of the run, each with the step from which on it holds, in order.
    pub fn graphs(&self) -> Vec<(u64, Graph)> {
        Graph::over_time(&self.context.topology, self.context.proximity.as_ref())
    }

    /// Whether there is a value of this name.
    pub fn has(&self, name: &str) -> bool {
        self.value(name).is_some() || self.number(name).is_ok()
    }

    /// The number called `name`, such as `controller.c_p` or `agents.2.position.1`; lists count from 1, a boolean is 1 or 0.
    ///
    /// It is the number that the run uses: a default if the file does not give it (`topology.A.1.3` of the default ring), the value
    /// of a formula of constants (`"pi/2"`), and `topology.b.2` also where one number, or a formula of `i`, stands for all agents.
    ///
    /// # Errors
    /// [`LookupError`] if there is no such number.
    pub fn number(&self, name: &str) -> Result<f64, LookupError> {
        if let Some(number) = self.in_force(name) {
            return Ok(number);
        }
        if let Some(node) = self.value(name) {
            return self.evaluate(name, node, None);
        }
        self.element(name).unwrap_or_else(|| Err(self.missing("number", name)))
    }

    /// The text called `name`.
    ///
    /// # Errors
    /// [`LookupError`] if there is no such text.
    pub fn text(&self, name: &str) -> Result<&str, LookupError> {
        let node = self.value(name).ok_or_else(|| self.missing("text", name))?;
        node.as_str().ok_or_else(|| other_kind(name, "a text", node))
    }

    /// The number of elements of the list called `name`. What is given by one number for all counts as the list that it stands for.
    ///
    /// # Errors
    /// [`LookupError`] if there is no such list.
    pub fn length(&self, name: &str) -> Result<usize, LookupError> {
        let agents = self.context.agents.len();
        let words: Vec<&str> = name.split('.').collect();
        match words[..] {
            ["topology", "A" | "b"] => return Ok(agents),
            ["topology", "A", row] if element(row).is_some_and(|row| row < agents) => return Ok(agents),
            ["agents", agent, field] => {
                let agent = element(agent).and_then(|agent| self.context.agents.get(agent));
                if let Some(values) = agent.and_then(|agent| coordinates(agent, field)) {
                    return Ok(values.len());
                }
            }
            _ => {}
        }
        let node = self.value(name).ok_or_else(|| self.missing("list", name))?;
        node.as_array().map(<[Node]>::len).ok_or_else(|| other_kind(name, "a list", node))
    }

    /// The value in the file, with variant and overrides.
    fn value(&self, name: &str) -> Option<&Node> {
        // The empty name would be the whole scenario.
        Some(name).filter(|name| !name.is_empty()).and_then(|name| self.section(name))
    }

    /// A number that the scenario has whether its file gives it or not.
    fn in_force(&self, name: &str) -> Option<f64> {
        let context = &self.context;
        let words: Vec<&str> = name.split('.').collect();
        let agent = |word: &str| element(word).filter(|&agent| agent < context.agents.len());
        match words[..] {
            ["seed"] => Some(context.seed as f64),
            ["timing", "dt"] => Some(context.timing.dt),
            ["timing", "duration"] => Some(context.timing.duration),
            ["topology", "any_graph"] => Some(truth(context.any_graph)),
            ["topology", "A", i, j] => Some(context.topology.first().a(agent(i)?, agent(j)?)),
            ["topology", "b", i] => Some(context.topology.first().b(agent(i)?)),
            ["agents", i, field] => parameter(&context.agents[agent(i)?], field),
            ["agents", i, field, j] => coordinates(&context.agents[agent(i)?], field)?.get(element(j)?).copied(),
            ["plant", "per_agent"] => Some(truth(self.plant_per_agent)),
            [role, field @ ("every" | "offset")] => {
                let role = Role::ALL.into_iter().find(|known| known.name() == role)?;
                let (every, offset) = self.component(role).map(|_| self.rate(role))?;
                Some(if field == "every" { every } else { offset } as f64)
            }
            _ => None,
        }
    }

    /// What one value for all agents is for one of them: `name` is that of the value with the number of the agent behind it.
    fn element(&self, name: &str) -> Option<Result<f64, LookupError>> {
        let (whole, last) = name.rsplit_once('.')?;
        let agent = element(last).filter(|&agent| agent < self.context.agents.len())?;
        let node = self.value(whole).filter(|node| node.as_f64().is_some() || node.as_str().is_some())?;
        Some(self.evaluate(name, node, Some(&self.context.agents[agent])))
    }

    /// The number that a value is, for one agent if it may depend on it.
    fn evaluate(&self, name: &str, node: &Node, agent: Option<&Agent>) -> Result<f64, LookupError> {
        if let Value::Bool(value) = node.value {
            return Ok(truth(value));
        }
        if let Some(number) = node.as_f64() {
            return Ok(number);
        }
        let wrong = || other_kind(name, "a number", node);
        let text = node.as_str().ok_or_else(wrong)?;
        let expression = Expression::parse(text).map_err(|_| wrong())?;
        let value_of = |variable: &str| match variable {
            "N" => Some(self.context.agents.len() as f64),
            "i" => agent.map(|agent| f64::from(agent.id)),
            _ => None,
        };
        if let Some(variable) = expression.names().into_iter().find(|name| value_of(name).is_none()) {
            return Err(match variable {
                "i" | "t" => LookupError::Varies { name: name.into(), text: text.into(), variable: variable.into() },
                _ => wrong(),
            });
        }
        let formula = expression.compile(|variable| value_of(variable).map(Operand::Constant)).map_err(|_| wrong())?;
        Ok(formula.evaluate(&[]))
    }

    fn missing(&self, kind: &'static str, name: &str) -> LookupError {
        let last = name.rsplit('.').next().unwrap_or(name);
        let known = self.leaf_names();
        let near =
            nearest(last, known.iter().map(String::as_str)).and_then(|near| self.paths_of(near).into_iter().next());
        LookupError::Missing { kind, name: name.into(), near: near.filter(|near| near != name) }
    }
}

fn other_kind(name: &str, expected: &'static str, node: &Node) -> LookupError {
    LookupError::OtherKind { name: name.into(), expected, found: node.describe() }
}

fn truth(value: bool) -> f64 {
    f64::from(u8::from(value))
}

/// The index that a name calls `word`: names count from 1.
fn element(word: &str) -> Option<usize> {
    word.parse().ok().and_then(AgentNumber::new).map(AgentNumber::index)
}

fn coordinates<'a>(agent: &'a Agent, field: &str) -> Option<&'a [f64]> {
    match field {
        "position" => Some(&agent.position),
        "velocity" => Some(&agent.velocity),
        "estimate" => Some(&agent.estimate),
        "estimate_velocity" => Some(&agent.estimate_velocity),
        _ => None,
    }
}

fn parameter(agent: &Agent, field: &str) -> Option<f64> {
    match field {
        "id" => Some(f64::from(agent.id)),
        "order" => Some(agent.vehicle.order() as f64),
        "R_hat" => agent.nominal.parameter("R"),
        _ => agent.vehicle.parameter(field),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Selection;

    const TEXT: &str = r#"
name = "three"
agents = [
    { position = [0, 0, 0], R = 0.25, m = 3, I = 0.1 },
    { position = [2, 0, "pi/2"], velocity = 1, R = 0.25, m = 3, I = "1/10" },
    { position = [0, 2, 0], R = 0.25, m = 3, I = 0.1 },
]
[timing]
dt = "1/100"
duration = 20
[vehicle]
kind = "omni"
order = 2
[topology]
b = "1/i"
[parameters]
gain = 2
[reference]
position = ["cos(t)", "sin(t)", 0]
[disturbance]
matched = ["0.1*sin(t)*px", "v2", "i"]
[plant]
kind = "vehicles"
[planner]
kind = "reference"
[controller]
kind = "consensus"
k_x = "2*pi*i/N"
every = 2
"#;

    fn scenario() -> Scenario {
        let text = TEXT.replace("dt = \"1/100\"", "dt = 0.01");
        Scenario::load("three.toml", &text, &Selection::default()).unwrap()
    }

    #[test]
    fn numbers_are_those_in_force() {
        let scenario = scenario();
        let pi = std::f64::consts::PI;
        for (name, expected) in [
            ("agents.2.position.3", pi / 2.0),
            ("agents.2.velocity.3", 1.0),
            ("agents.1.velocity.2", 0.0),
            ("agents.2.estimate.3", pi / 2.0),
            ("agents.2.I", 0.1),
            ("agents.3.order", 2.0),
            ("agents.3.R_hat", 0.25),
            ("topology.A.1.3", 1.0),
            ("topology.A.1.2", 0.0),
            ("topology.b.2", 0.5),
            ("topology.any_graph", 0.0),
            ("controller.k_x.3", 2.0 * pi),
            ("parameters.gain", 2.0),
            ("parameters.gain.2", 2.0),
            ("controller.every", 2.0),
            ("planner.every", 1.0),
            ("timing.dt", 0.01),
            ("seed", 0.0),
            ("plant.per_agent", 0.0),
        ] {
            assert_eq!(scenario.number(name), Ok(expected), "{name}");
            assert!(scenario.has(name), "{name}");
        }
        assert_eq!(scenario.length("topology.A.2"), Ok(3));
        assert_eq!(scenario.length("topology.b"), Ok(3));
        assert_eq!(scenario.length("agents.2.velocity"), Ok(3));
        assert_eq!(scenario.length("agents"), Ok(3));
        assert_eq!(scenario.text("controller.kind"), Ok("consensus"));
    }

    #[test]
    fn what_is_not_there_is_said() {
        let scenario = scenario();
        let refused = |name: &str| scenario.number(name).unwrap_err().to_string();
        assert_eq!(
            refused("parameters.k_y"),
            "the scenario has no number called `parameters.k_y`; did you mean `controller.k_x`?"
        );
        assert_eq!(refused("agents.4.position.1"), "the scenario has no number called `agents.4.position.1`");
        assert_eq!(refused(""), "the scenario has no number called ``");
        assert!(refused("controller.kind").contains("is not a number, but the string \"consensus\""));
        assert!(refused("controller.k_x").ends_with("which depends on `i`; `controller.k_x.K` is that of agent K"));
        assert!(refused("reference.position.1").ends_with("which depends on `t`"));
        assert!(refused("agents").contains("a list of 3 values"));
        assert!(!scenario.has("parameters.k_y") && scenario.has("agents"));
    }

    #[test]
    fn the_graph_counts_from_one() {
        let graph = scenario().graph();
        let [one, two, three] = [0, 1, 2].map(AgentNumber::at);
        assert_eq!((graph.weight(one, three), graph.weight(one, two), graph.b(two)), (1.0, 0.0, 0.5));
        assert_eq!(graph.neighbours(one).collect::<Vec<_>>(), [three]);
        assert_eq!(graph.weight_at(one, three, 1e3), 1.0);
    }

    #[test]
    fn the_disturbance_is_that_of_the_plant() {
        let scenario = scenario();
        let mut out = [7.0; 3];
        scenario.context.disturbance[1].matched_at(1.0, &[2.0, 0.0, 0.0], &[0.0, 4.0, 0.0], &mut out);
        assert_eq!(out, [0.1 * libm::sin(1.0) * 2.0, 4.0, 2.0]);
        scenario.context.disturbance[1].mismatched_at(1.0, &[2.0, 0.0, 0.0], &[], &mut out);
        assert_eq!(out, [0.0; 3]);
    }
}
