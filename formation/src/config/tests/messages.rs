use serde::Deserialize;

use super::*;

#[derive(Debug, Deserialize)]
#[allow(dead_code)]
struct Gains {
    lam_p: f64,
    c_p: f64,
    k_p: f64,
}

#[derive(Debug, Deserialize)]
#[allow(dead_code)]
struct Scenario {
    dt: f64,
    controller: Gains,
}

#[test]
fn an_unknown_field_is_shown_with_the_nearest_name() {
    let problems = problems_of::<Scenario>("dt = 0.1\n[controller]\nlam_p = 1\nc_p = 1\nk_p = 1\nc_q = 2 # oops\n");
    assert_eq!(
        problems[0].to_string(),
        concat!(
            "a.toml:6:1: controller.c_q: unknown field\n",
            "   |\n",
            " 6 | c_q = 2 # oops\n",
            "   | ^^^\n",
            "   = expected one of lam_p, c_p, k_p; did you mean `c_p`?",
        )
    );
    assert_eq!(problems.len(), 1);
}

#[test]
fn a_missing_field_points_to_the_header_of_its_table() {
    let problems = problems_of::<Scenario>("dt = 0.1\n\n[controller]\nlam_p = 1\nk_p = 1\n");
    let expected = "a.toml:3:1: controller: missing field `c_p`\n   |\n 3 | [controller]\n   | ^^^^^^^^^^^^";
    assert_eq!(problems[0].to_string(), expected);
}

#[test]
fn a_field_missing_from_the_file_has_no_line() {
    let problems = problems_of::<Scenario>("controller = { lam_p = 1, c_p = 1, k_p = 1 }");
    assert_eq!(problems[0].to_string(), "a.toml: missing field `dt`");
}

#[test]
fn a_wrong_type_is_named() {
    let text = "dt = true\ncontroller = { lam_p = \"two\", c_p = [1], k_p = 1 }";
    let problems = problems_of::<Scenario>(text);
    assert_eq!(
        problems[1].to_string(),
        concat!(
            "a.toml:2:24: controller.lam_p: expected a number, found the string \"two\"\n",
            "   |\n",
            " 2 | controller = { lam_p = \"two\", c_p = [1], k_p = 1 }\n",
            "   |                        ^^^^^\n",
            "   = as a formula: expected a constant, found the name 'two'",
        )
    );
    assert_eq!(problems[0].message, "expected a number, found the boolean true");
    assert_eq!(problems[2].message, "expected a number, found a list of 1 value");
}

#[test]
fn an_override_is_named_instead_of_a_line() {
    let mut node = parsed("dt = 0.1\n[controller]\nlam_p = 1\nc_p = 1\nk_p = 1\n");
    for (path, value) in [("controller.c_q", "3"), ("controller.c_p", "[1]")] {
        node.set(path, value, &Origin::argument(&format!("--set {path}={value}"))).unwrap();
    }
    let mut problems = Problems::default();
    assert!(read::<Scenario>(&node, "", &mut problems).is_none());
    assert_eq!(
        problems.to_string(),
        concat!(
            "--set controller.c_p=[1]: controller.c_p: expected a number, found a list of 1 value\n\n",
            "--set controller.c_q=3: controller.c_q: unknown field\n",
            " = expected one of lam_p, c_p, k_p; did you mean `c_p`?",
        )
    );
}

#[test]
fn columns_are_characters_and_tabs_stay() {
    let text = "dt = 1\ncontroller = { lam_p = 1, c_p = 1,\tk_p = 1, \"\u{e4}\u{f6}\u{fc}\" = 1, \"b\" = 1 }\r\n";
    let shown: Vec<String> = problems_of::<Scenario>(text).iter().map(Problem::to_string).collect();
    assert!(shown[0].starts_with("a.toml:2:45: controller.\"äöü\": unknown field\n"), "{}", shown[0]);
    assert!(shown[1].starts_with("a.toml:2:56: controller.b: unknown field\n"), "{}", shown[1]);
    let marks = format!("\n   | {}\t{}^^^^^\n", " ".repeat(34), " ".repeat(9));
    assert!(shown[0].contains(&marks), "{}", shown[0]);
    assert!(!shown[0].contains('\r'));
}

#[test]
fn syntax_errors_have_a_place() {
    let expected = "a.toml:2:1: not valid TOML: duplicate key\n   |\n 2 | a = 2\n   | ^";
    assert_eq!(refused("a = 1\na = 2\n"), expected);
    assert!(refused("a = \"x").starts_with("a.toml:1:7: not valid TOML: "), "{}", refused("a = \"x"));
    assert!(refused("a = ").starts_with("a.toml:1:5: not valid TOML: "));
}

#[test]
fn what_a_scenario_cannot_hold_is_refused() {
    let day = refused("[a]\nb = [1, 1979-05-27]");
    assert!(day.starts_with("a.toml:2:9: a.b.2: dates and times have no use in a scenario"), "{day}");
    assert!(
        refused("a = 9223372036854775808").contains("a: the integer 9223372036854775808 does not fit into 64 bits")
    );
    assert!(refused("a = 1e999").contains("a: the number 1e999 is out of range"));
    assert_eq!(refused(&" ".repeat(5 << 20)), "a.toml: a scenario of 5.0 MB; at most 4 MB are read");
}

#[test]
fn deep_nesting_is_refused_without_exhausting_the_stack() {
    assert!(Node::parse(source(&format!("a = {}{}", "[".repeat(32), "]".repeat(32)))).is_ok());
    assert!(refused(&format!("a = {}{}", "[".repeat(33), "]".repeat(33))).contains("nested more than 32 levels deep"));
    // As deep as the parser lets it be, with and without an error behind it.
    let key = ["a"; 79].join(".");
    let deep = format!("x = {}1{}", format!("{{ {key} = ").repeat(78), " }".repeat(78));
    assert!(refused(&deep).contains("nested more than 32 levels deep"));
    assert!(refused(&(deep + " x")).contains("not valid TOML"));
    assert!(refused(&format!("a = {}", "[".repeat(1 << 20))).contains("not valid TOML"));
}

#[test]
fn terminals_are_safe_and_long_lines_are_left_out() {
    assert!(!refused("a = \u{1b}[31m").contains('\u{1b}'));
    let long = refused(&format!("a = \"{}\" 1", "x".repeat(1000)));
    assert_eq!(long.lines().count(), 1);
}

#[test]
fn problems_of_callers_get_the_closest_origin() {
    let node = parsed("[[agents]]\nposition = [1, 2]\n[[agents]]\nposition = [3, 4]\n");
    let mut problems = Problems::default();
    problems.at(&node, "agents.2.position", "too far").help = Some("stay within 3 m".into());
    problems.at(&node, "agents.2.mass", "not given");
    problems.at(&node, "plant", "not given");
    let shown: Vec<String> = problems.iter().map(Problem::to_string).collect();
    let hint = "   |            ^^^^^^\n   = stay within 3 m";
    assert!(shown[0].starts_with("a.toml:4:12: agents.2.position: too far\n") && shown[0].ends_with(hint));
    assert!(shown[1].starts_with("a.toml:3:1: agents.2.mass: not given\n"));
    assert_eq!(shown[2], "a.toml: plant: not given");
}
