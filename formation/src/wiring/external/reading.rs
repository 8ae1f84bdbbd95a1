//! What a program reads, as `reads` of a scenario says it.

use lockstep::Timing;

use crate::config::did_you_mean;
use crate::role::Role;
use crate::scenario::{Context, agents_in};

/// Behind an entry: the sample of the step before.
const BEFORE: &str = "@before";

/// An entry of `reads`: all signals of some participants, of this step or of the step before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Reading {
    pub(super) role: Role,
    pub(super) whom: Whom,
    pub(super) timing: Timing,
}

/// Of which agents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Whom {
    /// Those that the program serves.
    Own,
    /// Those from which its agents receive.
    Neighbours,
    /// All.
    All,
    /// These, from 1.
    Some(Vec<usize>),
}

impl Reading {
    /// Reads `plant`, `neighbours.controller@before`, `all.observer` or `planner.1,3-6`.
    ///
    /// # Errors
    /// Says what is wrong.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let (what, timing) = match text.trim().split_once('@') {
            None => (text.trim(), Timing::SameStep),
            Some((what, "before")) => (what, Timing::Delayed),
            Some((_, other)) => return Err(format!("{text:?}: expected `{BEFORE}` or nothing, found `@{other}`")),
        };
        let (whom, name) = match what.split_once('.') {
            None => (Whom::Own, what),
            Some(("own", name)) => (Whom::Own, name),
            Some(("neighbours", name)) => (Whom::Neighbours, name),
            Some(("all", name)) => (Whom::All, name),
            Some((name, agents)) if role_called(name).is_some() => {
                let agents = agents_in(agents);
                (Whom::Some(agents.ok_or_else(|| format!("{text:?}: expected agents such as `{name}.1,3-6`"))?), name)
            }
            Some((word, _)) => {
                let hint =
                    did_you_mean(word, ["own", "neighbours", "all"].into_iter().chain(Role::ALL.map(Role::name)));
                return Err(format!("{text:?}: expected own, neighbours, all or a role before the point{hint}"));
            }
        };
        let role = role_called(name).ok_or_else(|| {
            let hint = did_you_mean(name, Role::ALL.map(Role::name));
            format!("{text:?}: expected plant, planner, observer or controller{hint}")
        })?;
        Ok(Self { role, whom, timing })
    }

    /// What a program of `role` reads that does not say it; see `docs/adding-a-controller.md`.
    pub(super) fn usual(role: Role) -> Vec<(Self, Need)> {
        use Timing::{Delayed, SameStep};
        let reading = |role, whom: &Whom, timing| (Self { role, whom: whom.clone(), timing }, Need::IfPublished);
        let own = |role, timing| reading(role, &Whom::Own, timing);
        let near = |role, timing| [own(role, timing), reading(role, &Whom::Neighbours, timing)];
        match role {
            Role::Controller => [
                near(Role::Plant, SameStep),
                near(Role::Planner, SameStep),
                near(Role::Observer, SameStep),
                near(Role::Controller, Delayed),
            ]
            .concat(),
            Role::Observer => [near(Role::Plant, SameStep), near(Role::Controller, Delayed)].concat(),
            Role::Plant => vec![own(Role::Controller, Delayed), own(Role::Planner, Delayed)],
            Role::Planner => {
                vec![own(Role::Plant, Delayed), own(Role::Observer, Delayed), own(Role::Controller, Delayed)]
            }
        }
    }

    /// The agents (from 0) that are meant for a program that serves `own` (from 0), each once.
    ///
    /// # Errors
    /// Names an agent that the scenario does not have.
    pub(super) fn agents(&self, context: &Context, own: &[usize]) -> Result<Vec<usize>, String> {
        let count = context.agents.len();
        match &self.whom {
            Whom::Own => Ok(own.to_vec()),
            Whom::All => Ok((0..count).collect()),
            Whom::Neighbours => {
                // Those of all times: a graph may switch.
                let heard = |&agent: &usize| context.topology.neighbourhood(agent).heard().to_vec();
                let mut agents: Vec<usize> = own.iter().flat_map(heard).collect();
                agents.sort_unstable();
                agents.dedup();
                Ok(agents)
            }
            Whom::Some(agents) => match agents.iter().find(|&&agent| agent > count) {
                Some(agent) => Err(format!("there is no agent {agent}; the scenario has {count}")),
                None => Ok(agents.iter().map(|agent| agent - 1).collect()),
            },
        }
    }
}

/// Whether something must be published to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Need {
    /// The scenario names it.
    Always,
    /// It belongs to what is usually read.
    IfPublished,
}

fn role_called(name: &str) -> Option<Role> {
    Role::ALL.into_iter().find(|role| role.name() == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_names_whom_what_and_when() {
        let parse = |text: &str| Reading::parse(text).unwrap();
        let reading = |role, whom, timing| Reading { role, whom, timing };
        assert_eq!(parse("plant"), reading(Role::Plant, Whom::Own, Timing::SameStep));
        assert_eq!(parse("own.observer"), reading(Role::Observer, Whom::Own, Timing::SameStep));
        assert_eq!(parse("neighbours.controller@before"), reading(Role::Controller, Whom::Neighbours, Timing::Delayed));
        assert_eq!(parse("all.plant@before"), reading(Role::Plant, Whom::All, Timing::Delayed));
        assert_eq!(parse("planner.1,3-4"), reading(Role::Planner, Whom::Some(vec![1, 3, 4]), Timing::SameStep));
    }

    #[test]
    fn mistakes_are_named() {
        let refused = |text: &str| Reading::parse(text).unwrap_err();
        assert_eq!(
            refused("plants"),
            "\"plants\": expected plant, planner, observer or controller; did you mean `plant`?"
        );
        assert!(refused("neighbors.plant").ends_with("before the point; did you mean `neighbours`?"));
        assert!(refused("plant@befor").ends_with("expected `@before` or nothing, found `@befor`"));
        assert!(refused("plant.0").ends_with("expected agents such as `plant.1,3-6`"));
        assert!(refused("").starts_with("\"\": expected plant"));
    }
}
