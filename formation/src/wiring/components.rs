//! The components that the sections of a scenario name.

use super::{Component, Kind, Roles};
use crate::config::{Node, Problem, Problems, Sort, did_you_mean};
use crate::role::Role;
use crate::scenario::Scenario;

/// Reads and checks the components of all roles; what is wrong goes to `problems`.
pub(super) fn read_components(
    scenario: &Scenario,
    roles: &Roles,
    problems: &mut Problems,
) -> Vec<(Role, Kind, Box<dyn Component>)> {
    let mut components = Vec::new();
    for role in Role::ALL {
        if scenario.component(role).is_none() {
            // Without an observer, a reference or inputs there is nothing to serve.
            let agents = &scenario.context.agents;
            let is_needed = match role {
                Role::Observer => false,
                Role::Planner => scenario.section("reference").is_some(),
                Role::Controller => agents.iter().any(|agent| agent.vehicle.inputs() > 0),
                Role::Plant => true,
            };
            if is_needed {
                problems.push(scenario.problem("", format!("missing section `[{role}]`")));
            }
            continue;
        }
        let kinds: Vec<Kind> = roles.of(role).copied().collect();
        components.extend(read_component(scenario, role, &kinds, problems));
    }
    components
}

/// Reads and checks the component of one role; what is wrong goes to `problems`.
pub(super) fn read_component(
    scenario: &Scenario,
    role: Role,
    kinds: &[Kind],
    problems: &mut Problems,
) -> Option<(Role, Kind, Box<dyn Component>)> {
    let section = scenario.section(role.name())?;
    if section.as_table().is_none() {
        let message = format!("expected a table with the `kind` of the {role}, found {}", section.describe());
        problems.push(scenario.problem(role.name(), message));
        return None;
    }
    let (kind, parameters) = split_kind(section, role, kinds, problems)?;
    let component = (kind.read)(&parameters, role.name(), problems)?;
    for (field, message) in component.check(&scenario.context).findings {
        let path = match field.strip_prefix('/') {
            // The links may be given in another way than as a matrix.
            Some("topology.A") if scenario.section("topology.graph").is_some() => "topology.graph".to_string(),
            Some(absolute) => absolute.to_string(),
            None => format!("{role}.{field}"),
        };
        problems.push(scenario.problem(&path, message));
    }
    Some((role, kind, component))
}

/// The component that a section names, and the section without the keys that are not its parameters.
fn split_kind(section: &Node, role: Role, kinds: &[Kind], problems: &mut Problems) -> Option<(Kind, Node)> {
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
    let mut parameters = section.clone();
    let table = parameters.as_table_mut()?;
    table.remove("every");
    table.remove("offset");
    table.remove("per_agent");
    table.remove("groups");
    table.remove("with");
    let Some(node) = table.remove("kind") else {
        let message = format!("missing field `kind`, expected one of {}", names.join(", "));
        problems.at(section, role.name(), message).sort = Sort::Missing;
        return None;
    };
    let Some(found) = node.as_str() else {
        let message = format!("expected a name, one of {}, found {}", names.join(", "), node.describe());
        problems.push(Problem::new(Some(node.origin.clone()), format!("{role}.kind"), message));
        return None;
    };
    match kinds.iter().find(|kind| kind.name == found) {
        Some(kind) => Some((*kind, parameters)),
        None => {
            let (known, hint) = (names.join(", "), did_you_mean(found, names.iter().copied()));
            let message = format!("no {role} is called `{found}`, expected one of {known}{hint}");
            problems.push(Problem::new(Some(node.origin.clone()), format!("{role}.kind"), message));
            None
        }
    }
}
