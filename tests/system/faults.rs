//! Runs that do not come to their end.

use rustix::process::{Pid, Signal, kill_process};

use crate::program::{Finished, Folder, children, is_alive, wait_until};

const ENDLESS: [&str; 6] = ["run", "uav", "--duration", "8000", "-q", "--out"];

fn process(pid: u32) -> Pid {
    Pid::from_raw(pid as i32).expect("a process id")
}

#[test]
fn an_interrupted_run_leaves_a_readable_log_and_nothing_else() {
    let folder = Folder::new();
    let run = folder.start(&[&ENDLESS[..], &["cut.mcap"]].concat());
    let pid = run.id();
    wait_until("the log grows", || std::fs::metadata(folder.path("cut.mcap")).is_ok_and(|file| file.len() > 500_000));
    let participants = children(pid);
    assert_eq!(participants.len(), 14);
    kill_process(process(pid), Signal::INT).expect("a running program");
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_eq!(end.code(), 130, "{}", end.stderr());
    assert!(participants.into_iter().all(|pid| !is_alive(pid)));
    let info = folder.run(&["info", "cut.mcap", "--json"]).json();
    assert_eq!(info["complete"], true, "the log was closed");
    assert!(info["steps"].as_u64().expect("steps") > 100);
}

#[test]
fn a_killed_participant_ends_the_run_by_name() {
    let folder = Folder::new();
    let run = folder.start(&[&ENDLESS[..], &["cut.mcap"]].concat());
    wait_until("all participants run", || children(run.id()).len() == 14);
    wait_until("the log grows", || std::fs::metadata(folder.path("cut.mcap")).is_ok_and(|file| file.len() > 100_000));
    let victim = children(run.id())[9];
    kill_process(process(victim), Signal::KILL).expect("a running participant");
    let end = Finished(run.wait_with_output().expect("an end"));
    assert_eq!(end.code(), 3);
    let stderr = end.stderr();
    assert!(stderr.contains(&format!("(pid {victim})")) && stderr.contains("SIGKILL"), "{stderr}");
    assert_eq!(folder.run(&["info", "cut.mcap", "--json"]).json()["complete"], true);
}

#[test]
fn participants_die_with_the_program_and_the_next_run_works() {
    let folder = Folder::new();
    let mut run = folder.start(&[&ENDLESS[..], &["cut.mcap"]].concat());
    wait_until("the log grows", || std::fs::metadata(folder.path("cut.mcap")).is_ok_and(|file| file.len() > 500_000));
    let participants = children(run.id());
    run.kill().expect("a running program");
    run.wait().expect("an end");
    wait_until("all participants are gone", || participants.iter().all(|pid| !is_alive(*pid)));
    let info = folder.run(&["info", "cut.mcap", "--json"]).json();
    assert_eq!(info["complete"], false);
    assert!(info["steps"].as_u64().expect("steps") > 100, "what had reached the file is readable");
    let recovered = folder.run(&["recover", "cut.mcap"]);
    assert_eq!(recovered.code(), 0, "{}", recovered.stderr());
    assert_eq!(folder.run(&["info", "cut-recovered.mcap", "--json"]).json()["complete"], true);
    let next = folder.run(&["run", "uav", "--duration", "0.5", "-q", "--json", "--out", "next.mcap"]);
    assert_eq!(next.json()["processes"], 15, "{}", next.stderr());
}

#[test]
fn a_full_disk_is_reported() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "-q", "--placement", "single", "--out", "/dev/full"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("/dev/full: it is a device"), "{}", run.stderr());
}

/// Sampled ten times too slowly, the attitude loop leaves the range of numbers at once.
#[test]
fn a_scenario_that_diverges_names_who_and_when() {
    let folder = Folder::new();
    let slow = ["run", "uav", "--dt", "0.1", "--duration", "800", "-q", "--placement", "single", "--out", "cut.mcap"];
    let run = folder.run(&slow);
    assert_eq!(run.code(), 3, "{}", run.stderr());
    assert!(run.stderr().contains("plant at step 13: output /agent_3/state: position[3] is inf"), "{}", run.stderr());
    assert_eq!(folder.run(&["info", "cut.mcap", "--json"]).json()["complete"], true);
}

