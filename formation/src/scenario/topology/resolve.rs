//! Graphs of files become lists of links, so that the scenario needs no other file.

use std::path::Path;
use std::sync::Arc;

use super::file::{self, FileLink, GraphFile};
use crate::config::{Entry, Node, Origin, Problem, Source, Value, did_you_mean};

/// Replaces `graph = { file = "..." }` by the links in that file. Paths start from the folder of the scenario, which is called
/// `scenario`.
///
/// # Errors
/// If the file cannot be read, is not what its name says, or has another number of nodes than the scenario has agents.
pub(in crate::scenario) fn resolve_files(root: &mut Node, scenario: &str) -> Result<(), Problem> {
    let agents = root.at("agents").and_then(Node::as_array).map(<[Node]>::len);
    let folder = Path::new(scenario).parent().unwrap_or(Path::new(""));
    if let Some(graph) = root.at_mut("topology.graph") {
        resolve(graph, "topology.graph", folder, agents)?;
    }
    let switches = root.at_mut("topology.at").and_then(Node::as_array_mut);
    for (switch, number) in switches.into_iter().flatten().zip(1..) {
        if let Some(graph) = switch.at_mut("graph") {
            resolve(graph, &format!("topology.at.{number}.graph"), folder, agents)?;
        }
    }
    Ok(())
}

fn resolve(graph: &mut Node, path: &str, folder: &Path, agents: Option<usize>) -> Result<(), Problem> {
    let Some(table) = graph.as_table_mut() else { return Ok(()) };
    // Several graphs at once are refused where the table is read.
    let kinds = ["ring", "line", "star", "complete", "grid", "random", "links"];
    let Some(entry) = table.entry("file").filter(|_| kinds.iter().all(|kind| table.get(kind).is_none())) else {
        return Ok(());
    };
    let Some(name) = entry.node.as_str() else { return Ok(()) };
    let place = entry.node.origin.clone();
    let refuse = |message: String| Problem::new(Some(place.clone()), format!("{path}.file"), message);
    let file = folder.join(name);
    let text = crate::config::read_data(&file).map_err(|error| {
        let hint = near_file(&file);
        refuse(format!("cannot read the graph {}: {error}{hint}", file.display()))
    })?;
    let source = Arc::new(Source { name: file.display().to_string(), text });
    let directed = table.get("directed").map(|node| matches!(node.value, Value::Bool(true)));
    let GraphFile { links, directed: found, nodes } = file::parse(&file, &source.text).map_err(|wrong| {
        let origin = Origin::File { source: source.clone(), span: wrong.span };
        let problem = Problem::new(Some(origin), "", wrong.message);
        match wrong.help {
            Some(help) => problem.with_help(help),
            None => problem,
        }
    })?;
    if let (Some(node), Some(_)) = (table.get("directed"), found) {
        let message = format!("{} says itself whether its links are directed; leave it out", file.display());
        return Err(Problem::new(Some(node.origin.clone()), format!("{path}.directed"), message));
    }
    if let Some((nodes, agents)) = nodes.zip(agents).filter(|(nodes, agents)| nodes != agents) {
        return Err(refuse(format!("the graph has {nodes} nodes, and the scenario has {agents} agents")));
    }
    let is_directed = found.or(directed).unwrap_or(false);
    let list = links.into_iter().map(|link| list_entry(link, &source)).collect();
    table.remove("file");
    for (key, value) in [("directed", Value::Bool(is_directed)), ("links", Value::Array(list))] {
        table.insert_entry(entry_of(key, value, &place));
    }
    Ok(())
}

fn entry_of(key: &str, value: Value, origin: &Origin) -> Entry {
    Entry { key: key.into(), key_origin: origin.clone(), node: Node { value, origin: origin.clone() } }
}

/// A link as the list of a scenario has it; messages name its line in the file.
fn list_entry(link: FileLink, source: &Arc<Source>) -> Node {
    let origin = Origin::File { source: source.clone(), span: link.span };
    let node = |value| Node { value, origin: origin.clone() };
    let ends = [link.from, link.to].map(|number| node(Value::Integer(number as i64)));
    let list = ends.into_iter().chain(link.weight.map(|weight| node(Value::Float(weight)))).collect();
    node(Value::Array(list))
}

/// A file in the same folder that has nearly this name.
fn near_file(file: &Path) -> String {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else { return String::new() };
    let mut names: Vec<String> =
        entries.take(1000).flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    did_you_mean(&name, names.iter().map(String::as_str))
}
