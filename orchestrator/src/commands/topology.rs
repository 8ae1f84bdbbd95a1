//! `phalanx graph --topology`: the communication graph in numbers.

use formation::math::{Spectrum, Topology};
use formation::wiring::Assembly;
use serde_json::{Value, json};

use crate::judge::verdict::short;
use crate::terminal::counted;
use crate::terminal::table::{Left, Table};

/// Eigenvalues take time in proportion to the cube of the number of agents.
const MOST_WITH_EIGENVALUES: usize = 500;
/// The diameter takes time in proportion to the number of agents times that of links.
const MOST_WITH_DIAMETER: usize = 5000;

/// What there is to say about one graph.
struct Description {
    agents: usize,
    /// Links one way; two of them for one both ways.
    links: usize,
    is_symmetric: bool,
    /// The smallest and the largest weight, if there are links.
    weights: Option<(f64, f64)>,
    is_strongly_connected: bool,
    is_weakly_connected: bool,
    /// Numbers of the agents with b > 0.
    leaders: Vec<usize>,
    /// Number of the first agent that no leader reaches.
    unled: Option<usize>,
    /// The eigenvalues, unless there are too many agents or they are not found.
    spectrum: Option<Spectrum>,
    /// The diameter, unless there are too many agents or the graph is not strongly connected.
    diameter: Option<usize>,
}

impl Description {
    fn of(graph: &Topology) -> Self {
        let agents = graph.size();
        let weights = graph.links().map(|link| link.weight);
        let extremes = weights.fold(None, |found: Option<(f64, f64)>, weight| {
            Some(found.map_or((weight, weight), |(least, most)| (least.min(weight), most.max(weight))))
        });
        Self {
            agents,
            links: graph.links().count(),
            is_symmetric: graph.is_symmetric(),
            weights: extremes,
            is_strongly_connected: graph.unreachable_pair().is_none(),
            is_weakly_connected: graph.is_weakly_connected(),
            leaders: (0..agents).filter(|&agent| graph.b(agent) > 0.0).map(|agent| agent + 1).collect(),
            unled: graph.unled_agent().map(|agent| agent + 1),
            spectrum: if agents <= MOST_WITH_EIGENVALUES { graph.spectrum() } else { None },
            diameter: if agents <= MOST_WITH_DIAMETER { graph.diameter() } else { None },
        }
    }

    fn text(&self) -> String {
        let mut table = Table::new([("", Left), ("", Left)]).indented(2);
        let mut tell = |name: &str, value: String| table.row([name.to_string(), value]);
        let links = match self.is_symmetric {
            true => format!("{}, both ways", counted(self.links / 2, "link")),
            false => format!("{}, one way each (directed)", counted(self.links, "link")),
        };
        tell("agents", self.agents.to_string());
        tell("links", links);
        tell(
            "weights",
            match self.weights {
                None => "-".into(),
                Some((least, most)) if least == most => short(least),
                Some((least, most)) => format!("{} to {}", short(least), short(most)),
            },
        );
        let connected = match (self.is_strongly_connected, self.is_symmetric, self.is_weakly_connected) {
            (true, true, _) => "yes",
            (true, false, _) => "strongly: every agent reaches every other",
            (false, false, true) => "weakly: only if links are used against their direction",
            (false, _, _) => "no",
        };
        tell("connected", connected.into());
        tell("leaders (b > 0)", list(&self.leaders));
        let led = self.unled.map_or("all agents".into(), |agent| format!("not agent {agent}"));
        tell("reached by leaders", led);
        if self.agents > MOST_WITH_EIGENVALUES {
            tell("eigenvalues", format!("left out for more than {MOST_WITH_EIGENVALUES} agents"));
        } else if let Some(spectrum) = &self.spectrum {
            let values: Vec<String> = spectrum.eigenvalues.iter().map(|value| short(clean(*value))).collect();
            tell("algebraic connectivity", short(clean(spectrum.algebraic_connectivity)));
            tell("largest eigenvalue", values.last().cloned().unwrap_or_default());
            let what = if self.is_symmetric { "eigenvalues of L" } else { "their real parts" };
            tell(what, values.join(", "));
        } else {
            tell("eigenvalues", "not found".into());
        }
        let diameter = match self.diameter {
            Some(links) => counted(links, "link"),
            None if self.is_strongly_connected => format!("left out for more than {MOST_WITH_DIAMETER} agents"),
            None => "-".into(),
        };
        tell("diameter", diameter);
        table.text(crate::terminal::columns())
    }

    fn json(&self, from: f64) -> Value {
        let spectrum = self.spectrum.as_ref();
        json!({
            "from": from, "agents": self.agents, "links": self.links, "directed": !self.is_symmetric,
            "weights": self.weights.map(|(least, most)| [least, most]),
            "strongly_connected": self.is_strongly_connected, "weakly_connected": self.is_weakly_connected,
            "leaders": self.leaders, "led": self.unled.is_none(),
            "algebraic_connectivity": spectrum.map(|spectrum| spectrum.algebraic_connectivity),
            "largest_eigenvalue": spectrum.and_then(|spectrum| spectrum.eigenvalues.last().copied()),
            "eigenvalues": spectrum.map(|spectrum| &spectrum.eigenvalues),
            "diameter": self.diameter,
        })
    }
}

/// What rounding leaves of 0 is 0 to a reader.
fn clean(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { value }
}

/// Numbers of agents; a few of them if there are many.
fn list(numbers: &[usize]) -> String {
    const MOST: usize = 12;
    let shown: Vec<String> = numbers.iter().take(MOST).map(usize::to_string).collect();
    match numbers.len() {
        0 => "none".into(),
        count if count > MOST => format!("{}, ... ({count} agents)", shown.join(", ")),
        _ => shown.join(", "),
    }
}

/// All graphs of the run in numbers.
pub(super) fn describe(assembly: &Assembly) -> String {
    let mut text = format!("{}: the communication graph\n", assembly.scenario.label());
    for (from, description) in descriptions(assembly) {
        if assembly.scenario.context.topology.is_switching() {
            text.push_str(&format!("\nfrom t = {} s\n", short(from)));
        }
        text.push_str(&description.text());
    }
    if assembly.scenario.context.proximity.is_some() {
        text.push_str("Links that depend on the distance (topology.proximity) are not counted.\n");
    }
    text
}

/// The same for programs: an object for each interval between switches.
pub(super) fn describe_json(assembly: &Assembly) -> String {
    let graphs: Vec<Value> =
        descriptions(assembly).into_iter().map(|(from, description)| description.json(from)).collect();
    json!({ "scenario": assembly.scenario.label(), "graphs": graphs }).to_string()
}

/// The time of every switch, in s, and the graph from then on.
fn descriptions(assembly: &Assembly) -> Vec<(f64, Description)> {
    let context = &assembly.scenario.context;
    let intervals = context.topology.intervals().iter();
    intervals.map(|(step, graph)| (*step as f64 * context.timing.dt, Description::of(graph))).collect()
}
