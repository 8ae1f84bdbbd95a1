//! Names in shared memory that are not those of a run: of any kind and any owner, no command waits or fails.

use crate::program::Folder;
use crate::shortage::in_namespace;

const PROGRAM: &str = env!("CARGO_BIN_EXE_phalanx");

/// What may stand where the directory of all runs belongs, or beside it. `$D` is that directory, `$S` the beginning of the
/// names of shared memory.
const OBSTACLES: [&str; 14] = [
    "mkfifo $D",
    "mkfifo -m 666 $D",
    "ln -s /etc $D",
    "ln -s /nowhere/x $D",
    "ln -s $D $D",
    "echo x > $D",
    "mkdir -m 755 $D",
    "mkdir -m 755 $D; flock $D sleep 60 >/dev/null 2>&1 &",
    "mknod $D c 1 5 2>/dev/null || touch $D",
    "mkdir -m 700 $D; mount -t tmpfs -o ro none $D",
    "for n in '' -2 -3 -4 -5 -6 -7 -8 -9; do mkfifo $D$n; done",
    "mkdir $S-x_y; mkfifo $S-x_z; ln -s /nowhere $S-uav_a",
    "mkdir -m 700 $D; mkfifo $D/uav; mkdir -m 700 $D/uav-2; mkfifo $D/uav-2/door $D/uav-2/lineage",
    "mkdir -m 700 $D; mkdir -m 700 $D/old; mkdir $D/old/m; mount -t tmpfs none $D/old/m; touch $D/old/m/data",
];

#[test]
fn no_name_in_shared_memory_makes_a_command_wait_or_fail() {
    for obstacle in OBSTACLES {
        let folder = Folder::new();
        let script = format!(
            "mount -t tmpfs -o mode=1777 none /dev/shm; D=/dev/shm/phalanx-$(id -u); S=/dev/shm/phalanx$(id -u); {obstacle}\n\
             try() {{ timeout 60 {PROGRAM} \"$@\" > out 2> err; code=$?; echo \"$1 $code\"; cat err; }}\n\
             try doctor; try list; try run uav --duration 0.05 -qq --out a.mcap; try info a.mcap; try ctl status; try doctor\n\
             test -e $D/old/m && ls $D/old/m; ls -d /dev/shm/phalanx*/.dead*/m/data 2>/dev/null; true"
        );
        let Some(end) = in_namespace(&folder, &script) else { return };
        let told = end.stdout();
        let codes: Vec<&str> = told.lines().filter(|line| line.split(' ').count() == 2).collect();
        for expected in ["doctor 0", "list 0", "run 0", "info 0", "ctl 2"] {
            assert!(codes.contains(&expected), "{obstacle}: no `{expected}` in\n{told}\n{}", end.stderr());
        }
        if obstacle.contains("data") {
            assert!(told.contains("data"), "what is mounted in a dead run is the data of others:\n{told}");
        }
    }
}

/// The runs of one user find each other under any name.
#[test]
fn a_run_under_another_name_is_found_by_all_commands() {
    let folder = Folder::new();
    let script = format!(
        "mount -t tmpfs -o mode=1777 none /dev/shm; mkfifo /dev/shm/phalanx-$(id -u)\n\
         {PROGRAM} run uav --realtime --no-log -qq & R=$!\n\
         for i in $(seq 300); do timeout 20 {PROGRAM} ctl status > status 2>&1 && break; sleep 0.05; done; cat status\n\
         rm /dev/shm/phalanx-$(id -u); timeout 20 {PROGRAM} doctor; timeout 20 {PROGRAM} ctl stop; wait $R; echo run $?\n\
         ls -A /dev/shm"
    );
    let Some(end) = in_namespace(&folder, &script) else { return };
    let told = end.stdout();
    assert!(told.contains("Running, and left alone: uav") && told.contains("run 130"), "{told}\n{}", end.stderr());
    assert!(!told.lines().any(|line| line.starts_with("phalanx")), "something is left:\n{told}");
}

/// Only what starts runs removes what dead ones have left; what reads does not depend on it.
#[test]
fn commands_that_read_remove_nothing() {
    let folder = Folder::new();
    let script = format!(
        "mount -t tmpfs -o mode=1777 none /dev/shm; {PROGRAM} run uav --duration 0.1 -qq --out a.mcap >/dev/null\n\
         {PROGRAM} run uav --realtime --no-log -qq & R=$!\n\
         for i in $(seq 300); do timeout 20 {PROGRAM} ctl status >/dev/null 2>&1 && break; sleep 0.05; done\n\
         kill -KILL $R; wait $R 2>/dev/null; ls -AR /dev/shm > before\n\
         for i in $(seq 300); do sleep 0.05; ls -AR /dev/shm > now; cmp -s before now && break; cp now before; done\n\
         {PROGRAM} list >/dev/null; {PROGRAM} info a.mcap >/dev/null; {PROGRAM} check a.mcap >/dev/null\n\
         ls -AR /dev/shm > after; cmp before after && grep -c uav after; {PROGRAM} doctor >/dev/null; ls -A /dev/shm"
    );
    let Some(end) = in_namespace(&folder, &script) else { return };
    let printed = end.stdout();
    let mut lines = printed.lines();
    let left = lines.next().and_then(|count| count.parse::<u32>().ok());
    assert!(left.is_some_and(|left| left > 0) && lines.next().is_none(), "{printed}\n{}", end.stderr());
}
