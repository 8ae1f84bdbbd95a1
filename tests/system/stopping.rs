//! A run ends on request, at any moment and under any load. Nothing here measures a time: what would have waited for its client,
//! its program or its reader would have waited far longer than any limit below, or for ever.

use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::program::{Finished, Folder, assert_rows_of_faults, children, is_alive, unique, wait_until};

/// What a machine with much else to do may take for something that takes milliseconds.
const SOON: Duration = Duration::from_secs(20);

/// A scenario under a name of its own, which is then that of its run.
pub(crate) fn renamed(folder: &Folder, scenario: &str, name: &str) -> String {
    let text = folder.run(&["validate", scenario, "--print"]).stdout();
    let renamed = text.replacen(&format!("name = \"{scenario}\""), &format!("name = \"{name}\""), 1);
    assert_ne!(text, renamed);
    folder.write(&format!("{name}.toml"), &renamed);
    format!("{name}.toml")
}

fn status(folder: &Folder, name: &str) -> Option<Value> {
    serde_json::from_str(folder.run(&["ctl", "status", name, "--json"]).stdout().trim()).ok()
}

/// Starts a run that would take an hour, and waits until its steps are done.
fn endless(folder: &Folder, name: &str, more: &[&str]) -> Child {
    let scenario = renamed(folder, "uav", name);
    let run = ["run", &scenario, "--duration", "3600", "--realtime", "-q", "--out", "a.mcap"];
    let run = folder.start(&[&run[..], more].concat());
    wait_until("it runs", || status(folder, name).is_some_and(|status| status["steps"].as_u64() > Some(2)));
    run
}

fn send(child: &Child, signal: Signal) {
    kill_process(Pid::from_raw(child.id() as i32).expect("a process id"), signal).expect("a running program");
}

