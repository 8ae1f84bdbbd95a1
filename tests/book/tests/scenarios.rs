//! Every scenario that comes with the program is valid for an editor, and mistakes are not.

use book::{complaint, repository, schema};

#[test]
fn every_shipped_scenario_is_valid() {
    let schema = schema();
    let mut count = 0;
    let files = |folder: &str| std::fs::read_dir(repository(folder)).expect("the scenarios").flatten();
    let all = files("scenarios").chain(files("scenarios/literature")).chain(files("examples/own-systems"));
    for entry in all.filter(|entry| entry.path().is_file()) {
        let text = std::fs::read_to_string(entry.path()).expect("a scenario");
        let found = complaint(&schema, &toml::from_str(&text).expect("TOML"));
        assert_eq!(found, None, "{}", entry.path().display());
        count += 1;
    }
    assert!(count >= 25, "{count} scenarios");
}

#[test]
fn what_is_wrong_is_refused() {
    let schema = schema();
    let uav = std::fs::read_to_string(repository("scenarios/uav.toml")).expect("a scenario");
    let mistakes = [
        ("c_p = 2", "c_q = 2"),
        ("c_p = 2", "c_p = true"),
        ("intro = \"logistic\"", "intro = \"sudden\""),
        ("kind = \"hierarchical_uav\"", "kind = \"hierarchical_uva\""),
        ("[timing]", "[timming]"),
        ("dt = 0.01 ", ""),
        ("diff = \"slope\"", "dif = \"slope\""),
        ("{ m = 2.08,", "{ mass = 2.08,"),
        ("x_til = { thesis = \"<= 2e-3\", low", "x_til = { thesis = \"<= 2e-3\", lower"),
        ("metrics = \"uav\"", "metrics = \"uavs\""),
    ];
    for (right, wrong) in mistakes {
        assert!(uav.contains(right), "{right}");
        let changed = uav.replacen(right, wrong, 1);
        assert!(complaint(&schema, &toml::from_str(&changed).expect("TOML")).is_some(), "{wrong} is not refused");
    }
}
