//! `[links]`: what agents receive of each other, and when.

mod compile;
mod table;

use std::cell::RefCell;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use self::table::LinkTable;
use super::agents_in;
use crate::config::{Node, Problem, Problems, Table, Value, read};
use crate::data::Library;
use crate::role::Role;

pub(crate) use compile::{CompiledLink, LinkPlace};

const SECTION: &str = "links";

/// The links of a scenario: what a controller or observer of one agent reads of another agent goes over the link between both.
#[derive(Clone, Debug)]
pub struct Links {
    /// The parameters of all links.
    base: Node,
    /// What differs for some links, in the order of the file.
    overlays: Vec<(String, Ends, Node)>,
    outages: Vec<Outage>,
    /// The roles whose signals go over links.
    pub carries: Vec<Role>,
}

/// The fields of `[links]` that are not those of every link.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Common {
    /// Which signals go over links: `state`, `reference`, `estimate`, `command`; by default all.
    #[serde(default = "all_signals")]
    carries: Vec<Carried>,
    /// Times in which links fail.
    #[serde(default)]
    outage: Vec<OutageTable>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Carried {
    State,
    Reference,
    Estimate,
    Command,
}

/// A time in which links fail.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OutageTable {
    /// Its begin, s.
    #[serde(default)]
    from: f64,
    /// Its end, s; by default that of the run.
    until: Option<f64>,
    /// The links that fail, such as `"2 -> 5"`, `"* -> 5"`.
    links: Option<Vec<String>>,
    /// The agents all of whose links fail. With neither of both, all links fail.
    agents: Option<Vec<u32>>,
}

#[derive(Clone, Debug)]
struct Outage {
    from: f64,
    until: f64,
    links: Vec<Ends>,
}

/// The links that `2 -> 5`, `2 -> *` or `1,3-6 -> 2` means; `None` means all agents.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Ends {
    senders: Option<Vec<usize>>,
    receivers: Option<Vec<usize>>,
}

impl Ends {
    const ALL: Self = Self { senders: None, receivers: None };

    fn parse(text: &str) -> Option<Self> {
        let (sender, receiver) = text.split_once("->")?;
        let end = |text: &str| match text.trim() {
            "*" => Some(None),
            list => agents_in(list).map(Some),
        };
        Some(Self { senders: end(sender)?, receivers: end(receiver)? })
    }

    fn include(&self, sender: u32, receiver: u32) -> bool {
        let is_in = |list: &Option<Vec<usize>>, agent: u32| {
            list.as_ref().is_none_or(|list| list.binary_search(&(agent as usize)).is_ok())
        };
        is_in(&self.senders, sender) && is_in(&self.receivers, receiver)
    }

    /// An agent that is not there.
    fn unknown(&self, ids: &[u32]) -> Option<usize> {
        if is_choice(ids) {
            return None;
        }
        let named = self.senders.iter().chain(&self.receivers).flatten();
        named.copied().find(|agent| !ids.iter().any(|id| *id as usize == *agent))
    }
}

fn all_signals() -> Vec<Carried> {
    vec![Carried::State, Carried::Reference, Carried::Estimate, Carried::Command]
}

const EXPECTED_ENDS: &str = "expected links such as \"2 -> 5\", \"2 -> *\" or \"1,3-6 -> 2\"";

impl Links {
    /// Reads the section, and its data files from `library`; `ids` are the numbers of the agents in the file.
    pub(super) fn read(root: &Node, ids: &[u32], library: &RefCell<Library>, problems: &mut Problems) -> Option<Self> {
        let section = root.at(SECTION)?;
        let Some(table) = section.as_table() else {
            let message =
                format!("expected a table such as {{ delay = 0.05, loss = 0.1 }}, found {}", section.describe());
            problems.at(root, SECTION, message);
            return None;
        };
        let (mut common, mut base, mut overlays) = (Table::default(), Table::default(), Vec::new());
        let before = problems.len();
        for (key, node) in table.iter() {
            if ["carries", "outage"].contains(&key) {
                common.insert(key, node.clone());
            } else if key.contains("->") {
                match Ends::parse(key) {
                    Some(ends) => overlays.push((key.to_string(), ends, node.clone())),
                    None => problems.push(of_field(node, key, EXPECTED_ENDS)),
                }
            } else {
                base.insert(key, node.clone());
            }
        }
        let with = |table: Table| Node { value: Value::Table(table), origin: section.origin.clone() };
        let common = read::<Common>(&with(common), SECTION, problems);
        let base = with(base);
        _ = read::<LinkTable>(&base, SECTION, problems);
        for (key, ends, node) in &overlays {
            _ = read::<LinkTable>(node, &format!("{SECTION}.{key}"), problems);
            if let Some(agent) = ends.unknown(ids) {
                problems.push(of_field(node, key, &format!("there is no agent {agent}, only {}", known(ids))));
            }
        }
        let outages = common.as_ref().map(|common| read_outages(section, common, ids, problems)).unwrap_or_default();
        library.borrow_mut().prepare(section.texts());
        library.borrow_mut().prepare_files(files_of(section));
        let common = common.filter(|_| problems.len() == before)?;
        let role = |carried: &Carried| match carried {
            Carried::State => Role::Plant,
            Carried::Reference => Role::Planner,
            Carried::Estimate => Role::Observer,
            Carried::Command => Role::Controller,
        };
        let carries = common.carries.iter().map(role).collect();
        Some(Self { base, overlays, outages, carries })
    }

