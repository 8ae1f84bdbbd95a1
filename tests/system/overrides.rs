//! Every field at the top of a scenario can be set from the command line, whether its file has the field or not.

use recording::Log;

use crate::program::Folder;

/// Fields at the top that most files leave out, with admissible values.
const FIELDS: &[&str] = &[
    "seed=3",
    "title=another",
    "metrics=",
    "assert=[]",
    "assert=[{name='a', metric='gap', min=-100}]",
    "on_failure=restart",
    "on_failure=hold",
    "ranges={'command.input'={max=1e9}}",
    "any_graph=true",
    "topology.any_graph=true",
];

#[test]
fn a_field_that_the_file_does_not_have_can_be_set() {
    let folder = Folder::new();
    let list = folder.run(&["list", "--json"]).json();
    for scenario in list.as_array().expect("a list") {
        let name = scenario["name"].as_str().expect("a name");
        for field in FIELDS {
            let end = folder.run(&["validate", name, "--set", field]);
            assert_eq!(end.code(), 0, "{name}, {field}: {}", end.stderr());
        }
        let end = folder.run(&["validate", name, "--seed", "5"]);
        assert_eq!(end.code(), 0, "{name}: {}", end.stderr());
    }
}

#[test]
fn a_field_that_no_scenario_has_is_refused() {
    let folder = Folder::new();
    for (field, hint) in [("sed=3", "`seed`"), ("timing.dtt=1", "timing.dtt: unknown field"), ("asert=[]", "`assert`")]
    {
        let end = folder.run(&["validate", "triangle", "--set", field]);
        assert!(end.code() == 2 && end.stderr().contains(hint), "{field}: {}", end.stderr());
    }
}

const TRIANGLE: &str = include_str!("../../scenarios/triangle.toml");

/// Variants of the triangle with tables that the triangle itself does not have.
const VARIANTS: &str = r#"
[variants.bare]
title = "nothing more"

[variants.full]
title = "more tables"
parameters = { own = 1 }
topology.proximity = { enabled = true, Rc = 1.5, f_max = 0.2, f_slope = 14, f_mid = 1.1 }
"#;

/// A field, a scenario, a variant that has it, and one that does not, if there is one.
const CONDITIONAL: &[(&str, &str, &str, Option<&str>)] = &[
    ("observer.gamma=[7, 7, 7]", "cida", "AOBFC", Some("RCTFC")),
    ("gamma=[7, 7, 7]", "cida", "AOBFC", Some("RCTFC")),
    ("controller.limit_estimate=false", "cida", "RCTFC", Some("OBFC")),
    ("controller.kind=observer_formation", "cida", "OBFC", None),
    ("controller.k=7", "cida", "RCTFC", None),
    ("controller.position_every=7", "uav", "TSC", None),
    ("observer.beta_w=7", "dsm-ftdo", "FTDO-DSM", Some("DSM-SW")),
    ("parameters.own=7", "table.toml", "full", Some("bare")),
    ("topology.proximity.Rc=7", "table.toml", "full", Some("bare")),
    ("agents.2.R=7", "table.toml", "bare", None),
    ("Rhat=[1, 1, 7]", "table.toml", "bare", None),
    ("T=7", "table.toml", "bare", None),
];

#[test]
fn a_field_that_only_some_variants_have_is_set_where_it_is() {
    let folder = Folder::new();
    folder.write("table.toml", &format!("{TRIANGLE}{VARIANTS}"));
    for &(field, scenario, with, without) in CONDITIONAL {
        let print = |variant: &str, change: &[&str]| {
            let end = folder.run(&[&["validate", scenario, "--print", "--variant", variant], change].concat());
            assert_eq!(end.code(), 0, "{field}, {variant}: {}", end.stderr());
            end.stdout()
        };
        let changed = print(with, &["--set-if-present", field]);
        assert_eq!(changed, print(with, &["--set", field]), "{field}");
        if let Some(without) = without {
            assert_ne!(changed, print(with, &[]), "{field}");
            assert_eq!(print(without, &["--set-if-present", field]), print(without, &[]), "{field}");
        }
    }
}

#[test]
fn a_field_that_no_variant_has_is_refused_in_every_variant() {
    let folder = Folder::new();
    folder.write("table.toml", &format!("{TRIANGLE}{VARIANTS}"));
    for (field, scenario, variants) in [
        ("observer.gama=7", "cida", &["AOBFC", "RCTFC"][..]),
        ("controller.typo=7", "cida", &["OBFC", "CTFC"]),
        ("typo=7", "cida", &["AOBFC"]),
        ("parameters.owm=7", "table.toml", &["bare", "full"]),
        ("topology.proximity.Rd=7", "table.toml", &["bare", "full"]),
        ("observer.eta=7", "table.toml", &["bare", "full"]),
        ("agents.4.R=7", "table.toml", &["bare"]),
        ("agents.2.RR=7", "table.toml", &["bare"]),
    ] {
        for variant in variants {
            let end = folder.run(&["validate", scenario, "--variant", variant, "--set-if-present", field]);
            let stderr = end.stderr();
            assert_eq!(end.code(), 2, "{field}, {variant}");
            for part in [&format!("--set-if-present {field}: "), "no variant of this scenario has this field"] {
                assert!(stderr.contains(part), "{field}, {variant}: {part} is not in {stderr}");
            }
        }
    }
    // A field that is there is checked by every command.
    for command in [&["run", "uav"][..], &["graph", "uav"], &["verify", "--scenario", "uav"], &["profile", "uav"]] {
        let end = folder.run(&[command, &["--set-if-present", "controller.c_p=-3"]].concat());
        assert!(end.code() == 2 && end.stderr().contains("expected a number > 0, found -3"), "{}", end.stderr());
    }
    let change = ["--set-if-present", "vehicle.UM=-3"];
    let conform = [&["conform", "controller.1", "--scenario", "uav"], &change[..], &["--", "true"]].concat();
    let robot = [&["robot", "--scenario", "compensated", "--agent", "1"], &change[..]].concat();
    for command in [conform, robot] {
        let end = folder.run(&command);
        assert!(end.code() == 2 && end.stderr().contains("> 0, found -3"), "{}", end.stderr());
    }
}

#[test]
fn a_log_names_the_overrides_that_were_typed_and_no_others() {
    let folder = Folder::new();
    let short = ["run", "compensated", "--duration", "0.2", "-q", "--out", "a.mcap", "--realtime"];
    // One plant per agent is a decision of the run, not an override.
    let changes = ["--swap", "plant.2=emulator", "--set-if-present", "controller.ke=2"];
    let end = folder.run(&[&short[..], &changes, &["--set-if-present", "observer.kind=adaptive"]].concat());
    assert!(end.code() <= 1, "{}", end.stderr());
    let log = Log::open(&folder.path("a.mcap")).expect("a log");
    let overrides = &log.metadata().expect("metadata")["overrides"];
    assert_eq!(overrides, "timing.duration=0.2\ncontroller.ke=2\nobserver.kind=adaptive");
    assert!(log.scenario_text().expect("a scenario").contains("per_agent = true"));
}
