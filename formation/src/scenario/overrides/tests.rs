use std::sync::Arc;

use super::*;
use crate::config::Source;

const TEXT: &str = r#"
agents = [
    { m = 1.0, position = [0, 0, 0] },
    { m = 2.0, position = [1, 0, 0] },
    { m = 3.0, position = [2, 0, 0] },
]

[topology]
A = [[0, 1, 1], [1, 0, 0], [0, 1, 0]]
b = 2
"#;

fn applied(overrides: &[&str]) -> Result<Node, String> {
    let source = Arc::new(Source { name: "test.toml".into(), text: TEXT.into() });
    let mut root = Node::parse(source).map_err(|problem| problem.to_string())?;
    let parsed: Result<Vec<Override>, Problem> = overrides.iter().map(|text| Override::parse(text)).collect();
    let parsed = parsed.map_err(|problem| problem.to_string())?;
    apply(&mut root, &parsed).map_err(|problem| problem.to_string())?;
    Ok(root)
}

fn masses(root: &Node) -> Vec<f64> {
    let agents = root.at("agents").and_then(Node::as_array).unwrap();
    agents.iter().map(|agent| agent.at("m").and_then(Node::as_f64).unwrap()).collect()
}

#[test]
fn fewer_agents_are_the_first_ones_with_their_links() {
    let root = applied(&["N=2"]).unwrap();
    assert_eq!(masses(&root), [1.0, 2.0]);
    assert_eq!(root.at("topology.A.1.2").and_then(Node::as_f64), Some(1.0));
    assert_eq!(root.at("topology.A").and_then(Node::as_array).unwrap().len(), 2);
}

#[test]
fn more_agents_are_copies_on_a_ring() {
    let root = applied(&["N=5"]).unwrap();
    assert_eq!(masses(&root), [1.0, 2.0, 3.0, 1.0, 2.0]);
    assert!(root.at("topology.A").is_none(), "without a matrix the graph is a ring");
    let root = applied(&["m=[4, 5, 6, 7]", "N=4"]).unwrap();
    assert_eq!(masses(&root), [4.0, 5.0, 6.0, 7.0]);
}

#[test]
fn numbers_of_agents_that_contradict_each_other_are_refused() {
    let refusal = |overrides: &[&str]| applied(overrides).unwrap_err();
    assert!(
        refusal(&["N=2", "x0=[[0,0,0],[1,1,1],[2,2,2]]"])
            .contains("position: expected 2 values, one per agent, found 3")
    );
    assert!(refusal(&["N=3", "x0=[[0,0,0],[1,1,1]]"]).contains("expected 3 values, one per agent, found 2"));
    assert!(refusal(&["agents=[1,3]", "x0=[[0,0,0]]"]).contains("expected 2 values, one per agent, found 1"));
    assert!(refusal(&["agents=[1,3]", "v0=[[0,0,0]]"]).contains("velocity: expected 2 values, one per agent, found 1"));
    assert!(refusal(&["agents=[1,3]", "N=3"]).contains("expected N = 2"));
    assert!(refusal(&["x0=[[0,0,0],[1,1,1]]", "v0=[[0,0,0]]"]).contains("expected 2 values"));
    assert!(refusal(&["x0=[[0,0,0],[1,1,1]]", "m=[1,2,3]"]).contains("expected 2 values"));
    assert!(refusal(&["N=none"]).contains("from 1 to 1000"));
}
