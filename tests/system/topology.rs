//! Communication graphs: from files, over time, and in numbers.

use crate::program::Folder;

/// A scenario of so many robots on a circle, of which the first leads; `graph` is the rest of its section.
fn scenario(agents: usize, graph: &str) -> String {
    let row = |i: usize| format!("    {{ position = [{}, {}, 0], R = 0.1 }},\n", i % 10, i / 10);
    let rows: String = (0..agents).map(row).collect();
    format!(
        "name = \"many\"\nagents = [\n{rows}]\n[timing]\ndt = 0.01\nduration = 1\n[vehicle]\nkind = \"integrator\"\n\
         [reference]\nposition = [\"3*cos(0.2*t + 2*pi*i/N)\", \"3*sin(0.2*t + 2*pi*i/N)\", 0]\n[plant]\nkind = \"vehicles\"\n\
         [planner]\nkind = \"reference\"\n[controller]\nkind = \"consensus\"\nk_x = 1\nk_v = 2\n[topology]\n{graph}\n"
    )
}

/// GraphML as networkx writes it: a ring with some chords, nodes from 0, weights at some edges.
fn graphml(nodes: usize) -> String {
    let node = |i: usize| format!("    <node id=\"{i}\" />\n");
    let plain = |i: usize| format!("    <edge source=\"{i}\" target=\"{}\" />\n", (i + 1) % nodes);
    let chord = |i: usize| {
        let target = (i + nodes / 2) % nodes;
        format!("    <edge source=\"{i}\" target=\"{target}\">\n      <data key=\"d0\">0.5</data>\n    </edge>\n")
    };
    let body: String =
        (0..nodes).map(node).chain((0..nodes).map(plain)).chain((0..nodes / 2).step_by(3).map(chord)).collect();
    format!(
        "<?xml version='1.0' encoding='utf-8'?>\n<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:schemaLocation=\"http://graphml.graphdrawing.org/xmlns \
         http://graphml.graphdrawing.org/xmlns/1.0/graphml.xsd\">\n  <key id=\"d0\" for=\"edge\" attr.name=\"weight\" attr.type=\"double\" />\n  \
         <graph edgedefault=\"undirected\">\n{body}  </graph>\n</graphml>\n"
    )
}

#[test]
fn thirty_agents_from_a_graphml_file() {
    let folder = Folder::new();
    folder.write("g.graphml", &graphml(30));
    folder.write("many.toml", &scenario(30, "graph = { file = \"g.graphml\" }\nleaders = [1, 7]"));
    let equal =
        folder.run(&["verify", "--scenario", "many.toml", "--placements", "all", "--duration", "0.1", "--json"]);
    assert_eq!(equal.code(), 0, "{}{}", equal.stdout(), equal.stderr());
    let run = folder.run(&["run", "many.toml", "--duration", "0.1", "-q", "--placement", "single", "--out", "a.mcap"]);
    assert_eq!(run.code(), 0, "{}", run.stderr());
    // What the log holds is complete without the file of the graph.
    std::fs::remove_file(folder.path("g.graphml")).expect("the file of the graph");
    let again = folder.run(&["replay", "a.mcap", "--only", "controller_3"]);
    assert_eq!(again.code(), 0, "{}{}", again.stdout(), again.stderr());
    let text = folder.run(&["info", "a.mcap", "--scenario"]).stdout();
    assert!(text.contains("links = [") && !text.contains("graphml"), "{text}");
    let refused = folder.run(&["validate", "many.toml"]);
    assert!(refused.stderr().contains("many.toml:"), "{}", refused.stderr());
    assert!(refused.stderr().contains("topology.graph.file: cannot read the graph g.graphml"), "{}", refused.stderr());
}

