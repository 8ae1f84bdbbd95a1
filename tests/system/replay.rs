//! Recorded runs played again.

use crate::program::{Finished, Folder};

/// Records a run and returns its digest.
fn record(folder: &Folder, scenario: &[&str], more: &[&str]) -> String {
    let run = folder.run(&[&["run"], scenario, &["-q", "--json"], more].concat());
    run.json()["sha256"].as_str().unwrap_or_else(|| panic!("{}", run.stderr())).to_string()
}

/// The names of all participants.
fn nodes(folder: &Folder, scenario: &str) -> Vec<String> {
    let graph = folder.run(&["graph", scenario, "--json"]).json();
    let nodes = graph["nodes"].as_array().expect("a list of nodes").iter();
    nodes.map(|node| node["name"].as_str().expect("a name").to_string()).collect()
}

#[test]
fn a_played_participant_gives_the_same_samples() {
    let folder = Folder::new();
    let schemes: [&[&str]; 4] = [
        &["uav", "--duration", "0.5"],
        &["uav", "--variant", "multirate", "--duration", "0.1"],
        &["cida", "--duration", "0.5"],
        &["mixed", "--duration", "0.5"],
    ];
    for scheme in schemes {
        let original = record(&folder, scheme, &["--placement", "single", "--out", "original.mcap"]);
        let names = nodes(&folder, scheme[0]);
        for live in [None, Some("plant"), Some("controller_3")] {
            // None: one participant is played; else all but this one.
            let played = match live {
                None => vec!["controller.1=replay:original.mcap".to_string()],
                Some(live) => names
                    .iter()
                    .filter(|name| *name != live)
                    .map(|name| format!("{name}=replay:original.mcap"))
                    .collect(),
            };
            let swaps: Vec<&str> = played.iter().flat_map(|swap| ["--swap", swap]).collect();
            let again = record(&folder, scheme, &[&["--out", "again.mcap"], &swaps[..]].concat());
            assert_ne!(again, original, "the log names the programs");
            let verify = folder.run(&["verify", "original.mcap", "again.mcap"]);
            assert_eq!(verify.code(), 0, "{scheme:?}, live: {live:?}: {}", verify.stdout());
            let text = verify.stdout();
            assert!(
                text.contains("bit by bit; only the cast differs: ") && text.contains("by Phalanx itself"),
                "{text}"
            );
        }
    }
}

#[test]
fn a_line_of_the_scenario_swaps_a_participant() {
    let folder = Folder::new();
    let other = record(&folder, &["uav", "--duration", "0.5", "--set", "controller.c_p=3"], &["--out", "other.mcap"]);
    let text = folder.run(&["validate", "uav", "--duration", "0.5", "--print"]).stdout();
    let swapped = |lines: &str| folder.write("swapped.toml", &format!("{text}\n[swap]\n{lines}\n"));
    swapped("");
    let original = record(&folder, &["swapped.toml"], &["--placement", "single", "--out", "original.mcap"]);
    swapped("\"controller.1\" = \"replay:original.mcap\"\nobserver.2 = \"replay:original.mcap\"");
    record(&folder, &["swapped.toml"], &["--out", "a.mcap"]);
    assert_eq!(folder.run(&["verify", "original.mcap", "a.mcap"]).code(), 0);
    // The command line has the last word.
    let swap = ["--out", "b.mcap", "--swap", "controller.1=replay:other.mcap"];
    let mixed = record(&folder, &["swapped.toml"], &swap);
    assert!(mixed != original && mixed != other);

    swapped("\"controler.1\" = \"replay:original.mcap\"\n\"plant\" = 3");
    let wrong = folder.run(&["run", "swapped.toml", "-q"]);
    assert_eq!(wrong.code(), 2);
    assert!(wrong.stderr().contains("plant: expected a command"), "{}", wrong.stderr());
    swapped("\"controler.1\" = \"replay:original.mcap\"");
    let wrong = folder.run(&["run", "swapped.toml", "-q"]);
    assert_eq!(wrong.code(), 2);
    assert!(wrong.stderr().contains("did you mean `controller_1`"), "{}", wrong.stderr());
}

#[test]
fn a_log_that_does_not_fit_is_refused_before_anything_starts() {
    let folder = Folder::new();
    record(&folder, &["uav", "--duration", "0.5"], &["--placement", "single", "--out", "short.mcap"]);
    record(&folder, &["mixed", "--duration", "0.5"], &["--placement", "single", "--out", "mixed.mcap"]);
    let agents = ["uav", "--duration", "0.5", "--set", "agents=[1,3,5]"];
    record(&folder, &agents, &["--placement", "single", "--out", "three.mcap"]);
    folder.write("text.mcap", "not a log");
    let cases: [(&[&str], &str, i32, &str); 7] = [
        (&["--duration", "1"], "controller.1=replay:short.mcap", 2, "run it with --duration 0.5"),
        (&["--duration", "0.5", "--dt", "0.005"], "controller.1=replay:short.mcap", 2, "run it with --dt 0.01"),
        (&["--duration", "0.5"], "plant=replay:mixed.mcap", 2, "is a log of the scenario `mixed`"),
        (&["--duration", "0.5"], "controller.5=replay:three.mcap", 2, "has no topic /agent_5/command"),
        (&["--duration", "0.5"], "controller.1=replay:text.mcap", 4, "is not an MCAP file"),
        (&["--duration", "0.5"], "controller.1=replay:none.mcap", 4, "cannot read log none.mcap"),
        (&["--duration", "0.5", "--out", "./short.mcap"], "plant=replay:short.mcap", 2, "name another file"),
    ];
    for (more, swap, code, expected) in cases {
        let run = folder.run(&[&["run", "uav", "-q", "--swap", swap], more].concat());
        assert!(run.code() == code && run.stderr().contains(expected), "{swap}: {} {}", run.code(), run.stderr());
    }
    assert!(!folder.path("runs").exists(), "nothing was started");
    let info = folder.run(&["info", "short.mcap", "--json"]).json();
    assert_eq!(info["steps"], 51, "it was not touched");
}

