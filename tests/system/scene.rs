//! What a log shows besides its signals, and layouts for viewers.

use crate::program::Folder;
use crate::readers::scene_of;

#[test]
fn a_log_without_its_scene_has_the_same_signals() {
    let folder = Folder::new();
    let run = ["run", "rca", "--duration", "1", "--set", "assert=[]", "-q", "--placement", "single", "--out"];
    folder.run(&[&run[..], &["full.mcap"]].concat());
    folder.run(&[&run[..], &["plain.mcap", "--no-scene"]].concat());
    let topics = |log: &str| -> Vec<String> {
        let info = folder.run(&["info", log, "--json"]).json();
        let channels = info["channels"].as_array().expect("channels").iter();
        channels.map(|channel| channel["topic"].as_str().expect("a topic").to_string()).collect()
    };
    let (full, plain) = (topics("full.mcap"), topics("plain.mcap"));
    assert!(plain.iter().all(|topic| topic.starts_with("/agent_")), "{plain:?}");
    assert_eq!(full[..plain.len()], plain);
    let scene = ["/tf", "/scene/bodies", "/scene/obstacles", "/scene/links", "/scene/trails", "/scene/poses"];
    assert_eq!(full[plain.len()..full.len() - 2], scene);
    let verified = folder.run(&["verify", "full.mcap", "plain.mcap"]);
    assert_eq!(verified.code(), 0, "{}", verified.stdout());
    // What reads signals finds nothing else.
    folder.run(&["export", "full.mcap", "--every", "100", "--out", "csv"]);
    let tables = std::fs::read_dir(folder.path("csv")).expect("a folder with tables").count();
    assert_eq!(tables, plain.len());
    assert_eq!(folder.run(&["report", "full.mcap"]).code(), 0);
}

#[test]
fn a_recovered_log_keeps_its_scene() {
    let folder = Folder::new();
    folder.run(&["run", "uav", "--duration", "4", "-q", "--placement", "single", "--out", "full.mcap"]);
    let bytes = std::fs::read(folder.path("full.mcap")).expect("the log");
    std::fs::write(folder.path("cut.mcap"), &bytes[..bytes.len() * 2 / 3]).expect("a cut log");
    let recovered = folder.run(&["recover", "cut.mcap", "--out", "recovered.mcap"]);
    assert_eq!(recovered.code(), 0, "{}", recovered.stderr());
    let info = folder.run(&["info", "recovered.mcap", "--json"]).json();
    let count = |topic: &str| {
        let mut channels = info["channels"].as_array().expect("channels").iter();
        channels.find(|channel| channel["topic"] == topic).expect("the topic")["messages"].as_u64().expect("a number")
    };
    assert_eq!(count("/tf"), info["steps"].as_u64().expect("steps").div_ceil(2));
    assert_eq!((info["complete"].as_bool(), count("/scene/bodies")), (Some(true), 1));
}

#[test]
fn a_fault_stands_in_the_journal() {
    let folder = Folder::new();
    // With a gain like this, the first input is no number any more, or the state soon.
    let run = ["run", "uav", "--set", "controller.k_p=1e300", "--placement", "single", "-q", "--out", "run.mcap"];
    assert_eq!(folder.run(&run).code(), 3);
    let Some(lines) = scene_of(&folder.path("run.mcap")) else { return };
    for reader in ["mcap-ros2-support", "rosbags"] {
        let start = format!("{reader}|40|observer_1|fault at step 2: ");
        assert!(lines.iter().any(|line| line.starts_with(&start)), "{start} in {lines:#?}");
    }
}

#[test]
fn layouts_name_topics_that_the_log_has() {
    let folder = Folder::new();
    folder.run(&["run", "uav", "--duration", "0.1", "-q", "--placement", "single", "--out", "run.mcap"]);
    let read =
        |name: &str| std::fs::read_to_string(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    for (viewer, file) in [
        ("foxglove", "run-foxglove.json"),
        ("lichtblick", "run-lichtblick.json"),
        ("plotjuggler", "run-plotjuggler.xml"),
        ("rerun", "run-rerun.py"),
    ] {
        let done = folder.run(&["layout", "run.mcap", "--for", viewer]);
        assert_eq!((done.code(), done.stdout().lines().next()), (0, Some(file)), "{}", done.stderr());
    }
    let layout: serde_json::Value = serde_json::from_str(&read("run-foxglove.json")).expect("JSON");
    let panels = &layout["configById"];
    assert_eq!(panels["3D!formation"]["topics"]["/scene/bodies"]["visible"], true);
    let curves = panels["Plot!0-2"]["paths"].as_array().expect("curves");
    assert_eq!((curves.len(), &curves[5]["value"]), (6, &"/agent_6/command.input[2]".into()));
    assert!(read("run-plotjuggler.xml").contains("name=\"/agent_6/command/input[2]\""));
    assert!(read("run-rerun.py").contains("(\"command input\", \"input\", [\"agent_1/command\", "));
    // A scenario that is yet to run has the same layout.
    folder.run(&["layout", "uav", "--for", "lichtblick", "--out", "scenario.json"]);
    assert_eq!(read("scenario.json"), read("run-lichtblick.json"));
    let wrong = folder.run(&["layout", "uavv", "--for", "rerun"]);
    assert_eq!(wrong.code(), 2);
    assert!(wrong.stderr().contains("did you mean `uav`?"), "{}", wrong.stderr());
}
