//! What a foreign program sees of a run: only iceoryx2, no crate of ours but the layout of the header.

use iceoryx2::prelude::{Config, FilePath, NodeBuilder, SemanticString, ServiceName, SignalHandlingMode, ipc};
use processes::TapHeader;

use crate::program::{Folder, wait_until};

#[test]
fn a_stranger_reads_along_and_changes_nothing() {
    let folder = Folder::new();
    let short = ["run", "uav", "--duration", "3", "-q"];
    let mut run = folder.start(&[&short[..], &["--realtime", "2", "--tap", "--out", "a.mcap"]].concat());
    let user = rustix::process::getuid().as_raw();
    let config = || {
        let runs = std::fs::read_dir(format!("/dev/shm/phalanx-{user}")).ok()?.flatten();
        // Others may run drones at the same time; ours is the one that holds the folder of this child's process.
        let of_child = |path: &std::path::PathBuf| {
            std::fs::read_dir(format!("/proc/{}/fd", run.id())).is_ok_and(|files| {
                files.flatten().any(|file| std::fs::read_link(file.path()).is_ok_and(|to| to.starts_with(path)))
            })
        };
        let path = runs.map(|entry| entry.path()).find(of_child)?.join("config/iceoryx2.toml");
        path.is_file().then_some(path)
    };
    wait_until("the run has a tap", || config().is_some());
    let path = config().expect("a configuration");
    let path = FilePath::new(path.to_str().expect("a path").as_bytes()).expect("a path");
    let config = Config::from_file(&path).expect("a configuration");
    let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled);
    let node = node.create::<ipc::Service>().expect("a node");
    let subscribe = |topic: &str| {
        let name = ServiceName::new(topic).expect("a name");
        let service = node.service_builder(&name).publish_subscribe::<[f64]>().user_header::<TapHeader>();
        service.open().expect("a service").subscriber_builder().create().expect("a subscriber")
    };
    let state = subscribe("/agent_1/state");
    let idle = subscribe("/agent_2/state");
    let mut steps = Vec::new();
    wait_until("a hundred samples have come", || {
        while let Some(sample) = state.receive().expect("a sample") {
            // Position, velocity and disturbance of six coordinates.
            assert_eq!((sample.payload().len(), sample.user_header().0.agent), (18, 1));
            assert!(sample.payload().iter().all(|number| number.is_finite()));
            steps.push(sample.user_header().0.step);
        }
        steps.len() >= 100
    });
    assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
    // A reader that never reads does not block the run.
    run.wait().expect("an end");
    drop((state, idle, node));
    folder.run(&[&short[..], &["--out", "b.mcap"]].concat());
    assert_eq!(folder.run(&["verify", "a.mcap", "b.mcap"]).code(), 0);
}
