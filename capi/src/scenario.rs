//! What a participant asks about the scenario.

use std::ffi::{c_char, c_int};

use formation::config::{Node, Value};

use crate::participant::{Participant, c_text};

impl Participant {
    /// Whether the scenario has a value called `name`.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }

    /// The number called `name`; a boolean is 1 or 0.
    pub(crate) fn number(&self, name: &str) -> Result<f64, String> {
        let node = self.required(name, "number")?;
        let number = match node.value {
            Value::Bool(value) => Some(f64::from(u8::from(value))),
            _ => node.as_f64(),
        };
        number.ok_or_else(|| wrong_kind(name, "a number", node))
    }

    /// The text called `name`, to be kept as long as the participant.
    pub(crate) fn text(&mut self, name: &str) -> Result<*const c_char, String> {
        let node = self.required(name, "text")?;
        let text = c_text(node.as_str().ok_or_else(|| wrong_kind(name, "a text", node))?);
        if let Some(known) = self.texts.iter().find(|known| **known == text) {
            return Ok(known.as_ptr());
        }
        let pointer = text.as_ptr();
        self.texts.push(text);
        Ok(pointer)
    }

    /// The number of elements of the list called `name`.
    pub(crate) fn length(&self, name: &str) -> Result<usize, String> {
        let node = self.required(name, "list")?;
        node.as_array().map(<[Node]>::len).ok_or_else(|| wrong_kind(name, "a list", node))
    }

    /// A number of the nominal model of an agent's vehicle.
    pub(crate) fn model(&self, agent: c_int, name: &str) -> Result<f64, String> {
        let agent = self.agent(agent)?;
        let post = self.post.as_ref().ok_or("there is no scenario outside a run")?;
        let number = post.scenario.context.agents[agent].nominal.parameter(name);
        number.ok_or_else(|| format!("the model of agent {} has no number called `{name}`", agent + 1))
    }

    fn value(&self, name: &str) -> Option<&Node> {
        // The empty name would be the whole scenario.
        self.post.as_ref().filter(|_| !name.is_empty())?.scenario.section(name)
    }

    fn required(&self, name: &str, what: &str) -> Result<&Node, String> {
        self.value(name).ok_or_else(|| {
            format!("the scenario has no {what} called `{name}`; whether a value is given, phalanx_has tells")
        })
    }
}

fn wrong_kind(name: &str, expected: &str, found: &Node) -> String {
    format!("`{name}` of the scenario is not {expected}, but {}", found.describe())
}
