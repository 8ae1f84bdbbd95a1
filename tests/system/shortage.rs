//! Runs for which something is short: shared memory, room for the log, a terminal. File systems of their own need a mount
//! namespace, which `unshare` makes; where that is not allowed, these tests say so and pass.

use std::fs::{File, OpenOptions};
use std::io::Read;
use std::os::fd::OwnedFd;
use std::process::{Command, Output, Stdio};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::program::{Finished, Folder, wait_until};

const PROGRAM: &str = env!("CARGO_BIN_EXE_phalanx");

/// Runs a shell script in a mount namespace of its own; `None` if there can be none.
pub(crate) fn in_namespace(folder: &Folder, script: &str) -> Option<Finished> {
    let unshare = |script: &str| -> Option<Output> {
        let mut command = Command::new("unshare");
        command.args(["--mount", "--map-root-user", "sh", "-c", script]).current_dir(folder.path("."));
        command.stdin(Stdio::null()).output().ok()
    };
    let allowed = unshare("mount -t tmpfs none /dev/shm").is_some_and(|output| output.status.success());
    if !allowed {
        println!("skipped: this machine allows no mount namespace");
        return None;
    }
    unshare(script).map(Finished)
}

#[test]
fn shared_memory_that_is_full_is_told_before_anybody_is_killed_by_it() {
    let folder = Folder::new();
    for kilobytes in [16, 64, 200, 400, 600] {
        let script = format!(
            "mount -t tmpfs -o size={kilobytes}k none /dev/shm && \
             {PROGRAM} run uav --duration 0.1 -q --out cut.mcap; code=$?; ls -A /dev/shm; exit $code"
        );
        let Some(end) = in_namespace(&folder, &script) else { return };
        assert!([3, 5].contains(&end.code()), "{kilobytes} KiB: {}\n{}", end.code(), end.stderr());
        let stderr = end.stderr();
        assert!(stderr.contains("/dev/shm") && !stderr.contains("Bus error"), "{kilobytes} KiB: {stderr}");
        assert_eq!(end.stdout(), "", "something is left");
    }
    let enough = format!(
        "mount -t tmpfs -o size=2M none /dev/shm && {PROGRAM} run uav --duration 0.1 -q --out cut.mcap; ls -A /dev/shm >&2"
    );
    let end = in_namespace(&folder, &enough).expect("a namespace");
    assert!(end.stdout().contains("11 steps") || end.stdout().contains("10 steps"), "{}{}", end.stdout(), end.stderr());
    assert_eq!(end.stderr(), "");
}

/// Memory that others take while the run goes on must not be that which the run was promised.
#[test]
fn a_run_keeps_the_shared_memory_that_it_was_promised() {
    let folder = Folder::new();
    let script = format!(
        "mount -t tmpfs -o size=4M none /dev/shm && \
         {{ {PROGRAM} run uav --realtime --duration 2 -q --json --out cut.mcap & }} && \
         until {PROGRAM} ctl status uav --json 2>/dev/null | grep -q running; do sleep 0.05; done; \
         head -c 8M /dev/zero >/dev/shm/greedy 2>/dev/null; wait"
    );
    let Some(end) = in_namespace(&folder, &script) else { return };
    assert_eq!(end.json()["steps"], 200, "{}", end.stderr());
}

#[test]
fn a_folder_that_is_read_only_and_a_disk_that_is_full_are_told() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("disk")).expect("a folder");
    let script = format!("mount -t tmpfs -o ro none disk && {PROGRAM} run uav -q --out disk/cut.mcap");
    let Some(end) = in_namespace(&folder, &script) else { return };
    assert_eq!(end.code(), 4, "{}", end.stderr());
    let stderr = end.stderr();
    assert!(
        stderr.contains("disk/cut.mcap: Read-only file system") && stderr.contains("help: `--out FILE`"),
        "{stderr}"
    );
    let script = format!(
        "mount -t tmpfs -o size=2M none disk && {PROGRAM} run uav -q --json --out disk/cut.mcap; code=$?; \
         {PROGRAM} recover disk/cut.mcap --out cut.mcap >/dev/null; exit $code"
    );
    let end = in_namespace(&folder, &script).expect("a namespace");
    assert_eq!(end.code(), 4, "{}", end.stderr());
    let stderr = end.stderr();
    assert!(stderr.contains("No space left on device") && stderr.contains("help: make room"), "{stderr}");
    let info = folder.run(&["info", "cut.mcap", "--json"]).json();
    assert_eq!(info["complete"], true);
    assert!(info["steps"].as_u64().is_some_and(|steps| steps >= 100), "what was written is readable: {info}");
}

/// A window that is closed takes the terminal with it: SIGHUP comes, and nothing can be printed any more.
#[test]
fn a_terminal_that_is_closed_ends_the_run_in_order() {
    let folder = Folder::new();
    let master: OwnedFd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&master).expect("a terminal");
    unlockpt(&master).expect("a terminal");
    rustix::io::ioctl_fionbio(&master, true).expect("a terminal");
    // Else the program, and those of other tests, would keep it open themselves.
    rustix::io::fcntl_setfd(&master, rustix::io::FdFlags::CLOEXEC).expect("a terminal");
    let name = ptsname(&master, Vec::new()).expect("its name");
    let open = || {
        let name = name.to_str().expect("a path");
        Stdio::from(OpenOptions::new().read(true).write(true).open(name).expect("its other end"))
    };
    let mut command = Command::new("setsid");
    command.args(["--ctty", PROGRAM, "-v", "run", "uav", "--realtime", "--out", "cut.mcap"]);
    command.current_dir(folder.path(".")).stdin(open()).stdout(open()).stderr(open());
    let mut run = command.spawn().expect("the program starts");
    drop(command);
    let mut screen = File::from(master);
    let mut bytes = [0; 4096];
    wait_until("the log grows", || {
        while screen.read(&mut bytes).is_ok_and(|count| count > 0) {}
        std::fs::metadata(folder.path("cut.mcap")).is_ok_and(|file| file.len() > 400_000)
    });
    drop(screen);
    assert_eq!(run.wait().expect("an end").code(), Some(130));
    let info = folder.run(&["info", "cut.mcap", "--json"]).json();
    assert_eq!(info["complete"], true);
    assert!(info["steps"].as_u64().is_some_and(|steps| steps > 10), "{info}");
}