/// The end of a program that is to come soon; it is killed if it does not.
fn soon(mut child: Child) -> Finished {
    let start = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if start.elapsed() > SOON {
            child.kill().expect("a running program");
            panic!("it did not end: {}", Finished(child.wait_with_output().expect("an end")).stderr());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Finished(child.wait_with_output().expect("an end"))
}

fn socket(name: &str) -> String {
    format!("/dev/shm/phalanx-{}/{name}/control.sock", rustix::process::getuid().as_raw())
}

fn connect(name: &str) -> UnixStream {
    UnixStream::connect(socket(name)).expect("a control socket")
}

#[test]
fn an_emergency_stop_gets_through_a_swap_idle_clients_and_a_foreign_lock() {
    let folder = Folder::new();
    let name = unique("crowded");
    let run = endless(&folder, &name, &[]);
    let swap = folder.start(&["ctl", "swap", "controller.3=sleep 1000", &name]);
    wait_until("the swap has begun", || status(&folder, &name).is_some_and(|status| status["state"] == "swapping"));
    let idle: Vec<UnixStream> = (0..150).map(|_| connect(&name)).collect();
    let mut dripping = connect(&name);
    dripping.write_all(b"sta").expect("a server");
    // Other tests start and end runs meanwhile, which need this lock, too.
    let directory =
        File::open(format!("/dev/shm/phalanx-{}", rustix::process::getuid().as_raw())).expect("a directory");
    directory.lock().expect("a lock");
    let estop = soon(folder.start(&["ctl", "estop", &name]));
    directory.unlock().expect("a lock");
    assert_eq!(estop.code(), 0, "{}", estop.stderr());
    assert!(estop.stdout().contains("is stopping"), "{}", estop.stdout());
    let end = soon(run);
    assert_eq!(end.code(), 3, "{}", end.stderr());
    assert!(end.stderr().contains("emergency stop"), "{}", end.stderr());
    assert_eq!(soon(swap).code(), 2);
    assert_eq!(folder.run(&["info", "a.mcap", "--json"]).json()["complete"], true);
    drop(idle);
}

#[test]
fn a_paused_run_is_asked_and_stopped() {
    let folder = Folder::new();
    let name = unique("held");
    let run = endless(&folder, &name, &[]);
    assert_eq!(folder.run(&["ctl", "pause", &name]).code(), 0);
    wait_until("it is paused", || status(&folder, &name).is_some_and(|status| status["state"] == "paused"));
    assert_eq!(folder.run(&["ctl", "stop", &name]).code(), 0);
    assert_eq!(soon(run).code(), 130);
}

#[test]
fn a_client_that_sends_without_an_end_is_no_hindrance() {
    let folder = Folder::new();
    let name = unique("talkative");
    let run = endless(&folder, &name, &[]);
    let clients: Vec<_> = (0..8)
        .map(|_| {
            let mut stream = connect(&name);
            std::thread::spawn(move || stream.write_all(&vec![b'x'; 8 << 20]))
        })
        .collect();
    for client in clients {
        assert!(client.join().expect("a client").is_err(), "a request of eight megabytes was read");
    }
    let memory = std::fs::read_to_string(format!("/proc/{}/status", run.id())).expect("a process");
    wait_until(&format!("it answers; {memory}"), || status(&folder, &name).is_some());
    send(&run, Signal::TERM);
    assert_eq!(soon(run).code(), 130);
}

#[test]
fn a_swap_does_not_hold_up_the_end_of_a_run() {
    let folder = Folder::new();
    for signal in [true, false] {
        let name = unique(&format!("late-swap-{signal}"));
        let run = endless(&folder, &name, &[]);
        // Two: one is under way, one has not begun.
        let swaps = ["controller.3", "controller.4"].map(|node| {
            let program = format!("{node}=sleep 1000");
            folder.start(&["ctl", "swap", &program, &name])
        });
        wait_until("one has begun", || status(&folder, &name).is_some_and(|status| status["state"] == "swapping"));
        if signal {
            send(&run, Signal::TERM);
        } else {
            assert_eq!(folder.run(&["ctl", "stop", &name]).code(), 0);
        }
        let end = soon(run);
        assert_eq!(end.code(), 130, "{}", end.stderr());
        for swap in swaps {
            let end = soon(swap);
            assert_ne!(end.code(), 0, "{}", end.stdout());
        }
    }
}

#[test]
fn a_swap_that_is_asked_for_in_the_last_step_is_refused() {
    let folder = Folder::new();
    let name = unique("too-late");
    let scenario = renamed(&folder, "uav", &name);
    // A step takes two seconds.
    let run = folder.start(&["run", &scenario, "--realtime", "0.005", "-q", "--out", "a.mcap"]);
    wait_until("it runs", || status(&folder, &name).is_some_and(|status| status["state"] == "running"));
    let swap = folder.start(&["ctl", "swap", "controller.3=sleep 1000", &name]);
    std::thread::sleep(Duration::from_millis(100));
    send(&run, Signal::TERM);
    assert_eq!(soon(run).code(), 130);
    let refused = soon(swap);
    assert_ne!(refused.code(), 0, "{}", refused.stdout());
}

#[test]
fn nothing_that_is_not_read_keeps_a_run_from_its_end() {
    let folder = Folder::new();
    let phalanx = env!("CARGO_BIN_EXE_phalanx");
    folder.write("flood.sh", &format!("yes a line of some length that says nothing &\nexec {phalanx} participant\n"));
    for signal in [true, false] {
        let name = unique(&format!("unread-{signal}"));
        let scenario = renamed(&folder, "uav", &name);
        let duration = if signal { "3600" } else { "2" };
        let run = ["run", &scenario, "--duration", duration, "--realtime", "-v", "--out", "a.mcap"];
        let mut run = folder.phalanx(&[&run[..], &["--swap", "controller.3=sh flood.sh"]].concat());
        // Stdout is read to its end; stderr is not, until the run is over.
        let mut run = run.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a run");
        let unread = run.stderr.take().expect("a pipe");
        wait_until("it runs", || status(&folder, &name).is_some_and(|status| status["steps"].as_u64() > Some(50)));
        if signal {
            send(&run, Signal::TERM);
        }
        let end = soon(run);
        assert!(if signal { end.code() == 130 } else { end.code() <= 1 }, "exit code {}", end.code());
        assert!(end.stdout().contains("of participants' output were dropped"), "{}", end.stdout());
        drop(unread);
        assert_eq!(folder.run(&["info", "a.mcap", "--json"]).json()["complete"], true);
    }
}

#[test]
fn a_reader_that_comes_late_learns_what_was_dropped() {
    let folder = Folder::new();
    let phalanx = env!("CARGO_BIN_EXE_phalanx");
    folder.write("flood.sh", &format!("yes a line of some length that says nothing &\nexec {phalanx} participant\n"));
    let name = unique("read-late");
    let mut run = endless(&folder, &name, &["--swap", "controller.3=sh flood.sh"]);
    let mut stderr = run.stderr.take().expect("a pipe");
    std::thread::sleep(Duration::from_millis(500));
    let reading = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        stderr.read_to_end(&mut bytes).map(|_| bytes)
    });
    std::thread::sleep(Duration::from_millis(500));
    send(&run, Signal::TERM);
    assert_eq!(soon(run).code(), 130);
    let text = String::from_utf8_lossy(&reading.join().expect("a reader").expect("a pipe")).into_owned();
    let line = text.lines().find(|line| line.contains("stderr was not read fast enough"));
    assert!(line.is_some_and(|line| line.starts_with("[phalanx]")), "{} bytes", text.len());
    assert!(text.lines().any(|line| line == "[controller_3] a line of some length that says nothing"));
    assert!(text.ends_with("error: interrupted\n"), "the program's own messages come through");
}

#[test]
fn sigterm_ends_a_start() {
    let folder = Folder::new();
    let name = unique("beginning");
    let scenario = renamed(&folder, "uav", &name);
    let run = ["run", &scenario, "-q", "--out", "a.mcap", "--swap", "controller.3=sleep 1000", "--deadline", "300"];
    let run = folder.start(&run);
    wait_until("it starts", || status(&folder, &name).is_some_and(|status| status["state"] == "starting"));
    let started = children(run.id());
    send(&run, Signal::TERM);
    let end = soon(run);
    assert_eq!(end.code(), 130, "{}", end.stderr());
    wait_until("all participants are gone", || !started.iter().any(|&pid| is_alive(pid)));
}

