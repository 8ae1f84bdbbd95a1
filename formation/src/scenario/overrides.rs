//! Overrides of the command line: short names, whole columns of the agents, and paths.

use super::SECTIONS;
use super::agents::AGENT_FIELDS;
use super::renumber::{Renumbering, repeat_emulators};
use super::topology::{TWO_WAY_RING, choose_agents};
use crate::config::{Node, Origin, Problem, Sort, Value, brief, did_you_mean};

/// Names of the thesis and of its specifications for fields that are called otherwise here.
const ALIASES: &[(&str, &str)] = &[
    ("T", "timing.duration"),
    ("duration", "timing.duration"),
    ("dt", "timing.dt"),
    ("x0", "agents.*.position"),
    ("v0", "agents.*.velocity"),
    ("xhat0", "agents.*.estimate"),
    ("vhat0", "agents.*.estimate_velocity"),
    ("Rhat", "agents.*.R_hat"),
    ("ids", "agents.*.id"),
    ("A", "topology.A"),
    ("A1", "topology.A"),
    ("b", "topology.b"),
    ("graph", "topology.graph"),
    ("leaders", "topology.leaders"),
    ("UM", "vehicle.UM"),
    ("any_graph", "topology.any_graph"),
];

/// Names of other specifications for what is said in another way here.
const FOREIGN: &[(&str, &str)] = &[
    (
        "control_hz",
        "controllers run at every step, or at every `controller.every`-th: set `timing.dt`, such as dt=0.02 for 50 Hz",
    ),
    ("Ts", "the length of a step is `timing.dt`"),
    ("t_end", "the length of a run is `timing.duration`"),
    ("num_agents", "the number of agents is `N`"),
];

/// More than these are taken for a mistake.
const MOST_AGENTS: usize = 1000;

/// An override `PATH=VALUE` as the user wrote it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Override<'a> {
    path: &'a str,
    value: &'a str,
    /// The whole argument, which every value that it gives refers to.
    origin: Origin,
}

impl<'a> Override<'a> {
    /// Splits `PATH=VALUE`.
    pub(crate) fn parse(text: &'a str) -> Result<Self, Problem> {
        match text.split_once('=') {
            Some((path, value)) if !path.trim().is_empty() => {
                Ok(Self { path: path.trim(), value: value.trim(), origin: Self::origin(text) })
            }
            _ => Err(override_problem(text, "expected NAME=VALUE, such as controller.c_p=3")),
        }
    }

    /// The override `text` as messages name it.
    pub(crate) fn origin(text: &str) -> Origin {
        Origin::argument(&format!("--set {text}"))
    }

    /// A problem of the override `text`: there is no such field.
    pub(crate) fn unknown(text: &str, message: &str) -> Problem {
        override_problem(text, message).sorted(Sort::Unknown)
    }

    /// The full name of what it sets, where it is a short name for a field of every scenario; else the name as it was written.
    pub(crate) fn path(&self) -> &'a str {
        ALIASES.iter().find(|(alias, _)| *alias == self.path).map_or(self.path, |(_, path)| path)
    }

    /// Whether it sets the name `path`, and to what.
    pub(super) fn value_of(&self, path: &str) -> Option<&'a str> {
        (self.path == path).then_some(self.value)
    }
}

/// What the overrides together decide about the agents.
#[derive(Clone, Copy)]
struct Given {
    /// Which agents receive from which.
    adjacency: bool,
    /// How many there are.
    count: bool,
    /// Which ones of the file there are, by their numbers.
    rows: bool,
    /// How many there are, whatever positions are given.
    chosen: bool,
}

/// Applies all overrides to the tree: first those that change the number of agents, then the rest in their order.
pub(super) fn apply(root: &mut Node, overrides: &[Override]) -> Result<(), Problem> {
    let any_of = |names: &[&str]| overrides.iter().any(|o| names.contains(&o.path));
    let rows = overrides.iter().any(chooses_rows);
    let given = Given {
        adjacency: any_of(&["A", "A1", "topology.A", "graph", "topology.graph"]),
        count: any_of(&["agents", "N", "x0"]),
        rows,
        chosen: rows || any_of(&["N"]),
    };
    let rank = |o: &Override| match o.path {
        "agents" => 0,
        "N" => 1,
        "x0" => 2,
        _ => 3,
    };
    let mut ordered: Vec<&Override> = overrides.iter().collect();
    ordered.sort_by_key(|o| rank(o));
    for o in ordered {
        apply_one(root, o, given)?;
    }
    Ok(())
}

/// Whether it chooses agents of the file by their numbers.
fn chooses_rows(o: &Override) -> bool {
    o.path == "agents" && selected_rows(o.value).is_some()
}

fn apply_one(root: &mut Node, o: &Override, given: Given) -> Result<(), Problem> {
    if o.path == "agents"
        && let Some(rows) = selected_rows(o.value)
    {
        return select_agents(root, &rows, o, given);
    }
    if o.path == "N" {
        return resize(root, o, given);
    }
    let path = resolve(root, o)?;
    match path.strip_prefix("agents.*.") {
        Some(field) => set_column(root, field, o, given),
        None => root.set(&path, o.value, &o.origin),
    }
}