#[test]
fn a_graph_in_numbers() {
    let folder = Folder::new();
    let switching = "graph = \"two_way_ring\"\nleaders = [2]\nany_graph = true\n[[topology.at]]\nt = 0.5\ngraph = { line = \"directed\" }";
    folder.write("many.toml", &scenario(6, switching));
    let json = folder.run(&["graph", "many.toml", "--topology", "--json"]).json();
    let [first, second] = [&json["graphs"][0], &json["graphs"][1]];
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    assert_eq!((first["links"].as_u64(), first["directed"].as_bool()), (Some(12), Some(false)));
    assert!((number(&first["algebraic_connectivity"]) - 1.0).abs() < 1e-9, "2 - 2 cos(60 degrees)");
    assert!((number(&first["largest_eigenvalue"]) - 4.0).abs() < 1e-9);
    assert_eq!((first["diameter"].as_u64(), first["led"].as_bool()), (Some(3), Some(true)));
    assert_eq!(
        (number(&second["from"]), second["directed"].as_bool(), second["led"].as_bool()),
        (0.5, Some(true), Some(false))
    );
    assert_eq!(
        (second["strongly_connected"].as_bool(), second["weakly_connected"].as_bool()),
        (Some(false), Some(true))
    );
    let text = folder.run(&["graph", "many.toml", "--topology"]).stdout();
    for expected in
        ["from t = 0.5 s", "algebraic connectivity  1\n", "reached by leaders", "not agent 1", "5 links, one way each"]
    {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
}

#[test]
fn a_graph_switches_at_its_time() {
    let folder = Folder::new();
    let digest = |graph: &str, more: &[&str]| {
        folder.write("many.toml", &scenario(4, graph));
        let run = folder.run(&[&["run", "many.toml", "-q", "--out", "a.mcap"][..], more].concat());
        assert_eq!(run.code(), 0, "{}", run.stderr());
        folder.samples("a.mcap")
    };
    let single = ["--placement", "single"];
    let plain = digest("graph = \"ring\"\nleaders = [1]", &single);
    let at = |t: f64| format!("graph = \"ring\"\nleaders = [1]\n[[topology.at]]\nt = {t}\ngraph = \"complete\"");
    assert_eq!(digest(&at(1.5), &single), plain, "a switch behind the end changes nothing");
    let switched = digest(&at(0.5), &single);
    assert_ne!(switched, plain);
    assert_eq!(digest(&at(0.5), &[]), switched, "in processes as in one");
}

#[test]
fn ten_thousand_agents_with_ten_neighbours() {
    let folder = Folder::new();
    let agents = 10_000;
    let links: String =
        (1..=agents).flat_map(|i| (1..=5).map(move |k| format!("{i} {}\n", (i - 1 + k) % agents + 1))).collect();
    folder.write("g.txt", &links);
    folder.write("many.toml", &scenario(agents, "graph = { file = \"g.txt\" }"));
    let valid = folder.run(&["validate", "many.toml", "--json"]);
    assert_eq!(valid.json()["agents"], 10_000, "{}", valid.stderr());
    let text = folder.run(&["graph", "many.toml", "--topology"]).stdout();
    assert!(text.contains("50000 links, both ways") && text.contains("left out for more than 500 agents"), "{text}");
}

#[test]
fn weights_may_be_formulas_of_the_distance() {
    let folder = Folder::new();
    let graph = |weight: &str| {
        let text = scenario(3, &format!("graph = \"line\"\nany_graph = true\nproximity = {{ Rc = 5, {weight} }}"));
        let law = "law.u1 = \"sum(a_ij)\"\nlaw.u2 = 0\nlaw.u3 = 0\nsignals.weight = \"sum(a_ij)\"";
        text.replace("kind = \"consensus\"\nk_x = 1\nk_v = 2", &format!("kind = \"formulas\"\n{law}"))
    };
    folder.write("near.toml", &graph("weight = \"exp(-distance)\""));
    for (placement, log) in [("single", "single.mcap"), ("processes", "processes.mcap")] {
        let end = folder.run(&["run", "near.toml", "--placement", placement, "-q", "--out", log]);
        assert_eq!(end.code(), 0, "{}", end.stderr());
    }
    assert_eq!(folder.samples("single.mcap"), folder.samples("processes.mcap"));
    let log = recording::Log::open(&folder.path("single.mcap")).expect("a log");
    let weight = log.signal("/agent_1/command", "weight").expect("a weight").row(0)[0];
    // A static link to agent 2, and one over a distance of 2 m to agent 3.
    assert!((weight - 1.0 - (-2.0_f64).exp()).abs() < 1e-15, "{weight}");
    for (weight, expected) in [
        ("weight = \"exp(-distanc)\"", "did you mean `distance`?"),
        ("weight = 1, f_max = 2", "topology.proximity.f_max: expected either f_max, f_slope and f_mid or weight"),
        ("f_max = 2", "topology.proximity: missing field `f_slope`, or instead `weight`"),
    ] {
        folder.write("near.toml", &graph(weight));
        let end = folder.run(&["validate", "near.toml"]);
        assert!(end.code() == 2 && end.stderr().contains(expected), "{weight}: {}", end.stderr());
    }
}
