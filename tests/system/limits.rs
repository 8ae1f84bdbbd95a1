//! What keeps a run within its limits: ranges of values, permissions, where names lead; and its messages.

use rustix::process::{Pid, Signal, kill_process};

use crate::program::{Finished, Folder, children, wait_until};

const ENDLESS: [&str; 6] = ["run", "uav", "--duration", "8000", "-q", "--out"];

fn process(pid: u32) -> Pid {
    Pid::from_raw(pid as i32).expect("a process id")
}

#[test]
fn a_value_outside_its_range_stops_the_run_by_name() {
    let folder = Folder::new();
    for placement in ["single", "processes"] {
        let range = "ranges.\"command.input\".max=20";
        let run = folder.run(&["run", "uav", "--placement", placement, "-q", "--set", range, "--out", "cut.mcap"]);
        let stderr = run.stderr();
        assert_eq!(run.code(), 3, "{stderr}");
        assert!(stderr.contains("controller_1 at step 0: output /agent_1/command: input[0] is 20.8"), "{stderr}");
        assert!(stderr.contains("outside its range <= 20"), "{stderr}");
    }
    let run = folder.run(&["validate", "uav", "--set", "ranges.\"command.imput\".max=20"]);
    assert!(run.code() == 2 && run.stderr().contains("did you mean `input`?"), "{}", run.stderr());
}

#[test]
fn every_process_has_a_file_with_what_it_says() {
    let folder = Folder::new();
    let run = folder.run(&["run", "uav", "--duration", "0.1", "-v", "--no-log", "--log-dir", "logs"]);
    let stderr = run.stderr();
    assert!(stderr.contains("[plant]  INFO building") && stderr.contains("[phalanx]  INFO all processes"), "{stderr}");
    assert!(!stderr.contains('\u{1b}'), "colours are for terminals");
    let file = |name: &str| std::fs::read_to_string(folder.path("logs").join(name)).expect("a file");
    assert!(file("controller_6.log").contains("hosts=\"controller_6\""));
    assert!(file("phalanx.log").contains("all processes are connected"));
    let mode = std::os::unix::fs::PermissionsExt::mode(
        &std::fs::metadata(folder.path("logs")).expect("a folder").permissions(),
    );
    assert_eq!(mode & 0o777, 0o700);
    let quiet = folder.run(&["run", "uav", "--duration", "0.1", "-q", "--no-log"]);
    assert_eq!(quiet.stderr(), "");
    let wrong = folder.run(&["run", "uav", "--log-filter", "a=b=c"]);
    assert!(wrong.code() == 2 && wrong.stderr().contains("--log-filter a=b=c"), "{}", wrong.stderr());
}

#[test]
fn a_run_is_readable_by_its_user_alone() {
    let folder = Folder::new();
    let run = folder.start(&[&ENDLESS[..], &["cut.mcap"]].concat());
    let pid = run.id();
    wait_until("all participants run", || children(pid).len() == 14);
    wait_until("the log grows", || std::fs::metadata(folder.path("cut.mcap")).is_ok_and(|file| file.len() > 100_000));
    let environment = std::fs::read(format!("/proc/{}/environ", children(pid)[0])).expect("a participant");
    let text = String::from_utf8_lossy(&environment).into_owned();
    let directory = text.split('\0').find_map(|entry| entry.strip_prefix("PHALANX_RUN_DIR=")).expect("its directory");
    let directory = std::path::Path::new(directory);
    let name = directory.file_name().expect("a name").to_string_lossy().into_owned();
    let mode = |path: &std::path::Path| {
        std::os::unix::fs::PermissionsExt::mode(&std::fs::symlink_metadata(path).expect("a file").permissions()) & 0o777
    };
    assert_eq!(mode(directory), 0o700);
    let control = directory.join("control.sock");
    assert_eq!(mode(&control), 0o600);
    let shared: Vec<_> = std::fs::read_dir("/dev/shm")
        .expect("shared memory")
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.file_name().is_some_and(|file| file.to_string_lossy().contains(&format!("-{name}_"))))
        .collect();
    assert!(!shared.is_empty());
    assert!(shared.iter().all(|path| mode(path) & 0o077 == 0), "{shared:?}");
    // No process of the run has a socket of a network.
    let networks: String = ["tcp", "tcp6", "udp", "udp6"]
        .map(|kind| std::fs::read_to_string(format!("/proc/{pid}/net/{kind}")).unwrap_or_default())
        .concat();
    for process in children(pid).into_iter().chain([pid]) {
        for entry in std::fs::read_dir(format!("/proc/{process}/fd")).expect("its files").flatten() {
            let target = std::fs::read_link(entry.path()).unwrap_or_default().to_string_lossy().into_owned();
            if let Some(inode) = target.strip_prefix("socket:[").and_then(|rest| rest.strip_suffix(']')) {
                assert!(!networks.split_whitespace().any(|word| word == inode), "{process} has a socket of a network");
            }
        }
    }
    kill_process(process(pid), Signal::INT).expect("a running program");
    assert_eq!(Finished(run.wait_with_output().expect("an end")).code(), 130);
}

#[test]
fn names_lead_nowhere_else() {
    let folder = Folder::new();
    let uav = include_str!("../../scenarios/uav.toml");
    for name in ["../evil", "/tmp/evil", "a/b", "", ".."] {
        folder.write("bad.toml", &uav.replacen("name = \"uav\"", &format!("name = \"{name}\""), 1));
        let run = folder.run(&["run", "bad.toml", "-q", "--duration", "0.1"]);
        assert!(run.code() == 2 && run.stderr().contains("expected a name of letters"), "{}", run.stderr());
    }
    folder.write("bad.toml", &uav.replace("TSC", "../../evil"));
    let run = folder.run(&["run", "bad.toml", "-q", "--duration", "0.1", "--placement", "single"]);
    assert!(run.code() == 2 && run.stderr().contains("variant"), "{}", run.stderr());
    for name in ["../evil", "/dev/shm", "."] {
        let ctl = folder.run(&["ctl", "status", name]);
        assert!(ctl.code() == 2 && ctl.stderr().contains("no run is called"), "{}", ctl.stderr());
    }
    assert!(!folder.path("runs").exists());
}
