//! What happens to a run when the orchestrator is asked to end, or is killed, at a moment that a participant chooses.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;

use crate::program::{Finished, Folder, saboteur, unique, wait_until};

/// Steps are numbered from 0 to this.
const LAST: u64 = 50;
const MOMENTS: [&str; 6] = ["start", "connect", "0", "23", "50", "end"];
/// The participant that chooses the moment, in turn.
const PARTICIPANTS: [&str; 4] = ["plant", "planner", "observer_1", "controller_2"];

/// A short run of three robots in which the orchestrator gets a signal at a moment.
fn struck(folder: &Folder, name: &str, signal: &str, number: usize) -> Finished {
    let text = folder.run(&["validate", "compensated", "--print"]).stdout();
    folder.write("mine.toml", &text.replacen("name = \"compensated\"", &format!("name = \"{name}\""), 1));
    let (participant, moment) = (PARTICIPANTS[number % PARTICIPANTS.len()], MOMENTS[number]);
    let swap = format!("{participant}={} {signal}-parent {moment}", saboteur().display());
    let run = ["run", "mine.toml", "--dt", "0.001", "--duration", "0.05", "-q", "--out", "cut.mcap", "--swap", &swap];
    folder.run(&run)
}

/// Whether a process of the run with this name is left.
fn any_is_left(name: &str) -> bool {
    let directory = format!("/{name}\0");
    let of_run = |pid: &str| {
        let environment = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        String::from_utf8_lossy(&environment).contains(&directory)
    };
    let entries = std::fs::read_dir("/proc").expect("/proc").flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok()).any(|pid| of_run(&pid))
}

/// What of the run with this name is in shared memory.
fn shared_memory(name: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm").expect("shared memory").flatten();
    let mut left: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    left.retain(|file| file.contains(&format!("-{name}_")));
    let user = rustix::process::getuid().as_raw();
    if std::path::Path::new(&format!("/dev/shm/phalanx-{user}/{name}")).exists() {
        left.push(name.into());
    }
    left
}

#[test]
fn a_signal_ends_the_run_in_order_at_every_moment() {
    for (number, moment) in MOMENTS.iter().enumerate() {
        let signal = ["int", "term", "hup"][number % 3];
        let folder = Folder::new();
        let name = unique(&format!("asked-{moment}"));
        let end = struck(&folder, &name, signal, number);
        let what = format!("{signal} at {moment}: {}\n{}", end.code(), end.stderr());
        // A participant may be done with its last step before the run is, which is complete then.
        assert!(end.code() == 130 || *moment == "end" && end.code() == 0, "{what}");
        assert!(!any_is_left(&name), "{what}");
        assert_eq!(shared_memory(&name), [""; 0], "{what}");
        let info = folder.run(&["info", "cut.mcap", "--json"]).json();
        assert_eq!(info["complete"], true, "{what}");
        let steps = info["steps"].as_u64().expect("steps");
        let done = moment.parse().unwrap_or(if *moment == "end" { LAST + 1 } else { 0 });
        // Those that were done and not recorded yet are given up.
        assert!(steps <= done && steps + 8 >= done, "{steps} steps: {what}");
    }
}

#[test]
fn nothing_is_left_of_a_run_whose_orchestrator_is_killed_at_any_moment() {
    for (number, moment) in MOMENTS.iter().enumerate() {
        let folder = Folder::new();
        let name = unique(&format!("killed-{moment}"));
        let end = struck(&folder, &name, "kill", number);
        assert_eq!(end.0.status.code(), None, "{moment}: it was killed\n{}", end.stderr());
        wait_until("all participants are gone", || !any_is_left(&name));
        assert_eq!(folder.run(&["doctor"]).code(), 0);
        assert_eq!(shared_memory(&name), [""; 0], "{moment}");
        let recovered = folder.run(&["recover", "cut.mcap"]);
        assert!(recovered.code() == 0 && recovered.stdout().contains("cut.mcap was cut"), "{}", recovered.stdout());
        assert_eq!(folder.run(&["info", "cut-recovered.mcap", "--json"]).json()["complete"], true, "{moment}");
    }
}

/// It lists the runs, and removes nothing of theirs.
#[test]
fn doctor_removes_what_the_dead_have_left_and_leaves_the_living_alone() {
    let folder = Folder::new();
    let text = folder.run(&["validate", "compensated", "--print"]).stdout();
    let named = |name: &str| {
        let renamed = text.replacen("name = \"compensated\"", &format!("name = \"{name}\""), 1);
        folder.write(&format!("{name}.toml"), &renamed);
        let (scenario, log) = (format!("{name}.toml"), format!("{name}.mcap"));
        let run = folder.start(&["run", &scenario, "--realtime", "-q", "--out", &log]);
        wait_until("it runs", || folder.run(&["ctl", "status", name]).code() == 0);
        run
    };
    let (survivor, victim) = (unique("living"), unique("dying"));
    let (mut living, mut dying) = (named(&survivor), named(&victim));
    let user = rustix::process::getuid().as_raw();
    let temporary = std::env::temp_dir().join(format!("phalanx-scratch-{user}-{}-0", dying.id()));
    DirBuilder::new().mode(0o700).create(&temporary).expect("a folder");
    dying.kill().expect("a running program");
    dying.wait().expect("an end");
    wait_until("all participants are gone", || !any_is_left(&victim));
    // Memory whose directory is gone, as no run leaves it by itself.
    let stray = format!("/dev/shm/phalanx{}-nobody_0_0.dynamic", rustix::process::getuid().as_raw());
    std::fs::write(&stray, "x").expect("a file");
    let mut doctor = folder.run(&["doctor", "--json"]).json();
    // Other tests start programs at the same time, which may have done the same before.
    let running = doctor["running"].take();
    assert!(running.as_array().expect("a list").contains(&survivor.as_str().into()), "{running}");
    assert!(!running.as_array().expect("a list").contains(&victim.as_str().into()), "{running}");
    assert_eq!(shared_memory(&victim), [""; 0]);
    assert!(!temporary.exists() && !std::path::Path::new(&stray).exists());
    assert_ne!(shared_memory(&survivor), [""; 0]);
    assert_eq!(folder.run(&["ctl", "stop", &survivor]).code(), 0);
    assert_eq!(living.wait().expect("an end").code(), Some(130));
}
