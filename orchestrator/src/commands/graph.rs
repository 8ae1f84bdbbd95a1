//! `phalanx graph`.

use std::collections::BTreeMap;
use std::fmt::Write;

use clap::{Args, ValueEnum};
use formation::wiring::Assembly;
use lockstep::{Network, Timing};
use serde_json::json;

use super::arguments::ScenarioArgs;
use super::select::assemble;
use super::topology;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::verdict::short;
use crate::terminal::{columns, counted, wrapped};

/// How a graph is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GraphFormat {
    /// For a terminal
    Text,
    /// For Markdown that renders Mermaid
    Mermaid,
    /// For Graphviz
    Dot,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct GraphArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// How the graph is written
    #[arg(long, value_enum, default_value_t = GraphFormat::Text)]
    pub(crate) format: GraphFormat,
    /// Same as --format json
    #[arg(long)]
    pub(crate) json: bool,
    /// Show the communication graph of the agents instead: links, connectivity, eigenvalues of the Laplacian, diameter
    #[arg(long, conflicts_with = "format")]
    pub(crate) topology: bool,
}

pub(crate) fn graph(catalog: &Catalog, args: &GraphArgs) -> Result<(), Failure> {
    let assembly = assemble(catalog, &args.scenario)?;
    if args.topology {
        let text = if args.json { topology::describe_json(&assembly) } else { topology::describe(&assembly) };
        println!("{}", text.trim_end());
        return Ok(());
    }
    let phases = assembly.network.phases().map_err(|error| Failure::Usage(error.to_string()))?;
    let edges = Edges::of(&assembly.network);
    let text = match if args.json { GraphFormat::Json } else { args.format } {
        GraphFormat::Text => wrapped(&as_text(&assembly, &phases, &edges), columns()),
        GraphFormat::Mermaid => as_mermaid(&assembly.network, &phases, &edges),
        GraphFormat::Dot => as_dot(&assembly.network, &phases, &edges),
        GraphFormat::Json => as_json(&assembly.network, &phases),
    };
    println!("{}", text.trim_end());
    Ok(())
}

/// Which node reads from which, and when.
struct Edges {
    /// Writer, reader, timing.
    list: Vec<(usize, usize, Timing)>,
}

impl Edges {
    fn of(network: &Network) -> Self {
        let writers = network.writers();
        let mut list = Vec::new();
        for (reader, node) in network.nodes.iter().enumerate() {
            for input in &node.inputs {
                let Some(writer) = writers[input.channel.0] else { continue };
                let edge = (writer, reader, input.timing);
                if !list.contains(&edge) {
                    list.push(edge);
                }
            }
        }
        Self { list }
    }

    fn sources(&self, reader: usize, timing: Timing) -> Vec<usize> {
        self.list.iter().filter(|edge| edge.1 == reader && edge.2 == timing).map(|edge| edge.0).collect()
    }
}

fn as_text(assembly: &Assembly, phases: &[usize], edges: &Edges) -> String {
    let network = &assembly.network;
    let mut text = format!(
        "{}: {} and the orchestrator, {}\n",
        assembly.scenario.label(),
        counted(network.nodes.len(), "process"),
        counted(network.channels.len(), "channel")
    );
    let names =
        |nodes: &[usize]| nodes.iter().map(|&node| network.nodes[node].name.as_str()).collect::<Vec<_>>().join(", ");
    let last = phases.iter().copied().max().unwrap_or(0);
    for phase in 0..=last {
        let _ = writeln!(text, "\nphase {phase}");
        for (index, node) in network.nodes.iter().enumerate().filter(|(index, _)| phases[*index] == phase) {
            let rate = if node.every > 1 { format!(", every {} steps", node.every) } else { String::new() };
            let _ = writeln!(text, "  {}{rate}", node.name);
            for (timing, label) in [(Timing::SameStep, "of this step"), (Timing::Delayed, "of the step before")] {
                let sources = edges.sources(index, timing);
                if !sources.is_empty() {
                    let _ = writeln!(text, "    reads {label}: {}", names(&sources));
                }
            }
            let topics: Vec<&str> =
                node.outputs.iter().map(|channel| network.channels[channel.0].topic.as_str()).collect();
            let _ = writeln!(text, "    writes: {}", topics.join(", "));
        }
    }
    text + &links(assembly)
}