#[test]
fn a_torn_log_is_played_up_to_its_end() {
    let folder = Folder::new();
    record(&folder, &["uav", "--duration", "10"], &["--placement", "single", "--out", "whole.mcap"]);
    let whole = std::fs::read(folder.path("whole.mcap")).expect("a log");
    std::fs::write(folder.path("torn.mcap"), &whole[..whole.len() / 2]).expect("a torn log");
    let steps = folder.run(&["info", "torn.mcap", "--json"]).json()["steps"].as_u64().expect("steps");
    let swap = "controller.1=replay:torn.mcap";
    let run = folder.run(&["run", "uav", "--duration", "10", "-q", "--out", "cut.mcap", "--swap", swap]);
    assert_eq!(run.code(), 3);
    let expected = format!("controller_1 at step {steps}: torn.mcap ends with step {}", steps - 1);
    assert!(run.stderr().contains(&expected), "{} lacks {expected}", run.stderr());
    let again = folder.run(&["replay", "torn.mcap", "--only", "plant", "--json"]);
    assert_eq!((again.code(), &again.json()["steps"]), (0, &steps.into()), "{}", again.stderr());

    let mut damaged = whole;
    let middle = damaged.len() / 2;
    damaged[middle] ^= 0x40;
    std::fs::write(folder.path("damaged.mcap"), &damaged).expect("a damaged log");
    let swap = "controller.1=replay:damaged.mcap";
    let run = folder.run(&["run", "uav", "--duration", "10", "-q", "--out", "cut.mcap", "--swap", swap]);
    assert_eq!(run.code(), 3);
    assert!(run.stderr().contains("damaged.mcap is damaged at byte"), "{}", run.stderr());
}

#[test]
fn a_participant_is_run_again_against_the_others() {
    let folder = Folder::new();
    let short = ["uav", "--duration", "1"];
    let original = record(&folder, &short, &["--placement", "single", "--out", "a.mcap"]);
    let replay = |more: &[&str]| folder.run(&[&["replay", "a.mcap", "--only"], more].concat());
    for node in ["controller.3", "observer_2", "plant", "planner"] {
        let same = replay(&[node]);
        assert_eq!(same.code(), 0, "{node}: {}{}", same.stdout(), same.stderr());
        assert!(
            same.stdout().starts_with(&format!("equal: {} gives all ", node.replace('.', "_"))),
            "{}",
            same.stdout()
        );
    }
    let recorded = replay(&["controller.3", "--out", "b.mcap", "--json"]).json();
    assert_ne!(recorded["sha256"], original.as_str(), "scene and assertions are those of a run");
    assert_eq!(folder.run(&["verify", "a.mcap", "b.mcap"]).code(), 0, "every signal is the same");
    assert_eq!(replay(&["controller.3", "--out", "a.mcap"]).code(), 2, "the log would be replaced");

    record(&folder, &["uav", "--duration", "1", "--set", "controller.c_p=2.001"], &["--out", "c.mcap"]);
    let swap = ["controller.3", "--swap", "controller.3=replay:c.mcap"];
    let other = replay(&swap);
    assert_eq!(other.code(), 1);
    let expected =
        "different: controller_3 departs from a.mcap first at step 1 (t = 0.01 s), /agent_3/command input[0]:";
    assert!(other.stdout().starts_with(expected), "{}", other.stdout());
    let json = replay(&[&swap[..], &["--json"]].concat()).json();
    assert_eq!((&json["differing_samples"], &json["samples"]), (&100.into(), &101.into()), "{json}");
    let largest = json["fields"][0]["largest"].as_f64().expect("a number");
    assert!(json["fields"][0]["field"] == "input" && largest > 1e-6, "{json}");
    let loose = format!("{}", largest * 2.0);
    assert_eq!(replay(&[&swap[..], &["--tolerance", &loose]].concat()).code(), 0);
    let wrong: Finished = replay(&["controller.3", "--swap", "controller.4=replay:c.mcap"]);
    assert!(wrong.code() == 2 && wrong.stderr().contains("only controller_3 is run"), "{}", wrong.stderr());
    assert_eq!(replay(&["controler.3"]).code(), 2);
}