/// The full path of what an override names.
fn resolve(root: &Node, o: &Override) -> Result<String, Problem> {
    if o.path() != o.path {
        return Ok(o.path().into());
    }
    // A field at the top can be set whether the file has it or not.
    if o.path.contains(['.', '[']) || root.at(o.path).is_some() || SECTIONS.contains(&o.path) {
        return Ok(o.path.into());
    }
    let mut found = root.find_leaf(o.path);
    if found.is_empty() && AGENT_FIELDS.contains(&o.path) {
        found.push(format!("agents.*.{}", o.path));
    }
    match found.as_slice() {
        [path] => Ok(path.clone()),
        [] => {
            let names = root.leaf_names();
            let known = names.iter().map(String::as_str).chain(SECTIONS.iter().copied());
            let hint = did_you_mean(o.path, known);
            let message = format!("nothing in this scenario is called `{}`{hint}", brief(o.path));
            let found = problem(o, message).sorted(Sort::Unknown);
            Err(match foreign(o.path) {
                Some(help) => found.with_help(help),
                None => found.with_help(
                    "a field that the file leaves out has to be named with its section, as in controller.c_p=3",
                ),
            })
        }
        several => Err(problem(o, format!("`{}` is ambiguous, write one of {}", o.path, several.join(", ")))),
    }
}

/// The numbers of `[1, 3, 5]`; `None` if it is anything else than a list of whole numbers.
fn selected_rows(value: &str) -> Option<Vec<usize>> {
    let inner = value.strip_prefix('[')?.strip_suffix(']')?;
    let numbers: Option<Vec<usize>> =
        inner.split(',').filter(|part| !part.trim().is_empty()).map(|part| part.trim().parse().ok()).collect();
    numbers.filter(|numbers| !numbers.is_empty())
}

/// What to write instead of a name that is one of other specifications.
pub(crate) fn foreign(path: &str) -> Option<&'static str> {
    let name = path.rsplit('.').next().unwrap_or(path);
    FOREIGN.iter().find(|(known, _)| *known == name).map(|(_, help)| *help)
}

/// How many agents `N=...` asks for.
fn count_of(o: &Override) -> Result<usize, Problem> {
    let count = o.value.parse::<usize>().ok().filter(|count| (1..=MOST_AGENTS).contains(count));
    count.ok_or_else(|| {
        problem(o, format!("expected a number of agents from 1 to {MOST_AGENTS}, found {}", brief(o.value)))
    })
}

/// Makes it `N` agents: the first ones, or all and copies of them.
fn resize(root: &mut Node, o: &Override, given: Given) -> Result<(), Problem> {
    let (before, count) = (agents_len(root), count_of(o)?);
    if count != before && given.rows {
        return Err(problem(o, format!("expected N = {before}, as many as `agents` chooses, or only one of both")));
    }
    if count < before {
        let rows: Vec<usize> = (1..=count).collect();
        return select_agents(root, &rows, o, given);
    }
    if let Some(agents) = root.at_mut("agents").and_then(Node::as_array_mut).filter(|agents| !agents.is_empty()) {
        repeat_rows(agents, count);
        repeat_emulators(root, before, count);
    }
    if count != before && !given.adjacency {
        fit_topology(root, count);
    }
    Ok(())
}

/// More agents, alike the ones that there are, in their order.
fn repeat_rows(agents: &mut Vec<Node>, count: usize) {
    let before = agents.len();
    for k in before..count {
        agents.push(agents[k % before].clone());
    }
}

/// Keeps the listed rows of the table of agents, with their numbers as `id`, and the links among them.
fn select_agents(root: &mut Node, rows: &[usize], o: &Override, given: Given) -> Result<(), Problem> {
    let Some(agents) = root.at_mut("agents").and_then(Node::as_array_mut) else {
        return Err(problem(o, "this scenario has no table of agents".into()));
    };
    let count = agents.len();
    if rows.len() > MOST_AGENTS {
        return Err(problem(o, format!("expected at most {MOST_AGENTS} agents, found {}", rows.len())));
    }
    if let Some(twice) = rows.iter().enumerate().find_map(|(k, row)| rows[..k].contains(row).then_some(row)) {
        return Err(problem(o, format!("agent {twice} is chosen twice")));
    }
    if let Some(row) = rows.iter().find(|row| **row == 0 || **row > count) {
        return Err(problem(o, format!("there is no agent {row}; this scenario has agents 1 to {count}")));
    }
    let mut chosen = Vec::new();
    for &row in rows {
        let mut node = agents[row - 1].clone();
        if let Some(table) = node.as_table_mut()
            && table.get("id").is_none()
        {
            table.insert("id", Node { value: Value::Integer(row as i64), origin: o.origin.clone() });
        }
        chosen.push(node);
    }
    *agents = chosen;
    Renumbering::choosing(count, rows).apply(root);
    choose_parameters(root, count, rows);
    if given.adjacency {
        return Ok(());
    }
    // What is left of a strongly connected graph need not be one.
    if let Some(topology) = root.at_mut("topology") {
        choose_agents(topology, count, rows);
        if let Some(table) = topology.as_table_mut() {
            table.insert("any_graph", Node { value: Value::Bool(true), origin: o.origin.clone() });
        }
    }
    Ok(())
}