/// The links with what is asked of them: those that are alike in one line.
fn links(assembly: &Assembly) -> String {
    let mut alike: Vec<(String, Vec<String>)> = Vec::new();
    for link in assembly.links() {
        let number = |value: Option<f64>, unit: &str| value.map_or("by formula".into(), |value| short(value) + unit);
        let rate = link.rate.map_or("on demand".into(), |rate| short(rate) + " Hz");
        let signal = link.topic.rsplit('/').next().unwrap_or_default();
        let (delay, loss) = (number(link.delay, " s"), number(link.loss, ""));
        let model = format!("{signal}, mean delay {delay}, loss {loss}, {rate}");
        let [from, to] = link.agents;
        let name = format!("{from} -> {to}");
        match alike.iter_mut().find(|(known, _)| *known == model) {
            Some((_, names)) => names.push(name),
            None => alike.push((model, vec![name])),
        }
    }
    if alike.is_empty() {
        return String::new();
    }
    let lines = alike.into_iter().map(|(model, names)| format!("  {model}\n    {}\n", names.join(", ")));
    format!("\nlinks\n{}", lines.collect::<String>())
}

fn as_mermaid(network: &Network, phases: &[usize], edges: &Edges) -> String {
    let mut text = String::from("flowchart LR\n");
    for (phase, nodes) in by_phase(phases) {
        let _ = writeln!(text, "    subgraph phase {phase}");
        for node in nodes {
            let _ = writeln!(text, "        {}", network.nodes[node].name);
        }
        text.push_str("    end\n");
    }
    for &(writer, reader, timing) in &edges.list {
        let arrow = if timing == Timing::SameStep { "-->" } else { "-.->" };
        let _ = writeln!(text, "    {} {arrow} {}", network.nodes[writer].name, network.nodes[reader].name);
    }
    text
}

fn as_dot(network: &Network, phases: &[usize], edges: &Edges) -> String {
    let mut text = String::from("digraph phalanx {\n    rankdir = LR\n    node [shape = box]\n");
    for (_, nodes) in by_phase(phases) {
        let names: Vec<&str> = nodes.iter().map(|&node| network.nodes[node].name.as_str()).collect();
        let _ = writeln!(text, "    {{ rank = same; {} }}", names.join("; "));
    }
    for &(writer, reader, timing) in &edges.list {
        let style = if timing == Timing::SameStep { "" } else { " [style = dashed, constraint = false]" };
        let _ = writeln!(text, "    {} -> {}{style}", network.nodes[writer].name, network.nodes[reader].name);
    }
    text.push_str("}\n");
    text
}

fn as_json(network: &Network, phases: &[usize]) -> String {
    let nodes: Vec<_> = network
        .nodes
        .iter()
        .zip(phases)
        .map(|(node, phase)| {
            let inputs: Vec<_> = node
                .inputs
                .iter()
                .map(|input| json!({"topic": network.channels[input.channel.0].topic, "timing": input.timing}))
                .collect();
            let outputs: Vec<_> =
                node.outputs.iter().map(|channel| network.channels[channel.0].topic.as_str()).collect();
            json!({"name": node.name, "phase": phase, "every": node.every, "offset": node.offset, "inputs": inputs, "outputs": outputs})
        })
        .collect();
    let channels: Vec<_> = network
        .channels
        .iter()
        .map(|channel| json!({"topic": channel.topic, "agent": channel.agent, "fields": channel.layout}))
        .collect();
    format!("{}\n", json!({"nodes": nodes, "channels": channels}))
}

fn by_phase(phases: &[usize]) -> BTreeMap<usize, Vec<usize>> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (node, &phase) in phases.iter().enumerate() {
        groups.entry(phase).or_default().push(node);
    }
    groups
}
