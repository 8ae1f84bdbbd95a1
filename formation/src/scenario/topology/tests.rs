use std::fs;
use std::path::{Path, PathBuf};

use crate::math::{Link, Topology};
use crate::scenario::{Scenario, Selection};

/// A scenario of `agents` agents with this section; `topology` may be empty.
fn text(agents: usize, topology: &str) -> String {
    let agents = "{ position = [0, 0, 0] }, ".repeat(agents);
    format!(
        "name = \"g\"\nseed = 5\nagents = [{agents}]\ntiming = {{ dt = 0.1, duration = 1 }}\nvehicle = {{ kind = \"integrator\" }}\n\
         reference = {{ position = [0, 0, 0] }}\n{topology}\n"
    )
}

fn load(agents: usize, topology: &str) -> Topology {
    let loaded = Scenario::load("g.toml", &text(agents, topology), &Selection::default());
    loaded.unwrap_or_else(|problems| panic!("{topology}: {problems:?}")).context.topology.first().clone()
}

fn refusal(agents: usize, topology: &str) -> String {
    refusal_of(Path::new("g.toml"), agents, topology)
}

fn refusal_of(file: &Path, agents: usize, topology: &str) -> String {
    let file = file.to_str().unwrap();
    let problems = Scenario::load(file, &text(agents, topology), &Selection::default()).unwrap_err();
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// A folder for files of graphs, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("phalanx-graph-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn with(self, name: &str, text: &str) -> Self {
        fs::write(self.0.join(name), text).unwrap();
        self
    }

    fn scenario(&self) -> PathBuf {
        self.0.join("g.toml")
    }

    fn load(&self, agents: usize, graph: &str) -> Scenario {
        self.load_with(agents, graph, &[])
    }

    fn load_with(&self, agents: usize, graph: &str, overrides: &[&str]) -> Scenario {
        let selection =
            Selection { overrides: overrides.iter().map(|o| o.to_string()).collect(), ..Selection::default() };
        let text = text(agents, &format!("topology = {{ graph = {graph} }}"));
        Scenario::load(self.scenario().to_str().unwrap(), &text, &selection).unwrap()
    }

    fn refusal(&self, agents: usize, graph: &str) -> String {
        let found = refusal_of(&self.scenario(), agents, &format!("topology = {{ graph = {graph} }}"));
        found.replace(&format!("{}/", self.0.display()), "")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn links(graph: &Topology) -> Vec<(usize, usize, f64)> {
    graph.links().map(|Link { from, to, weight }| (from + 1, to + 1, weight)).collect()
}

#[test]
fn graphs_by_name() {
    let section = |graph: &str| format!("topology = {{ graph = {graph} }}");
    assert_eq!(load(4, &section("\"ring\"")), load(4, "topology = { A = \"ring\", b = 1 }"));
    assert_eq!(load(4, &section("{ ring = \"undirected\" }")), load(4, &section("\"two_way_ring\"")));
    assert_eq!(links(&load(3, &section("{ line = \"directed\", weight = 0.5 }"))), [(1, 2, 0.5), (2, 3, 0.5)]);
    assert_eq!(links(&load(3, &section("{ star = 2, directed = true }"))), [(2, 1, 1.0), (2, 3, 1.0)]);
    assert_eq!(load(6, &section("{ grid = [2, 3] }")), load(6, &section("\"grid\"")));
    assert_eq!(load(4, &section("{ complete = true }")).links().count(), 12);
    let random = |options: &str| load(9, &section(&format!("{{ random = 0.5{options} }}")));
    assert_eq!(random(""), random(", seed = 5"));
    assert_ne!(random(""), random(", seed = 6"));
    assert_eq!(random(", connected = true").unreachable_pair(), None);
}

#[test]
fn leaders_and_the_default() {
    let b = |graph: &Topology| (0..graph.size()).map(|i| graph.b(i)).collect::<Vec<_>>();
    assert_eq!(b(&load(3, "topology = { leaders = [1, 3] }")), [1.0, 0.0, 1.0]);
    assert_eq!(b(&load(3, "topology = { graph = \"line\" }")), [1.0; 3]);
    let without = load(3, "");
    assert_eq!((b(&without), without.links().count()), (vec![1.0; 3], 0));
    let refused = refusal(3, "topology = { leaders = [1, 4] }");
    assert!(refused.contains("topology.leaders.2: expected numbers of agents from 1 to 3, found 4"), "{refused}");
    assert!(
        refusal(3, "topology = { leaders = [1], b = 1 }")
            .contains("expected only one of topology.b and topology.leaders")
    );
}

#[test]
fn links_as_a_list() {
    let graph = load(3, "topology = { graph = { links = [[1, 2], [3, 2, 0.5]], weight = 2, directed = true } }");
    assert_eq!(links(&graph), [(1, 2, 2.0), (3, 2, 0.5)]);
    let graph = load(3, "topology = { graph = { links = [[1, 2], [2, 1]] } }");
    assert_eq!(links(&graph), [(2, 1, 1.0), (1, 2, 1.0)]);
}

#[test]
fn mistakes_have_a_place_and_an_expectation() {
    let refuse = |graph: &str| refusal(3, &format!("[topology]\ngraph = {graph}"));
    for (graph, expected) in [
        (
            "\"rnig\"",
            "g.toml:8:9: topology.graph: no graph is called \"rnig\", expected one of ring, two_way_ring, line",
        ),
        ("\"rnig\"", "did you mean `ring`?"),
        (
            "3",
            "topology.graph: expected the name of a graph (ring, two_way_ring, line, star, complete, grid) or a table",
        ),
        ("{ rign = \"directed\" }", "topology.graph.rign: unknown field"),
        ("{ ring = \"diercted\" }", "did you mean `directed`?"),
        (
            "{ seed = 1 }",
            "topology.graph: expected one of ring, line, star, complete, grid, random, links, file, found none",
        ),
        ("{ star = 1, line = \"directed\" }", "found `line` and `star`"),
        ("{ star = 4 }", "topology.graph.star: expected a centre from 1 to 3, found 4"),
        ("{ star = 0 }", "topology.graph.star: expected a centre from 1 to 3, found"),
        ("{ grid = [2, 2] }", "topology.graph.grid: expected rows and columns whose product is 3"),
        ("{ grid = [3] }", "topology.graph.grid: expected 2 values, found 1"),
        ("{ random = 2 }", "topology.graph.random: expected a probability from 0 to 1, found 2"),
        ("{ line = \"directed\", seed = 1 }", "topology.graph.seed: only a `random` graph has `seed`"),
        ("{ line = \"directed\", directed = true }", "topology.graph.directed: write line = \"directed\""),
        ("{ complete = true, weight = 0 }", "topology.graph.weight: expected a weight > 0, found 0"),
        ("{ links = 3 }", "topology.graph.links: expected a list of links"),
        ("{ links = [[1, 2], [1, 5]] }", "topology.graph.links.2: expected agents from 1 to 3, found 5"),
        ("{ links = [[0, 2]] }", "topology.graph.links.1: expected agents from 1 to 3, found 0"),
        ("{ links = [[1, 1]] }", "an agent is not its own neighbour"),
        ("{ links = [[1, 2, -1]] }", "topology.graph.links.1: a weight is a number >= 0, found -1"),
        ("{ links = [[1.5, 2]] }", "expected [from, to] or [from, to, weight], with whole numbers of agents"),
        ("{ links = [[1, 2, 1], [2, 1, 3]] }", "the link from 2 to 1 is given twice, with the weights 1 and 3"),
        ("\"ring\"\nA = \"ring\"", "expected only one of topology.A and topology.graph"),
    ] {
        let found = refuse(graph);
        assert!(found.contains(expected), "{graph}\n{found}");
    }
}

#[test]
fn files_become_links_of_the_scenario() {
    let graphml = "<?xml version='1.0' encoding='utf-8'?>\n<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\
        <key id=\"d0\" for=\"edge\" attr.name=\"weight\" attr.type=\"double\" />\n<graph edgedefault=\"undirected\">\
        <node id=\"0\" />\n<node id=\"1\" /><node id=\"2\" />\n<edge source=\"0\" target=\"2\"><data key=\"d0\">0.5</data></edge>\n\
        <edge source=\"1\" target=\"2\" />\n</graph></graphml>";
    let folder = Folder::new("files")
        .with("g.graphml", graphml)
        .with(
            "directed.xml",
            &graphml
                .replace("undirected", "directed")
                .replace("id=\"0\"", "id=\"a\"")
                .replace("source=\"0\"", "source=\"a\""),
        )
        .with("list.txt", "# three agents\n1 3 0.5\n\n2 3 # no weight\n")
        .with("networkx.edgelist", "0 2 {'weight': 0.5}\n1 2 {}\n")
        .with("names.txt", "ant cow 0.5\nbee cow\n")
        .with("links.csv", "from,to,weight\n1,3,0.5\n2,3,\n")
        .with("matrix.csv", "0,0,0.5\n0,0,1\n0.5,1,0\n");
    let expected = [(3, 1, 0.5), (3, 2, 1.0), (1, 3, 0.5), (2, 3, 1.0)];
    for file in ["g.graphml", "list.txt", "networkx.edgelist", "links.csv", "matrix.csv"] {
        let scenario = folder.load(3, &format!("{{ file = \"{file}\" }}"));
        assert_eq!(links(scenario.context.topology.first()), expected, "{file}");
        // The effective scenario stands for itself, wherever it is read.
        let again = Scenario::load("elsewhere.toml", &scenario.to_toml(), &Selection::default()).unwrap();
        assert_eq!(again.context.topology, scenario.context.topology, "{file}");
        assert!(!scenario.to_toml().contains(file));
    }
    for (file, options) in [("directed.xml", ""), ("list.txt", ", directed = true")] {
        let graph = folder.load(3, &format!("{{ file = \"{file}\"{options} }}")).context.topology.first().clone();
        assert_eq!(links(&graph), expected[2..], "{file}");
    }
    // Names are numbered as they appear: ant, cow, bee.
    let graph = folder.load(3, "{ file = \"names.txt\" }").context.topology.first().clone();
    assert_eq!(links(&graph), [(2, 1, 0.5), (1, 2, 0.5), (3, 2, 1.0), (2, 3, 1.0)]);
}

#[test]
fn some_agents_of_a_file() {
    let folder = Folder::new("choice").with("g.txt", "1 2\n2 3\n3 4 0.5\n");
    let chosen = folder.load_with(4, "{ file = \"g.txt\" }, leaders = [2, 4]", &["agents=[4,3]"]).context;
    assert_eq!(links(chosen.topology.first()), [(2, 1, 0.5), (1, 2, 0.5)]);
    assert_eq!((chosen.topology.first().b(0), chosen.topology.first().b(1), chosen.any_graph), (1.0, 0.0, true));
    let fewer = folder.load_with(4, "{ file = \"g.txt\" }", &["N=2"]).context;
    assert_eq!(links(fewer.topology.first()), [(2, 1, 1.0), (1, 2, 1.0)]);
    let other = folder.load_with(4, "{ file = \"missing.txt\" }", &["graph=line"]).context;
    assert_eq!(other.topology.first().links().count(), 6);
}

#[test]
fn mistakes_in_files_have_their_line() {
    let xml = |inner: &str| {
        format!(
            "<graphml>\n<graph edgedefault=\"directed\">\n<node id=\"a\"/>\n<node id=\"b\"/>\n{inner}\n</graph>\n</graphml>"
        )
    };
    let folder = Folder::new("mistakes")
        .with("word.txt", "1 2\n2 three\n")
        .with("short.txt", "1 2\n2\n")
        .with("long.txt", "1 2 0.5 7\n")
        .with("weight.txt", "1 2 heavy\n")
        .with("far.txt", "1 2\n2 3\n")
        .with("header.csv", "form,to\n1,2\n")
        .with("row.csv", "0,1\n1\n")
        .with("self.csv", "1,1\n1,0\n")
        .with("empty.csv", "")
        .with("edge.graphml", &xml("<edge source=\"a\" target=\"c\"/>"))
        .with("none.graphml", &xml("<edge source=\"a\"/>"))
        .with("broken.graphml", &xml("<edge source=\"a\">"))
        .with("three.graphml", &xml("<node id=\"c\"/>"))
        .with("other.xml", "<svg/>");
    for (file, expected) in [
        ("word.txt", "word.txt:2:3: expected the number of an agent, as elsewhere in the file, found `three`"),
        ("short.txt", "short.txt:2:1: expected `from to [weight]`, found `2`"),
        ("long.txt", "long.txt:1:9: expected the end of the line after `from to weight`, found `7`"),
        ("weight.txt", "weight.txt:1:5: expected a weight >= 0, found `heavy`"),
        ("far.txt", "far.txt:2:1: topology.graph.links.2: expected agents from 1 to 2, found 3"),
        ("header.csv", "header.csv:1:1: the header has no column `from`; did you mean `form`?"),
        ("row.csv", "row.csv:2:1: expected 2 numbers, one for each line of the matrix, found 1"),
        ("self.csv", "self.csv:1:1: column 1: an agent is not its own neighbour, expected 0, found 1"),
        ("empty.csv", "found an empty file"),
        ("edge.graphml", "edge.graphml:5:1: `target`: there is no node `c`"),
        ("none.graphml", "edge` has no attribute `target`"),
        ("broken.graphml", "broken.graphml:6:"),
        ("three.graphml", "topology.graph.file: the graph has 3 nodes, and the scenario has 2 agents"),
        ("other.xml", "expected GraphML, found the element `svg`"),
        (
            "wrod.txt",
            "cannot read the graph wrod.txt: No such file or directory (os error 2); did you mean `word.txt`?",
        ),
    ] {
        let found = folder.refusal(2, &format!("{{ file = \"{file}\" }}"));
        assert!(found.contains(expected), "{file}\n{found}");
    }
    let found = folder.refusal(2, "{ file = \"row.csv\", star = 1 }");
    assert!(found.contains("found `star` and `file`"), "{found}");
    let found = folder.refusal(3, "{ file = \"three.graphml\", directed = true }");
    assert!(found.contains("three.graphml says itself whether its links are directed"), "{found}");
}

#[test]
fn switches_over_time() {
    let topology = "[topology]\ngraph = \"line\"\nleaders = [1]\n[[topology.at]]\nt = 0.3\ngraph = { links = [[3, 1]], directed = true }\n\
                    [[topology.at]]\nt = 0.55\nleaders = [2]";
    let loaded = Scenario::load("g.toml", &text(3, topology), &Selection::default()).unwrap();
    let schedule = &loaded.context.topology;
    let starts: Vec<u64> = schedule.intervals().iter().map(|(start, _)| *start).collect();
    assert_eq!(starts, [0, 3, 6]);
    assert_eq!(links(schedule.at(2)), [(2, 1, 1.0), (1, 2, 1.0), (3, 2, 1.0), (2, 3, 1.0)]);
    assert_eq!((links(schedule.at(3)), schedule.at(3).b(0)), (vec![(3, 1, 1.0)], 1.0));
    assert_eq!((links(schedule.at(9)), schedule.at(9).b(0), schedule.at(9).b(1)), (vec![(3, 1, 1.0)], 0.0, 1.0));
    let again = Scenario::load("h.toml", &loaded.to_toml(), &Selection::default()).unwrap();
    assert_eq!(again.context.topology, *schedule);
    let graphs = loaded.graphs();
    assert_eq!((graphs.len(), graphs[1].0), (3, 3));
    for (switches, expected) in [
        ("at = [{ t = 0, graph = \"line\" }]", "topology.at.1.t: expected a time > 0 s, in ascending order, found 0"),
        ("at = [{ t = 2, graph = \"line\" }, { t = 1, graph = \"ring\" }]", "topology.at.2.t: expected a time > 2 s"),
        ("at = [{ t = 0.31, graph = \"line\" }, { t = 0.32, graph = \"ring\" }]", "found both at step 4"),
        ("at = [{ t = 1 }]", "topology.at.1: expected another graph or other leaders: A, graph, b or leaders"),
        ("at = [{ t = 1, graph = \"rnig\" }]", "topology.at.1.graph: no graph is called \"rnig\""),
        ("at = [{ t = 1, grpah = \"ring\" }]", "did you mean `graph`?"),
        ("at = [{ t = 1, leaders = [4] }]", "topology.at.1.leaders.1: expected numbers of agents from 1 to 3, found 4"),
        ("at = [{ t = 1, A = [[0]] }]", "topology.at.1.A: expected 3 rows"),
    ] {
        let found = refusal(3, &format!("[topology]\n{switches}"));
        assert!(found.contains(expected), "{switches}\n{found}");
    }
}
