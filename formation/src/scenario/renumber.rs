//! What a scenario says about single agents by number, when the command line chooses other agents than those of the file.

use crate::config::{Entry, Node, Table, Value};
use crate::role::Role;
use crate::scenario::{agents_in, list_of};

/// What becomes of the agents of a file: the new number of each, `None` for those that are left out.
pub(super) struct Renumbering {
    numbers: Vec<Option<usize>>,
}

impl Renumbering {
    /// Of `count` agents, those of `rows` (from 1) stay, in this order.
    pub(super) fn choosing(count: usize, rows: &[usize]) -> Self {
        let place = |old: usize| rows.iter().position(|&row| row == old).map(|place| place + 1);
        Self { numbers: (1..=count).map(place).collect() }
    }

    /// Applies it to `[swap]`, `[placement]`, `[edges]`, `[on_failure]` and the assertions. Names of agents that the file does not
    /// have stay, so that they are found.
    pub(super) fn apply(&self, root: &mut Node) {
        for section in ["swap", "on_failure"] {
            if let Some(table) = root.at_mut(section).and_then(Node::as_table_mut) {
                self.rename(table, |renumbering, name| renumbering.name(name));
                for role in Role::ALL {
                    if let Some(agents) = table.get_mut(role.name()).and_then(Node::as_table_mut) {
                        self.rename(agents, Self::digits);
                    }
                }
            }
        }
        if let Some(table) = root.at_mut("edges").and_then(Node::as_table_mut) {
            self.rename(table, |renumbering, edge| {
                let Some((reader, writer)) = edge.split_once("<-") else { return Some(edge.into()) };
                Some(format!("{} <- {}", renumbering.name(reader.trim())?, renumbering.name(writer.trim())?))
            });
        }
        if let Some(groups) = root.at_mut("placement.groups").and_then(Node::as_array_mut) {
            for group in groups.iter_mut().filter_map(Node::as_array_mut) {
                group.retain_mut(|member| {
                    let Value::String(name) = &mut member.value else { return true };
                    self.name(name).map(|new| *name = new).is_some()
                });
            }
            groups.retain(|group| group.as_array().is_none_or(|members| !members.is_empty()));
        }
        if let Some(assertions) = root.at_mut("assert").and_then(Node::as_array_mut) {
            assertions.retain_mut(|assertion| {
                let Some(agents) = assertion.at_mut("agents").and_then(Node::as_array_mut) else { return true };
                agents.retain_mut(|agent| {
                    let Value::Integer(number) = &mut agent.value else { return true };
                    self.number(*number).map(|new| *number = new).is_some()
                });
                // An assertion about agents that are not there says nothing.
                !agents.is_empty()
            });
        }
    }

    fn rename(&self, table: &mut Table, new: impl Fn(&Self, &str) -> Option<String>) {
        let old = std::mem::take(table);
        *table = old.into_iter().filter_map(|entry| Some(Entry { key: new(self, &entry.key)?, ..entry })).collect();
    }

    fn number(&self, old: i64) -> Option<i64> {
        let index = usize::try_from(old).ok().and_then(|old| old.checked_sub(1));
        index.and_then(|index| self.numbers.get(index)).map_or(Some(old), |new| new.map(|new| new as i64))
    }

    /// The new form of `3` or `1,3-6`, with what stands behind an `@`.
    fn digits(&self, text: &str) -> Option<String> {
        let (list, behind) = text.find('@').map_or((text, ""), |at| text.split_at(at));
        let Some(old) = agents_in(list) else { return Some(text.into()) };
        let mut new: Vec<usize> =
            old.iter().filter_map(|&old| self.number(old as i64)).map(|new| new as usize).collect();
        new.sort_unstable();
        (!new.is_empty()).then(|| list_of(&new) + behind)
    }

    /// The new form of `controller.3` or `controller_3`; any other name stays.
    fn name(&self, name: &str) -> Option<String> {
        let is_role = |stem: &str| Role::ALL.iter().any(|role| role.name() == stem);
        match name.rfind(['.', '_']) {
            Some(at) if is_role(&name[..at]) => Some(format!("{}{}", &name[..=at], self.digits(&name[at + 1..])?)),
            _ => Some(name.into()),
        }
    }
}

/// Lets emulators of a laboratory play the plants of the agents behind `before`, up to `count`, whose originals they play too.
/// A program, a log or a robot is one of its kind.
pub(super) fn repeat_emulators(root: &mut Node, before: usize, count: usize) {
    let Some(table) = root.at_mut("swap").and_then(Node::as_table_mut) else { return };
    let is_emulator = |node: &&Node| node.as_str().is_some_and(|player| player.trim().starts_with("emulator"));
    for number in before + 1..=count {
        let original = (number - 1) % before + 1;
        let [dotted, plain] = ['.', '_'].map(|point| move |agent: usize| format!("plant{point}{agent}"));
        let found = [&dotted as &dyn Fn(usize) -> String, &plain]
            .into_iter()
            .find_map(|name| Some((name(number), table.get(&name(original)).filter(is_emulator)?.clone())));
        if let Some((name, player)) = found {
            table.insert(name, player);
        } else if let Some(agents) = table.get_mut("plant").and_then(Node::as_table_mut)
            && let Some(player) = agents.get(&original.to_string()).filter(is_emulator).cloned()
        {
            agents.insert(number.to_string(), player);
        }
    }
}