#[test]
fn sigterm_ends_the_start_of_hundreds_of_processes_at_any_moment() {
    let folder = Folder::new();
    let name = unique("many");
    let agents: String = (0..100)
        .map(|i| format!("{{ position = [{}, {}, 0], R = 0.25, m = 3, I = 0.1 }},\n", i % 10, i / 10))
        .collect();
    let text = format!(
        "name = \"{name}\"\ntitle = \"many\"\nagents = [\n{agents}]\n[timing]\ndt = 0.01\nduration = 5\n\
         [vehicle]\nkind = \"omni\"\norder = 2\n[topology]\nb = 1\n\
         [reference]\nposition = [\"t\", \"0\", \"0\"]\n[plant]\nkind = \"vehicles\"\n[planner]\nkind = \"reference\"\n\
         [controller]\nkind = \"consensus\"\nk_x = 2\nk_v = 2\n"
    );
    folder.write("many.toml", &text);
    for milliseconds in [30, 120, 400, 900] {
        let run = folder.start(&["run", "many.toml", "-q", "--out", "many.mcap"]);
        std::thread::sleep(Duration::from_millis(milliseconds));
        send(&run, Signal::TERM);
        let end = soon(run);
        // Before its handler is set, a signal does what it does to any program.
        let code = end.0.status.code();
        assert!(code.is_none_or(|code| code == 130), "after {milliseconds} ms: {code:?} {}", end.stderr());
    }
}

#[test]
fn a_start_can_be_asked_and_stopped() {
    let folder = Folder::new();
    let name = unique("slow-start");
    let scenario = renamed(&folder, "uav", &name);
    for (command, code) in [("stop", 130), ("estop", 3)] {
        let swap = ["--swap", "controller.3=sleep 1000", "--deadline", "300"];
        let run = folder.start(&[&["run", &scenario, "-q", "--out", "a.mcap"], &swap[..]].concat());
        wait_until("it starts", || status(&folder, &name).is_some_and(|status| status["state"] == "starting"));
        let told = folder.run(&["ctl", "status", &name]);
        assert!(told.stdout().contains("is starting"), "{}", told.stdout());
        assert_eq!(folder.run(&["ctl", command, &name]).code(), 0);
        let end = soon(run);
        assert_eq!(end.code(), code, "{}", end.stderr());
    }
}

#[test]
fn a_stopped_orchestrator_is_called_stopped() {
    let folder = Folder::new();
    let name = unique("frozen");
    let run = endless(&folder, &name, &[]);
    send(&run, Signal::STOP);
    for command in [&["ctl", "status", &name][..], &["top", "--once", &name]] {
        let told = folder.run(command);
        assert_eq!(told.code(), 5, "{}", told.stdout());
        let text = told.stderr();
        assert!(text.contains("is stopped") && text.contains(&format!("kill -CONT {}", run.id())), "{text}");
    }
    send(&run, Signal::CONT);
    assert!(status(&folder, &name).is_some());
    send(&run, Signal::TERM);
    assert_eq!(soon(run).code(), 130);
}

#[test]
fn a_run_that_is_not_there_is_not_waited_for() {
    let folder = Folder::new();
    let name = unique("watched");
    let run = endless(&folder, &name, &[]);
    let watch = soon(folder.start(&["watch", "no-such-run"]));
    assert_eq!(watch.code(), 2);
    let text = watch.stderr();
    assert!(text.contains("no run is called `no-such-run`") && text.contains(&name), "{text}");
    send(&run, Signal::TERM);
    assert_eq!(soon(run).code(), 130);
}

/// The rows of docs/faults.md about the end of a run: what stands against it, what happens, the exit code of the run. Each is a
/// test of this file or of `jobs.rs`.
const ROWS: [(&str, &str, &str); 8] = [
    (
        "`ctl estop` while a swap waits for its program, 150 clients keep silent, one sends byte by byte, and another program \
         holds the lock of all runs",
        "it is answered at once, robots are halted, the run ends, its log is closed",
        "3",
    ),
    ("`ctl stop`, `ctl estop` while the run is paused or starting", "the run ends", "130, 3"),
    ("a client of the control socket that sends without an end", "its connection is closed", "as without"),
    ("a swap that waits, or is asked for, when the run is to end", "the run ends; the swap is refused", "130"),
    (
        "stderr is not read, and participants print without an end",
        "the run continues; what does not fit is dropped, and how much is printed",
        "as without",
    ),
    ("SIGTERM while processes start, also hundreds", "the run ends, no process is left", "130"),
    (
        "SIGSTOP of the orchestrator",
        "`ctl` and `top` print that it is stopped, its process id, and how to continue it; SIGCONT continues the run",
        "as without",
    ),
    (
        "`phalanx run … &`, Ctrl-Z, `bg`, `fg` in a shell",
        "the run continues; it has the keys and the mode of the terminal in the foreground only",
        "as without",
    ),
];

#[test]
fn the_rows_in_the_documentation_are_these() {
    assert_rows_of_faults(&ROWS);
}
