//! `topology.graph`: a graph by its name, as a list of links, or with options.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use crate::config::{Node, Problem, Problems, Value, did_you_mean, read};
use crate::math::{Family, Link, LinkError, Orientation, Topology};
use crate::scenario::elsewhere::Elsewhere;

/// The names of graphs.
const NAMES: &[&str] = &["ring", "two_way_ring", "line", "star", "complete", "grid"];

/// A graph with options: one of `ring`, `line`, `star`, `complete`, `grid`, `random`, `links` and `file`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GraphTable {
    /// 1 -> 2 -> ... -> N -> 1, or the same both ways.
    ring: Option<Direction>,
    /// 1 -> 2 -> ... -> N, or the same both ways.
    line: Option<Direction>,
    /// Number of the agent that has a link with every other.
    star: Option<i64>,
    /// Every agent with every other, both ways.
    complete: Option<bool>,
    /// Rows and columns of a grid; agents are numbered row by row.
    grid: Option<[i64; 2]>,
    /// The probability of a link, for each pair of agents by itself.
    random: Option<f64>,
    /// Links `[from, to]` or `[from, to, weight]`; agents are numbered from 1.
    #[serde(default)]
    #[schemars(with = "Vec<Vec<f64>>")]
    links: Option<Elsewhere>,
    /// A file with the links: GraphML (`.graphml`, `.xml`), CSV (`.csv`), or a list of links (any other name), from the folder of the
    /// scenario.
    file: Option<String>,
    /// `random`: seed of the numbers that decide; by default the seed of the scenario.
    seed: Option<u64>,
    /// `random`: draws graphs until one is connected.
    connected: Option<bool>,
    /// `star`, `random`, `links` and lists of links in a file: links go one way only.
    directed: Option<bool>,
    /// Weight of the links that have none of their own; by default 1.
    weight: Option<f64>,
}

/// What `topology.graph` looks like to an editor. (JSON Schema)
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    let table = GraphTable::json_schema(generator);
    json_schema!({ "anyOf": [{ "enum": NAMES, "description": "A graph by its name, with unit weights." }, table] })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Direction {
    /// Links go one way.
    Directed,
    /// Links go both ways.
    Undirected,
}

impl From<Direction> for Orientation {
    fn from(direction: Direction) -> Self {
        match direction {
            Direction::Directed => Self::Directed,
            Direction::Undirected => Self::Undirected,
        }
    }
}

/// The links among `size` agents that `node` at `path` describes, without links to the reference; nothing if they are wrong, which is
/// reported.
pub(super) fn read_graph(node: &Node, path: &str, size: usize, seed: u64, problems: &mut Problems) -> Option<Topology> {
    let mut report = |problem: Problem| problems.push(problem);
    let problem = |message: String| Problem::new(Some(node.origin.clone()), path, message);
    if let Some(name) = node.as_str() {
        let Some(family) = named(name) else {
            let expected = NAMES.join(", ");
            let hint = did_you_mean(name, NAMES.iter().copied());
            report(problem(format!("no graph is called {name:?}, expected one of {expected}, or a table{hint}")));
            return None;
        };
        return of_family(family, size, 1.0).map_err(|message| report(problem(message))).ok();
    }
    if node.as_table().is_none() {
        let found = node.describe();
        report(problem(format!("expected the name of a graph ({}) or a table, found {found}", NAMES.join(", "))));
        return None;
    }
    let table = read::<GraphTable>(node, path, problems)?;
    let found = table.graph(node, size, seed);
    found.map_err(|(field, message)| problems.at(node, &field, message).path = join(path, &field)).ok()
}

fn join(path: &str, field: &str) -> String {
    if field.is_empty() { path.into() } else { format!("{path}.{field}") }
}

fn named(name: &str) -> Option<Family> {
    let (directed, undirected) = (Orientation::Directed, Orientation::Undirected);
    Some(match name {
        "ring" => Family::Ring(directed),
        "two_way_ring" => Family::Ring(undirected),
        "line" => Family::Line(undirected),
        "star" => Family::Star { centre: 0, orientation: undirected },
        "complete" => Family::Complete,
        "grid" => Family::Grid { shape: None },
        _ => return None,
    })
}

fn of_family(family: Family, size: usize, weight: f64) -> Result<Topology, String> {
    let links = family.links(size, weight)?;
    Topology::from_links(&links, vec![0.0; size]).map_err(|error| error.message)
}

/// A field below the table and what is wrong with it.
type Finding = (String, String);