#[test]
fn a_program_that_does_not_exist_is_named() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "-q", "--swap", "plant=./nobody", "--out", "cut.mcap"]);
    assert_eq!(run.code(), 2);
    assert!(run.stderr().contains("plant: there is no program ./nobody"), "{}", run.stderr());
    // What the search path holds, only the system knows.
    let run = folder.run(&["run", "uav", "-q", "--swap", "plant=nobody-at-all", "--out", "cut.mcap"]);
    assert_eq!(run.code(), 3);
    assert!(run.stderr().contains("start nobody-at-all for plant"), "{}", run.stderr());
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "-q", "--out", "/proc/nowhere/cut.mcap"]);
    assert!([4, 5].contains(&run.code()), "{}", run.stderr());
    assert!(run.stderr().contains("/proc/nowhere"), "{}", run.stderr());
}

#[test]
fn too_few_file_descriptors_end_the_start_and_leave_nothing() {
    let folder = Folder::new();
    for limit in [8, 16, 32] {
        let program = format!("ulimit -n {limit}; exec {} run uav -q --out cut.mcap", env!("CARGO_BIN_EXE_phalanx"));
        let run = std::process::Command::new("sh").args(["-c", &program]).current_dir(folder.path(".")).output();
        let end = Finished(run.expect("a shell"));
        assert!([2, 3, 4, 5].contains(&end.code()), "{limit}: {} {}", end.code(), end.stderr());
        assert!(!end.stderr().contains("panicked") && end.stderr().contains("error: "), "{limit}: {}", end.stderr());
    }
    let next = folder.run(&["run", "uav", "--duration", "0.5", "-q", "--json", "--out", "next.mcap"]);
    assert_eq!(next.json()["processes"], 15, "{}", next.stderr());
}

#[test]
fn every_signal_that_asks_for_an_end_gets_one_in_order() {
    for signal in [Signal::TERM, Signal::HUP] {
        let folder = Folder::new();
        let run = folder.start(&[&ENDLESS[..], &["cut.mcap"]].concat());
        let log = folder.path("cut.mcap");
        wait_until("the log grows", || std::fs::metadata(&log).is_ok_and(|file| file.len() > 100_000));
        kill_process(process(run.id()), signal).expect("a running program");
        let end = Finished(run.wait_with_output().expect("an end"));
        assert_eq!(end.code(), 130, "{}", end.stderr());
        assert_eq!(folder.run(&["info", "cut.mcap", "--json"]).json()["complete"], true);
    }
}

/// A hundred steps fill a chunk; a slow run is readable up to its last step all the same, also for the stock readers.
#[test]
fn what_a_killed_slow_run_has_recorded_is_in_its_log() {
    let folder = Folder::new();
    let text = folder.run(&["validate", "uav", "--print"]).stdout();
    folder.write("slow.toml", &text.replacen("name = \"uav\"", "name = \"slow\"", 1));
    let mut run = folder.start(&["run", "slow.toml", "--realtime", "-q", "--out", "cut.mcap"]);
    wait_until("the run can be told", || folder.run(&["ctl", "pause", "slow"]).code() == 0);
    folder.run(&["ctl", "step", "57", "slow"]);
    let done = || folder.run(&["ctl", "status", "slow", "--json"]).json()["steps"].as_u64().unwrap_or(0);
    let (mut before, mut equal) = (0, 0);
    wait_until("it is held again", || {
        let now = done();
        equal = if now == before { equal + 1 } else { 0 };
        before = now;
        equal == 20 && now >= 57
    });
    run.kill().expect("a running program");
    run.wait().expect("an end");
    let info = folder.run(&["info", "cut.mcap", "--json"]).json();
    assert_eq!(info["complete"], false);
    assert!(info["steps"].as_u64().is_some_and(|steps| steps >= before), "{info}: {before} steps were done");
    assert_eq!(folder.run(&["recover", "cut.mcap"]).code(), 0);
    assert_eq!(folder.run(&["info", "cut-recovered.mcap", "--json"]).json()["steps"], info["steps"]);
}
