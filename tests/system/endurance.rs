//! Long runs: memory that does not grow, and no step that never ends beside programs that keep all cores busy.

use std::process::{Child, Command, Stdio};

use crate::engine::status;
use crate::program::{Folder, children, wait_until};

/// Most memory that the process of a participant may have for itself, bytes.
const PRIVATE: u64 = 15_000_000;
/// What the memory of a participant may grow by from the first third of a run to its end, bytes: the noise of pages.
const GROWTH: u64 = 200_000;
/// What the orchestrator may have besides, and may grow by: if the disk or the machine is slow for a while, up to eleven chunks of
/// the log are in memory, packed and unpacked. The entries of the chunks in the summary of the log are 4 bytes per step.
const CHUNKS: u64 = 16_000_000;

/// Private memory of a process, bytes.
fn private(pid: u32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{pid}/smaps_rollup")).expect("a process that lives");
    let lines = text.lines().filter(|line| line.starts_with("Private_"));
    lines.filter_map(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok()).sum::<u64>() * 1024
}

#[test]
fn many_steps_do_not_grow_any_memory() {
    let folder = Folder::new();
    // So long that it does not end before it is held.
    let mut run = folder.start(&["run", "uav", "--dt", "0.001", "--duration", "280", "-q", "--out", "a.mcap"]);
    wait_until("the run answers", || status(&folder, &run).is_some());
    let (name, _) = status(&folder, &run).expect("a status");
    let tell = |words: &[&str]| folder.run(&[&["ctl"], words, &[&name, "--json"]].concat()).json();
    let steps = || tell(&["status"])["steps"].as_u64().expect("a number of steps");
    let memory_after = |more: u64| {
        let due = steps() + more;
        tell(&["step", &more.to_string()]);
        wait_until("the steps are done", || steps() >= due);
        std::iter::once(run.id()).chain(children(run.id())).map(private).collect::<Vec<u64>>()
    };
    tell(&["pause"]);
    let (early, late) = (memory_after(10_000), memory_after(20_000));
    tell(&["stop"]);
    run.wait().expect("an end");
    assert_eq!((early.len(), late.len()), (15, 15));
    for (process, (early, late)) in early.iter().zip(&late).enumerate() {
        let (most, growth) = if process == 0 { (PRIVATE + CHUNKS, CHUNKS) } else { (PRIVATE, GROWTH) };
        assert!(*late < most && *late < early + growth, "process {process} had {early} bytes and has {late}");
    }
}

/// Programs that do nothing but compute, ended with this.
struct Busy(Vec<Child>);

impl Drop for Busy {
    fn drop(&mut self) {
        for child in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

#[test]
fn no_step_hangs_beside_four_busy_programs() {
    let folder = Folder::new();
    let busy =
        |_| Command::new("sh").args(["-c", "while :; do :; done"]).stdin(Stdio::null()).spawn().expect("a shell");
    let busy = Busy((0..4).map(busy).collect());
    let run = folder.run(&["run", "uav", "--dt", "0.001", "--duration", "20", "-q", "--json", "--no-log"]).json();
    drop(busy);
    // A step that hangs ends the run by its deadline of 10 s.
    assert_eq!((run["steps"].as_u64(), run["ok"].as_bool()), (Some(20_000), Some(true)), "{run}");
}