impl GraphTable {
    fn graph(&self, node: &Node, size: usize, seed: u64) -> Result<Topology, Finding> {
        let finding = |field: &str, message: &str| (field.to_string(), message.to_string());
        let kind = self.kind()?;
        let weight = self.weight.unwrap_or(1.0);
        if !(weight.is_finite() && weight > 0.0) {
            return Err(finding("weight", &format!("expected a weight > 0, found {weight}")));
        }
        let is_random = kind == "random";
        for (field, given) in [("seed", self.seed.is_some()), ("connected", self.connected.is_some())] {
            if given && !is_random {
                return Err(finding(field, &format!("only a `random` graph has `{field}`, and this one is `{kind}`")));
            }
        }
        if self.directed.is_some() && !matches!(kind, "star" | "random" | "links" | "file") {
            let message = match kind {
                "ring" | "line" => format!("write {kind} = \"directed\" or \"undirected\" instead"),
                _ => format!(
                    "the links of a `{kind}` graph go both ways; only star, random, links and file have `directed`"
                ),
            };
            return Err(finding("directed", &message));
        }
        let orientation = if self.directed == Some(true) { Orientation::Directed } else { Orientation::Undirected };
        let whole = |value: i64| usize::try_from(value).unwrap_or(0);
        let family = match kind {
            "ring" => Family::Ring(self.ring.map_or(Orientation::Directed, Orientation::from)),
            "line" => Family::Line(self.line.map_or(Orientation::Undirected, Orientation::from)),
            "star" => {
                let centre = self.star.unwrap_or(1);
                // Below 1 there is none, as there is none above N.
                Family::Star { centre: whole(centre).wrapping_sub(1), orientation }
            }
            "complete" if self.complete == Some(false) => {
                return Err(finding("complete", "expected true, or another graph"));
            }
            "complete" => Family::Complete,
            "grid" => Family::Grid { shape: self.grid.map(|shape| shape.map(whole)) },
            "random" => Family::Random {
                probability: self.random.unwrap_or(0.0),
                seed: self.seed.unwrap_or(seed),
                connected: self.connected == Some(true),
                orientation,
            },
            "links" => {
                let list = node.at("links").and_then(Node::as_array);
                let list = list.ok_or_else(|| finding("links", "expected a list of links [from, to, weight]"))?;
                return listed(list, orientation, weight, size)
                    .map_err(|(place, message)| (format!("links.{}", place + 1), message));
            }
            _ => return Err(finding("file", "a graph of a file is read when the scenario is; here it cannot be")),
        };
        of_family(family, size, weight).map_err(|message| (kind.to_string(), message))
    }

    /// The only key that says which graph it is.
    fn kind(&self) -> Result<&'static str, Finding> {
        let given = [
            ("ring", self.ring.is_some()),
            ("line", self.line.is_some()),
            ("star", self.star.is_some()),
            ("complete", self.complete.is_some()),
            ("grid", self.grid.is_some()),
            ("random", self.random.is_some()),
            ("links", self.links.is_some()),
            ("file", self.file.is_some()),
        ];
        let mut found = given.iter().filter(|(_, given)| *given).map(|(name, _)| *name);
        match (found.next(), found.next()) {
            (Some(only), None) => Ok(only),
            (first, second) => {
                let names: Vec<&str> = given.iter().map(|(name, _)| *name).collect();
                let found = match (first, second) {
                    (Some(first), Some(second)) => format!("found `{first}` and `{second}`"),
                    _ => "found none".into(),
                };
                Err((String::new(), format!("expected one of {}, {found}", names.join(", "))))
            }
        }
    }
}

/// The graph of a list of links; what is wrong with which of them otherwise.
fn listed(list: &[Node], orientation: Orientation, weight: f64, size: usize) -> Result<Topology, (usize, String)> {
    let both = orientation == Orientation::Undirected;
    let mut links = Vec::with_capacity(list.len() * (1 + usize::from(both)));
    for (place, node) in list.iter().enumerate() {
        let entry = node.as_array().unwrap_or_default();
        let number = |value: &Node| match value.value {
            // An agent 0, or below, is one that there is not, and is found with the others.
            Value::Integer(number) => Some(usize::try_from(number).unwrap_or(0).wrapping_sub(1)),
            _ => None,
        };
        let parsed = match entry {
            [from, to] => number(from).zip(number(to)).map(|ends| (ends, weight)),
            [from, to, weight] => number(from).zip(number(to)).zip(weight.as_f64()),
            _ => None,
        };
        let Some(((from, to), weight)) = parsed else {
            let found = node.describe();
            let message =
                format!("expected [from, to] or [from, to, weight], with whole numbers of agents, found {found}");
            return Err((place, message));
        };
        links.push(Link { from, to, weight });
        if both {
            links.push(Link { from: to, to: from, weight });
        }
    }
    let per_entry = if both { 2 } else { 1 };
    Topology::from_links(&links, vec![0.0; size]).map_err(|LinkError { place, message }| (place / per_entry, message))
}