/// Keeps of the lists among the parameters of vehicles, which have one number for each agent, those of the chosen agents.
fn choose_parameters(root: &mut Node, count: usize, rows: &[usize]) {
    let choose = |vehicle: &mut Node| {
        let Some(parameters) = vehicle.at_mut("parameters").and_then(Node::as_table_mut) else { return };
        let names: Vec<String> = parameters.iter().map(|(name, _)| name.to_string()).collect();
        for name in names {
            let list = parameters.get_mut(&name).and_then(Node::as_array_mut).filter(|list| list.len() == count);
            if let Some(list) = list {
                *list = rows.iter().map(|row| list[row - 1].clone()).collect();
            }
        }
    };
    root.at_mut("vehicle").into_iter().for_each(choose);
    let names = root.at("vehicles").and_then(Node::as_table);
    let names: Vec<String> = names.into_iter().flat_map(|table| table.iter()).map(|(name, _)| name.into()).collect();
    for name in names {
        root.at_mut(&format!("vehicles.{name}")).into_iter().for_each(choose);
    }
}

/// Sets one field of every agent: from a list, an entry each; from one value, the same for all.
fn set_column(root: &mut Node, field: &str, o: &Override, given: Given) -> Result<(), Problem> {
    let value = Node::parse_value(o.value, &o.origin);
    let per_agent_length = usize::from(matches!(field, "position" | "velocity" | "estimate" | "estimate_velocity"));
    let depth = value.as_array().map_or(0, |items| 1 + usize::from(items.iter().any(|item| item.as_array().is_some())));
    let Some(agents) = root.at_mut("agents").and_then(Node::as_array_mut) else {
        return Err(problem(o, "this scenario has no table of agents".into()));
    };
    let values: Vec<Node> = match value.as_array() {
        Some(items) if depth > per_agent_length => items.to_vec(),
        _ => vec![value.clone(); agents.len()],
    };
    let (before, count) = (agents.len(), values.len());
    let is_settled = if field == "position" { given.chosen } else { given.count };
    let too_few = count < before && (field != "position" || is_settled);
    if count == 0 || too_few || count > before && is_settled {
        let message = format!("agents.*.{field}: expected {before} values, one per agent, found {count}");
        return Err(problem(o, message));
    }
    if count > MOST_AGENTS {
        return Err(problem(o, format!("agents.*.{field}: expected at most {MOST_AGENTS} agents, found {count}")));
    }
    // More values than agents mean more agents; initial positions alone mean fewer.
    repeat_rows(agents, count);
    agents.truncate(count);
    for (agent, value) in agents.iter_mut().zip(values) {
        if let Some(table) = agent.as_table_mut() {
            table.insert(field, value);
        }
    }
    if count < before {
        let rows: Vec<usize> = (1..=count).collect();
        Renumbering::choosing(before, &rows).apply(root);
    } else {
        repeat_emulators(root, before, count);
    }
    if count != before && !given.adjacency {
        fit_topology(root, count);
    }
    Ok(())
}

fn agents_len(root: &Node) -> usize {
    root.at("agents").and_then(Node::as_array).map_or(0, <[Node]>::len)
}

/// A matrix for another number of agents means nothing: fall back to the directed ring 1 -> 2 -> ... -> N -> 1, or to the ring
/// with links both ways if the matrix was symmetric.
fn fit_topology(root: &mut Node, agents: usize) {
    let Some(topology) = root.at_mut("topology").and_then(Node::as_table_mut) else { return };
    let Some(old) = topology.get("A").filter(|old| old.as_array().is_some_and(|rows| rows.len() != agents)) else {
        return;
    };
    let (symmetric, origin) = (is_symmetric(old), old.origin.clone());
    topology.remove("A");
    if symmetric {
        topology.insert("A", Node { value: Value::String(TWO_WAY_RING.into()), origin });
    }
}

fn is_symmetric(matrix: &Node) -> bool {
    let rows = matrix.as_array().unwrap_or_default();
    let weight = |i: usize, j: usize| rows[i].as_array().and_then(|row| row.get(j)).and_then(Node::as_f64);
    (0..rows.len()).all(|i| (0..i).all(|j| weight(i, j).is_some() && weight(i, j) == weight(j, i)))
}

fn problem(o: &Override, message: String) -> Problem {
    Problem::new(Some(o.origin.clone()), "", message)
}

/// A problem of the override `text` as a whole.
pub(super) fn override_problem(text: &str, message: &str) -> Problem {
    Problem::new(Some(Override::origin(text)), "", message)
}

#[cfg(test)]
mod tests;
