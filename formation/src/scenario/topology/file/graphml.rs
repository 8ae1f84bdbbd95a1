//! GraphML (Brandes, Eiglsperger, Lerner, Pich: Graph Markup Language, 2013), as networkx and other programs write it.

use roxmltree::{Document, Node, ParsingOptions};

use super::nodes::Nodes;
use super::{FileLink, GraphFile, Wrong, weight};
use crate::config::{brief, did_you_mean};

/// Reads the first graph of a file: its nodes, and its edges with the attribute `weight` if there is one.
pub(super) fn parse(text: &str) -> Result<GraphFile, Wrong> {
    let options = ParsingOptions { nodes_limit: 20_000_000, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let line = text.split_inclusive('\n').take(at.row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
        let place = (line + at.col.saturating_sub(1) as usize).min(text.len());
        Wrong::new(place..place, format!("not valid XML: {error}"))
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "graphml" {
        let message = format!("expected GraphML, found the element `{}`", brief(root.tag_name().name()));
        return Err(Wrong::new(root.range().start..root.range().start, message));
    }
    let named = |name: &'static str| move |node: &Node| node.tag_name().name() == name;
    let graph = root.children().find(named("graph"));
    let graph = graph.ok_or_else(|| Wrong::new(0..text.len(), "expected an element `graph`, found none"))?;
    let is_weight = |key: &Node| key.attribute("attr.name") == Some("weight") && key.attribute("for") != Some("node");
    let weights = root.children().filter(named("key")).find(is_weight);
    let key = weights.and_then(|key| key.attribute("id"));
    let default = weights.and_then(|key| key.children().find(named("default")));
    let default = default.map(|node| weight(node.text().unwrap_or_default().trim(), node.range())).transpose()?;

    let mut nodes = Nodes::default();
    for node in graph.children().filter(named("node")) {
        let id = attribute(node, "id")?;
        if nodes.find(id).is_some() {
            return Err(Wrong::new(node.range(), format!("the node `{}` is there twice", brief(id))));
        }
        nodes.place(id, node.range());
    }
    let one_way = graph.attribute("edgedefault") == Some("directed");
    let numbers = nodes.listed_numbers();
    let mut links = Vec::new();
    let mut one_ways = Vec::new();
    for edge in graph.children().filter(named("edge")) {
        let end = |name: &'static str| {
            let id = attribute(edge, name)?;
            nodes.find(id).map(|place| numbers[place]).ok_or_else(|| {
                let hint = did_you_mean(id, nodes.ids());
                Wrong::new(edge.range(), format!("`{name}`: there is no node `{}`{hint}", brief(id)))
            })
        };
        let data = edge.children().filter(named("data")).find(|data| key.is_some() && data.attribute("key") == key);
        let own = data.map(|data| weight(data.text().unwrap_or_default().trim(), data.range())).transpose()?;
        links.push(FileLink { from: end("source")?, to: end("target")?, weight: own.or(default), span: edge.range() });
        one_ways.push(edge.attribute("directed").map_or(one_way, |value| value == "true"));
    }
    Ok(GraphFile { nodes: Some(nodes.len()), ..oriented(links, &one_ways, one_way) })
}

/// The links as those of a graph that is directed as a whole, or not at all.
fn oriented(links: Vec<FileLink>, one_ways: &[bool], default: bool) -> GraphFile {
    if one_ways.iter().all(|one_way| *one_way == default) {
        return GraphFile { links, directed: Some(default), nodes: None };
    }
    let directed = links.into_iter().zip(one_ways).flat_map(|(link, one_way)| {
        let back = (!one_way).then(|| FileLink { from: link.to, to: link.from, ..link.clone() });
        std::iter::once(link).chain(back)
    });
    GraphFile { links: directed.collect(), directed: Some(true), nodes: None }
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, Wrong> {
    node.attribute(name).ok_or_else(|| {
        let element = node.tag_name().name();
        Wrong::new(node.range(), format!("the element `{element}` has no attribute `{name}`"))
    })
}