    /// The parameters of the link between these agents, by their numbers in the file.
    fn table(&self, sender: u32, receiver: u32) -> Result<Node, Problem> {
        let mut node = self.base.clone();
        for (_, _, overlay) in self.overlays.iter().filter(|(_, ends, _)| ends.include(sender, receiver)) {
            node.overlay(overlay.clone())?;
        }
        Ok(node)
    }

    fn outages(&self, sender: u32, receiver: u32) -> Vec<(f64, f64)> {
        let of_link = |outage: &&Outage| outage.links.iter().any(|ends| ends.include(sender, receiver));
        self.outages.iter().filter(of_link).map(|outage| (outage.from, outage.until)).collect()
    }
}

fn read_outages(section: &Node, common: &Common, ids: &[u32], problems: &mut Problems) -> Vec<Outage> {
    let mut outages = Vec::new();
    for (place, table) in common.outage.iter().enumerate() {
        let path = format!("outage.{}", place + 1);
        let mut report = |field: &str, message: String| {
            let path = format!("{path}.{field}");
            let mut found = Problems::default();
            found.at(section, &path, message);
            problems.extend(
                found.into_vec().into_iter().map(|problem| Problem { path: format!("{SECTION}.{path}"), ..problem }),
            );
        };
        let until = table.until.unwrap_or(f64::INFINITY);
        if !table.from.is_finite() || until.is_nan() || until <= table.from {
            report("until", format!("expected a time > {} s, found {until}", table.from));
        }
        let mut links = Vec::new();
        for text in table.links.iter().flatten() {
            match Ends::parse(text) {
                Some(ends) => match ends.unknown(ids) {
                    Some(agent) => report("links", format!("{text}: there is no agent {agent}, only {}", known(ids))),
                    None => links.push(ends),
                },
                None => report("links", format!("{EXPECTED_ENDS}, found {text:?}")),
            }
        }
        for agent in table.agents.iter().flatten() {
            if !ids.contains(agent) && !is_choice(ids) {
                report("agents", format!("there is no agent {agent}, only {}", known(ids)));
            }
            let only = Some(vec![*agent as usize]);
            links.push(Ends { senders: only.clone(), receivers: None });
            links.push(Ends { senders: None, receivers: only });
        }
        if table.links.is_none() && table.agents.is_none() {
            links.push(Ends::ALL);
        }
        outages.push(Outage { from: table.from, until, links });
    }
    outages
}

/// Whether only some of the agents of the file were chosen: others may be named and have no part in the run.
pub(super) fn is_choice(ids: &[u32]) -> bool {
    !ids.iter().copied().eq(1..=ids.len() as u32)
}

/// The agents that there are, `1-6`.
pub(super) fn known(ids: &[u32]) -> String {
    super::list_of(&ids.iter().map(|id| *id as usize).collect::<Vec<_>>())
}

/// A problem of a field of the section.
fn of_field(node: &Node, field: &str, message: &str) -> Problem {
    Problem::new(Some(node.origin.clone()), format!("{SECTION}.{field}"), message)
}

/// The data files that fields `file` name.
fn files_of(node: &Node) -> Vec<&str> {
    match &node.value {
        Value::Table(table) => {
            let own = table.get("file").and_then(Node::as_str);
            own.into_iter().chain(table.iter().flat_map(|(_, node)| files_of(node))).collect()
        }
        Value::Array(items) => items.iter().flat_map(files_of).collect(),
        _ => Vec::new(),
    }
}

/// `[links]`.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    let link = LinkTable::json_schema(generator);
    let mut all = link.clone();
    let common = Common::json_schema(generator);
    let fields =
        |schema: &Schema| schema.get("properties").and_then(|all| all.as_object().cloned()).unwrap_or_default();
    let properties: serde_json::Map<_, _> = fields(&link).into_iter().chain(fields(&common)).collect();
    all.insert("properties".into(), properties.into());
    all.insert("patternProperties".into(), json_schema!({ "->": link }).to_value());
    all.insert("description".into(), "What agents receive of each other, and when.".into());
    all
}
