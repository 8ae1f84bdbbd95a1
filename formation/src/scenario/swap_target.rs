//! Names of participants that something else plays, as `[swap]` and `--swap` write them.

use super::agents_in;
use crate::role::Role;

/// Behind a name: one process plays all of the participants.
const ONE: &str = "@one";

/// The participants that a name stands for: `controller.3`, `controller.*`, `controller`, `plant.1,3-6`, each perhaps with `@one`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SwapTarget {
    /// Their role.
    pub role: Role,
    /// Which of them.
    pub whom: Served,
    /// Whether one process plays them all.
    pub together: bool,
}

/// The agents of the participants that a name stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Served {
    /// The role without a number: the participant that serves all agents, or all participants.
    Role,
    /// `*`: all participants, one per agent.
    Each,
    /// These agents, from 1.
    Agents(Vec<usize>),
}

impl SwapTarget {
    /// Reads a name; `None` if it does not begin with a role, or its agents are no list.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (name, together) = text.strip_suffix(ONE).map_or((text, false), |name| (name.trim_end(), true));
        let starts = |role: &Role| {
            let rest = name.strip_prefix(role.name())?;
            Some((*role, rest))
        };
        let (role, rest) = Role::ALL.iter().find_map(starts)?;
        let whom = match rest.strip_prefix(['.', '_']) {
            None if rest.is_empty() => Served::Role,
            Some("*") => Served::Each,
            Some(agents) => Served::Agents(agents_in(agents)?),
            None => return None,
        };
        Some(Self { role, whom, together })
    }

    /// How exactly it names participants: of two that mean the same one, the more exact counts.
    pub fn exactness(&self) -> u8 {
        match &self.whom {
            Served::Agents(agents) if agents.len() == 1 => 2,
            Served::Agents(_) => 1,
            Served::Role | Served::Each => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_role_with_agents() {
        let target = |role, whom, together| Some(SwapTarget { role, whom, together });
        let agents = |agents: &[usize]| Served::Agents(agents.to_vec());
        assert_eq!(SwapTarget::parse("controller.3"), target(Role::Controller, agents(&[3]), false));
        assert_eq!(SwapTarget::parse(" controller_3 "), target(Role::Controller, agents(&[3]), false));
        assert_eq!(SwapTarget::parse("observer"), target(Role::Observer, Served::Role, false));
        assert_eq!(SwapTarget::parse("controller.*@one"), target(Role::Controller, Served::Each, true));
        assert_eq!(SwapTarget::parse("plant.1,3-4"), target(Role::Plant, agents(&[1, 3, 4]), false));
        for wrong in ["", "plants", "plant.", "plant.x", "controler.3", "plant.*@two"] {
            assert_eq!(SwapTarget::parse(wrong), None, "{wrong}");
        }
    }
}
