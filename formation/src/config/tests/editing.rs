use super::*;

const BASE: &str = "
dt = 0.1
[controller]
kind = \"toc\"
c_p = 1.5
[parameters]
phase = 0.25
[[agents]]
position = [0, 0, 0]
mass = 1
[[agents]]
position = [1, 0, 0]
";

fn with(path: &str, value: &str) -> Result<Node, Problem> {
    let mut node = parsed(BASE);
    node.set(path, value, &Origin::argument(&format!("--set {path}={value}"))).map(|()| node)
}

fn overlaid(text: &str) -> Result<Node, Problem> {
    let mut node = parsed(BASE);
    node.overlay(parsed(text)).map(|()| node)
}

fn shown(node: &Node, path: &str) -> String {
    node.at(path).map_or("nothing".into(), Node::to_toml)
}

#[test]
fn set_parses_the_value_or_takes_it_as_text() {
    let cases = [
        ("dt", "3", "3"),
        ("dt", " 3.5 ", "3.5"),
        ("dt", "[1, -2, 0]", "[1, -2, 0]"),
        ("dt", "TOC", "\"TOC\""),
        ("dt", "2*pi/3", "\"2*pi/3\""),
        ("dt", "", "\"\""),
        ("dt", "1979-05-27", "\"1979-05-27\""),
        ("dt", "99999999999999999999", "\"99999999999999999999\""),
        ("new.table.x", "true", "true"),
        ("agents.2.position", "[1,2,0]", "[1, 2, 0]"),
        ("agents[2].position[1]", "7", "7"),
        ("new.\"a.b\"", "1", "1"),
    ];
    for (path, value, expected) in cases {
        assert_eq!(shown(&with(path, value).unwrap(), path), expected, "{path}={value}");
    }
}

#[test]
fn set_reaches_all_elements() {
    let node = with("agents.*.mass", "2").unwrap();
    assert_eq!((shown(&node, "agents.1.mass"), shown(&node, "agents.2.mass")), ("2".into(), "2".into()));
}

#[test]
fn set_says_what_does_not_exist() {
    let message = |path: &str| with(path, "1").unwrap_err().to_string();
    assert_eq!(
        message("agents.3.mass"),
        "--set agents.3.mass=1: agents.3: there is no element 3: the list has 2 elements, counted from 1"
    );
    assert!(message("agents.0").contains("there is no element 0"));
    assert!(message("agents.99999999999999999999999").contains("there is no element 99999999999999999999999"));
    assert!(message("agents.first").contains("there is no element first"));
    assert_eq!(message("dt.x"), "--set dt.x=1: dt.x: dt is the number 0.1, which has no fields");
    for malformed in ["", ".", "a..b", "a.", "a[", "a[]", "a[1]b", "a.\"b"] {
        assert!(message(malformed).ends_with("is not a field"), "{malformed}: {}", message(malformed));
    }
    assert!(message(&["a"; 100].join(".")).contains("a path of more than 32 levels"));
}

#[test]
fn another_kind_drops_the_parameters_of_the_file() {
    let mut node = parsed(BASE);
    node.set("controller.k_p", "2", &Origin::argument("--set controller.k_p=2")).unwrap();
    node.set("controller.kind", "toc", &Origin::argument("--set controller.kind=toc")).unwrap();
    assert_eq!(shown(&node, "controller.c_p"), "1.5");
    node.set("controller.kind", "other", &Origin::argument("--set controller.kind=other")).unwrap();
    assert_eq!(shown(&node, "controller"), "kind = \"other\"\nk_p = 2\n");
}

#[test]
fn overlay_merges_tables_and_replaces_the_rest() {
    let node = overlaid("dt = 0.2\n[controller]\nk_p = 2\n[parameters]\nphase = [1, 2]\n[new]\nx = 1\n").unwrap();
    assert_eq!(shown(&node, "dt"), "0.2");
    assert_eq!(shown(&node, "controller"), "kind = \"toc\"\nc_p = 1.5\nk_p = 2\n");
    assert_eq!(shown(&node, "parameters.phase"), "[1, 2]");
    assert_eq!(shown(&node, "new.x"), "1");
}

#[test]
fn overlay_replaces_a_table_of_another_kind() {
    let same = overlaid("controller = { kind = \"toc\", k_p = 2 }").unwrap();
    assert_eq!(shown(&same, "controller"), "kind = \"toc\"\nc_p = 1.5\nk_p = 2\n");
    let other = overlaid("controller = { kind = \"other\", k_p = 2 }").unwrap();
    assert_eq!(shown(&other, "controller"), "kind = \"other\"\nk_p = 2\n");
}

#[test]
fn overlay_reaches_into_lists_by_number() {
    let node = overlaid("[agents.2]\nposition = [9, 9, 9]\nmass = 3\n").unwrap();
    assert_eq!(shown(&node, "agents.1.position"), "[0, 0, 0]");
    assert_eq!(shown(&node, "agents.2"), "position = [9, 9, 9]\nmass = 3\n");
    let problem = overlaid("[agents.3]\nmass = 3\n").unwrap_err().to_string();
    assert!(
        problem.starts_with("a.toml:1:9: agents.3: there is no element 3: the list has 2 elements, counted from 1\n"),
        "{problem}"
    );
    assert_eq!(shown(&overlaid("agents = { count = 3 }").unwrap(), "agents.count"), "3");
}

#[test]
fn leaves_are_found_by_name() {
    let mut node = parsed(BASE);
    assert_eq!(node.find_leaf("phase"), ["parameters.phase"]);
    assert_eq!(node.find_leaf("dt"), ["dt"]);
    assert_eq!(node.find_leaf("position"), ["agents.*.position"]);
    assert_eq!(node.find_leaf("mass"), ["agents.*.mass"]);
    assert!(node.find_leaf("controller").is_empty());
    node.set("controller.phase", "1", &Origin::argument("")).unwrap();
    assert_eq!(node.find_leaf("phase"), ["controller.phase", "parameters.phase"]);
    assert_eq!(node.leaf_names(), ["agents", "c_p", "dt", "kind", "mass", "phase", "position"]);
}

#[test]
fn values_are_found_and_changed_by_path() {
    let mut node = parsed(BASE);
    assert_eq!(node.at("").map(Node::describe), Some("a table".into()));
    assert!(node.at("agents.3").is_none() && node.at("dt.x").is_none() && node.at("a[").is_none());
    node.at_mut("agents.2.position").and_then(Node::as_array_mut).unwrap().truncate(1);
    assert_eq!(shown(&node, "agents[2].position"), "[1]");
    assert_eq!(node.at("dt").and_then(Node::as_f64), Some(0.1));
    assert_eq!(node.at("agents.1.mass").and_then(Node::as_i64), Some(1));
    let table = node.as_table_mut().unwrap();
    assert!(table.remove("dt").is_some() && table.get("dt").is_none() && table.remove("dt").is_none());
}

#[test]
fn written_scenarios_are_readable() {
    let node = parsed(
        "
        title = \"a \\\"b\\\"\\n\"
        small = -0.0
        huge = [inf, nan]
        agents = [{ p = [1, 2.0] }, { p = [3, 4.0], q = {} }]
        [controller.gate]
        kind = \"ramp\"
        ",
    );
    let text = concat!(
        "title = \"a \\\"b\\\"\\n\"\n",
        "small = -0.0\n",
        "huge = [inf, nan]\n",
        "agents = [\n",
        "    { p = [1, 2.0] },\n",
        "    { p = [3, 4.0], q = {} },\n",
        "]\n",
        "\n",
        "[controller]\n",
        "gate = { kind = \"ramp\" }\n",
    );
    assert_eq!(node.to_toml(), text);
}

#[test]
fn the_values_of_an_argument_share_its_text() {
    let text = format!("--set b=[{}]", "1,".repeat(200_000));
    let origin = Origin::argument(&text);
    let Origin::Override { text: shared } = &origin else { panic!("an argument") };
    let list = Node::parse_value(&text["--set b=".len()..], &origin);
    let elements = list.as_array().expect("a list");
    assert_eq!(elements.len(), 200_000);
    let shares =
        |node: &Node| matches!(&node.origin, Origin::Override { text } if std::sync::Arc::ptr_eq(text, shared));
    assert!(elements.iter().chain([&list]).all(shares));
}
