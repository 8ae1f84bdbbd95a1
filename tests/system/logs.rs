//! Logs are the user's data: no command destroys one, and what was recorded is in it.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use recording::{Log, Unfinished};
use rustix::process::{Pid, Signal, kill_process};

use crate::program::{Finished, Folder, assert_rows_of_faults, children, unique, wait_until};
use crate::shortage::in_namespace;
use crate::stopping::renamed;

const PROGRAM: &str = env!("CARGO_BIN_EXE_phalanx");

/// An emulated robot.
const ROBOT: &str = "\
body = 1
robot = \"127.0.0.1:0\"
mocap = \"127.0.0.1:0\"
[emulator]
scenario = \"compensated\"
agent = 1
";

/// Runs a shell script in the folder.
fn shell(folder: &Folder, script: &str) -> Finished {
    let mut command = Command::new("bash");
    command.args(["-c", script]).current_dir(folder.path("")).env_remove("LD_LIBRARY_PATH").stdin(Stdio::null());
    Finished(command.output().expect("a shell"))
}

fn wait(child: Child) -> Finished {
    Finished(child.wait_with_output().expect("an end"))
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).expect("a file")
}

/// Names in a folder, those of temporary files, too.
fn names(path: &Path) -> Vec<String> {
    let entries = fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Starts a run that goes on for long enough, and waits until its log has steps.
fn long_run(folder: &Folder, arguments: &[&str], log: &str) -> Child {
    let run = folder.start(&[&["run"], arguments, &["--duration", "3600", "--realtime"]].concat());
    wait_until("the log has steps", || Log::outline(&folder.path(log)).is_ok_and(|log| log.steps().end > 2));
    run
}

fn stop(run: Child) -> Finished {
    kill_process(Pid::from_raw(run.id() as i32).expect("a process id"), Signal::TERM).expect("a running program");
    wait(run)
}

#[test]
fn two_runs_at_once_have_two_logs() {
    let folder = Folder::new();
    let name = unique("pair");
    let scenario = renamed(&folder, "triangle", &name);
    let log = format!("runs/{name}.mcap");
    // The duration is in the file, since overrides would give the logs other names.
    let text = std::fs::read_to_string(folder.path(&scenario)).expect("a scenario");
    let lasting = |duration: &str| {
        let changed = text.replacen("duration = 20", &format!("duration = {duration}"), 1);
        assert!(changed != text || duration == "20", "{text}");
        folder.write(&scenario, &changed);
    };
    lasting("3600");
    let first = folder.start(&["run", &scenario, "-q", "--placement", "single", "--realtime"]);
    wait_until("the log has steps", || Log::outline(&folder.path(&log)).is_ok_and(|log| log.steps().end > 2));
    lasting("1");
    let second = folder.run(&["run", &scenario, "-q", "--placement", "single"]);
    assert_eq!(second.code(), 0, "{}", second.stderr());
    let next = format!("runs/{name}-2.mcap");
    assert!(second.stderr().contains(&format!("another run writes {log}; the log of this run is {next}")));
    assert!(second.stdout().contains(&format!("log: {next} (")), "{}", second.stdout());
    let third = folder.run(&["run", &scenario, "-q", "--placement", "single", "--json"]);
    assert_eq!(third.json()["log"], format!("runs/{name}-3.mcap"), "an earlier log is not replaced for it");
    let refused = folder.run(&["run", &scenario, "-q", "--out", &log]);
    assert_eq!((refused.code(), refused.stdout().as_str()), (2, ""));
    let writer = format!("process {} (phalanx run {scenario}", first.id());
    assert!(refused.stderr().contains(&log) && refused.stderr().contains(&writer), "{}", refused.stderr());
    let recovered = folder.run(&["recover", &log, "--out", "x.mcap"]);
    assert!(recovered.code() == 2 && recovered.stderr().contains("its run goes on"), "{}", recovered.stderr());
    assert_eq!(stop(first).code(), 130);
    for log in [&log, &next] {
        assert_eq!(Log::outline(&folder.path(log)).expect("a log").unfinished(), None);
    }
    assert_eq!(names(&folder.path("runs")).len(), 3);
}

#[test]
fn the_lock_of_a_log_ends_with_its_holder() {
    let folder = Folder::new();
    let scenario = renamed(&folder, "triangle", &unique("lock"));
    let mut run = long_run(&folder, &[&scenario, "-q", "--placement", "single", "--out", "a.mcap"], "a.mcap");
    run.kill().expect("a running program");
    run.wait().expect("an end");
    assert_eq!(Log::outline(&folder.path("a.mcap")).expect("a log").unfinished(), Some(Unfinished::Cut));
    let again = folder.run(&["run", &scenario, "-q", "--duration", "1", "--placement", "single", "--out", "a.mcap"]);
    assert_eq!(again.code(), 0, "{}", again.stderr());
}

#[test]
fn a_run_without_a_step_leaves_the_earlier_log() {
    let folder = Folder::new();
    let first = folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    assert_eq!(first.code(), 0, "{}", first.stderr());
    let before = read(&folder, "a.mcap");
    let check = |what: &str, run: Finished, codes: &[i32]| {
        assert!(codes.contains(&run.code()), "{what}: {}\n{}", run.code(), run.stderr());
        assert!(read(&folder, "a.mcap") == before, "{what}: the log is another one");
        assert_eq!(names(&folder.path("")), ["a.mcap"], "{what}");
    };
    let run = |more: &[&str]| folder.run(&[&["run", "triangle", "-q", "--out", "a.mcap"], more].concat());
    check("a program that ends at once", run(&["--swap", "controller.2=false"]), &[3]);
    check("a scenario that is not valid", run(&["--set", "nonsense=1"]), &[2]);
    let limited = |limit: u32| {
        let script = format!("ulimit -n {limit}; {PROGRAM} run triangle -q --placement processes --out a.mcap");
        let end = shell(&folder, &script);
        assert!(end.stderr().contains("`ulimit -n 4096` allows more"), "{limit} descriptors: {}", end.stderr());
        check(&format!("{limit} descriptors"), end, &[2, 3, 4, 5]);
    };
    [10, 20, 40].into_iter().for_each(limited);
    let script = format!("mount -t tmpfs -o size=16k none /dev/shm && {PROGRAM} run triangle -q --out a.mcap");
    if let Some(end) = in_namespace(&folder, &script) {
        check("/dev/shm is full", end, &[3, 5]);
    }
}

#[test]
fn no_output_takes_the_place_of_an_input() {
    let folder = Folder::new();
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    folder.write("mine.toml", &folder.run(&["validate", "triangle", "--print"]).stdout());
    folder.write("robot.toml", ROBOT);
    for input in ["a.mcap", "mine.toml", "robot.toml"] {
        symlink(input, folder.path(&format!("link-{input}"))).expect("a link");
        fs::hard_link(folder.path(input), folder.path(&format!("hard-{input}"))).expect("a link");
    }
    let inputs = ["a.mcap", "mine.toml", "robot.toml"].map(|name| (name, read(&folder, name)));
    let commands: [(&str, &[&str]); 14] = [
        ("mine.toml", &["run", "mine.toml", "-q", "--out"]),
        ("mine.toml", &["run", "mine.toml", "-q", "--no-log", "--placement", "processes", "--profile"]),
        ("a.mcap", &["run", "triangle", "-q", "--duration", "1", "--swap", "plant=replay:a.mcap", "--out"]),
        ("mine.toml", &["profile", "mine.toml", "-q", "--trace"]),
        ("mine.toml", &["profile", "mine.toml", "-q", "--out"]),
        ("a.mcap", &["profile", "a.mcap", "-q", "--trace"]),
        ("a.mcap", &["replay", "a.mcap", "--only", "plant", "--out"]),
        ("a.mcap", &["recover", "a.mcap", "--out"]),
        ("a.mcap", &["report", "a.mcap", "--out"]),
        ("a.mcap", &["layout", "a.mcap", "--for", "foxglove", "--out"]),
        ("a.mcap", &["export", "a.mcap", "--format", "npz", "--out"]),
        ("a.mcap", &["export", "a.mcap", "--format", "mat", "--out"]),
        ("mine.toml", &["layout", "mine.toml", "--for", "foxglove", "--out"]),
        ("robot.toml", &["robot", "robot.toml", "--record"]),
    ];
    for (input, command) in commands {
        for output in [input.to_string(), format!("link-{input}"), format!("hard-{input}")] {
            let run = folder.run(&[command, &[output.as_str()]].concat());
            let stderr = run.stderr();
            assert_eq!(run.code(), 2, "{command:?} {output}: {stderr}");
            assert!(stderr.contains("name another file"), "{command:?} {output}: {stderr}");
        }
    }
    for (name, bytes) in inputs {
        assert!(read(&folder, name) == bytes, "{name} is another file");
        assert!(read(&folder, &format!("hard-{name}")) == bytes, "{name} is another file");
    }
    assert_eq!(names(&folder.path("")).len(), 9);
}

#[test]
fn nothing_but_a_log_gives_way_to_a_log_and_a_log_only_to_a_log() {
    let folder = Folder::new();
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "b.mcap"]);
    let before = read(&folder, "b.mcap");
    folder.write("thesis.tex", "\\chapter{}");
    let run = folder.run(&["run", "triangle", "-q", "--out", "thesis.tex"]);
    assert!(run.code() == 2 && run.stderr().contains("a file of another kind"), "{}", run.stderr());
    assert_eq!(read(&folder, "thesis.tex"), b"\\chapter{}");
    for command in
        [&["report", "a.mcap", "--out", "b.mcap"][..], &["export", "a.mcap", "--format", "npz", "--out", "b.mcap"]]
    {
        let run = folder.run(command);
        assert!(run.code() == 5 && run.stderr().contains("it is a log, which would be lost"), "{}", run.stderr());
    }
    assert!(read(&folder, "b.mcap") == before);
    // A folder of output files, one of which leads to a log.
    fs::create_dir(folder.path("out")).expect("a folder");
    symlink("../b.mcap", folder.path("out/plant.log")).expect("a link");
    let run = folder.run(&["run", "triangle", "-q", "--duration", "1", "--no-log", "--log-dir", "out"]);
    assert_eq!(run.code(), 0, "{}", run.stderr());
    assert!(read(&folder, "b.mcap") == before);
    let run = folder.run(&["run", "out/plant.log", "-q", "--no-log", "--log-dir", "out"]);
    assert_eq!(run.code(), 2, "{}", run.stderr());
}

#[test]
fn where_a_log_would_grow_nothing_of_the_user_is_touched() {
    let folder = Folder::new();
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    let before = read(&folder, "a.mcap");
    fs::write(folder.path("x.mcap"), &before).expect("a log");
    fs::hard_link(folder.path("a.mcap"), folder.path(".x.mcap.part")).expect("a link");
    for command in [&["recover", "a.mcap"][..], &["replay", "a.mcap", "--only", "plant"], &["run", "triangle", "-q"]] {
        let run = folder.run(&[command, &["--out", "x.mcap"]].concat());
        assert!(run.code() == 2 && run.stderr().contains("x.mcap"), "{command:?}: {} {}", run.code(), run.stderr());
        assert!(read(&folder, "a.mcap") == before && read(&folder, "x.mcap") == before, "{command:?}");
    }
}

#[test]
fn a_log_that_another_file_replaces_during_its_run_is_told() {
    let folder = Folder::new();
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "other.mcap"]);
    let scenario = renamed(&folder, "triangle", &unique("moved"));
    let run = long_run(&folder, &[&scenario, "-q", "--placement", "single", "--out", "a.mcap"], "a.mcap");
    fs::rename(folder.path("other.mcap"), folder.path("a.mcap")).expect("another log");
    let end = stop(run);
    assert!(end.code() == 4 && end.stderr().contains("another file has taken its place"), "{}", end.stderr());
}

#[test]
fn outputs_are_tried_before_a_long_command() {
    let folder = Folder::new();
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    let before = read(&folder, "a.mcap");
    fs::create_dir(folder.path("pages")).expect("a folder");
    symlink("../a.mcap", folder.path("pages/phalanx-run.1")).expect("a link");
    let endless = ["triangle", "--duration", "3600", "--realtime", "-q", "--placement", "processes", "--out", "a.mcap"];
    for command in [
        &[&["run"], &endless[..], &["--profile", "nowhere/trace.json"]].concat()[..],
        &["profile", "triangle", "-q", "--trace", "a.mcap"],
        &["campaign", "triangle", "--out", "nowhere/table.md"],
        &["robot", "--scenario", "compensated", "--agent", "2", "--record", "a.mcap"],
        &["man", "pages"],
    ] {
        let run = folder.run(command);
        assert_eq!(run.code(), 5, "{command:?}: {}", run.stderr());
        assert!(read(&folder, "a.mcap") == before, "{command:?}");
    }
}

#[test]
fn outputs_that_are_no_files_work_or_are_refused_at_once() {
    let folder = Folder::new();
    let made = shell(&folder, "mkfifo fifo && mkdir folder");
    assert_eq!(made.code(), 0);
    for output in ["fifo", "folder", "/dev/null", "/dev/full", "/dev/stdout", "/dev/stderr"] {
        // A run of this length would not come to its end.
        let run = folder.run(&["run", "triangle", "-q", "--duration", "3600", "--realtime", "--out", output]);
        assert!(run.code() == 2 && run.stderr().contains(output), "{output}: {}\n{}", run.code(), run.stderr());
    }
    let redirected = format!("{PROGRAM} run triangle -q --duration 3600 --realtime --out /dev/stdout > table.txt");
    let run = shell(&folder, &redirected);
    assert!(run.code() == 2 && run.stderr().contains("what the program prints goes there"), "{}", run.stderr());
    folder.run(&["run", "triangle", "-q", "--duration", "1", "--out", "a.mcap"]);
    let report = |output: &str| folder.run(&["report", "a.mcap", "--out", output]);
    assert_eq!(report("/dev/null").code(), 0);
    assert_eq!(report("/dev/full").code(), 5);
    let waiting = report("fifo");
    assert!(waiting.code() == 5 && waiting.stderr().contains("no process reads"), "{}", waiting.stderr());
    let read_by = format!("cat fifo > copy.html & {PROGRAM} report a.mcap --out fifo && wait && wc -c < copy.html");
    // `cat` may open the FIFO a moment later.
    let mut end = shell(
        &folder,
        &format!("cat fifo > copy.html & sleep 1; {PROGRAM} report a.mcap --out fifo; wait; wc -c < copy.html"),
    );
    if end.code() != 0 {
        end = shell(&folder, &read_by);
    }
    let bytes = end.stdout().lines().last().and_then(|line| line.trim().parse::<u64>().ok());
    assert!(bytes > Some(100_000), "{}{}", end.stdout(), end.stderr());
}

#[test]
fn results_that_cannot_be_written_are_an_error() {
    let folder = Folder::new();
    for command in
        ["run triangle -q --duration 1 --json --out a.mcap", "list", "info a.mcap --json", "schema", "check a.mcap"]
    {
        let end = shell(&folder, &format!("{PROGRAM} {command} > /dev/full"));
        assert_eq!(end.code(), 5, "{command}: {}", end.stderr());
        assert!(
            end.stderr().contains("cannot write the results to stdout: No space left"),
            "{command}: {}",
            end.stderr()
        );
    }
    assert_eq!(Log::outline(&folder.path("a.mcap")).expect("a log").unfinished(), None);
    let end = shell(&folder, &format!("set -o pipefail; {PROGRAM} list | true; {PROGRAM} schema | head -c 1"));
    assert!([0, 141].contains(&end.code()) && end.stderr().is_empty(), "{}: {}", end.code(), end.stderr());
}

#[test]
fn a_limit_of_the_size_of_files_is_told_and_the_log_closed() {
    let folder = Folder::new();
    for kilobytes in [300, 1000] {
        let run = format!("ulimit -f {kilobytes}; {PROGRAM} run triangle -q --duration 1000 --out a.mcap");
        let end = shell(&folder, &run);
        assert_eq!(end.code(), 4, "{}", end.stderr());
        let stderr = end.stderr();
        assert!(stderr.contains("a.mcap: File too large") && stderr.contains("help: `ulimit -f`"), "{stderr}");
        let log = Log::outline(&folder.path("a.mcap")).expect("a log");
        assert!(log.unfinished().is_none() && log.steps().end > 10, "{:?} {:?}", log.unfinished(), log.steps());
        fs::remove_file(folder.path("a.mcap")).expect("a log");
    }
    let nothing = shell(
        &folder,
        &format!("ulimit -f 16; {PROGRAM} run triangle -q --placement single --duration 1000 --out c.mcap"),
    );
    assert!(nothing.code() == 4 && nothing.stderr().contains("File too large"), "{}", nothing.stderr());
    assert!(Log::outline(&folder.path("c.mcap")).expect("a log").unfinished().is_none());
    let slow = format!("ulimit -f 300; {PROGRAM} run uav -q --realtime --duration 1000 --out b.mcap");
    let end = shell(&folder, &slow);
    assert!(end.code() == 4 && end.stderr().contains("File too large"), "{}", end.stderr());
    let log = Log::outline(&folder.path("b.mcap")).expect("a log");
    assert!(log.unfinished().is_none() && log.steps().end > 2, "{:?} {:?}", log.unfinished(), log.steps());
}

#[test]
fn recorded_steps_are_in_the_file_while_a_later_one_hangs() {
    let folder = Folder::new();
    let scenario = renamed(&folder, "triangle", &unique("hang"));
    let arguments = [&scenario, "-q", "--placement", "processes", "--deadline", "600", "--out", "a.mcap"];
    let mut run = long_run(&folder, &arguments, "a.mcap");
    let participant = *children(run.id()).last().expect("a participant");
    kill_process(Pid::from_raw(participant as i32).expect("a process id"), Signal::STOP).expect("a participant");
    let done = || {
        let status = folder.run(&["ctl", "status", scenario.trim_end_matches(".toml"), "--json"]);
        status.json()["steps"].as_u64().expect("a number of steps")
    };
    // Until the step that hangs has been reached.
    let mut before = 0;
    wait_until("the run hangs", || {
        std::thread::sleep(std::time::Duration::from_millis(200));
        let now = done();
        std::mem::replace(&mut before, now) == now
    });
    let steps = done();
    wait_until("all steps that are done are in the file", || {
        Log::outline(&folder.path("a.mcap")).is_ok_and(|log| log.steps().end >= steps)
    });
    run.kill().expect("a running program");
    run.wait().expect("an end");
    let recovered = folder.run(&["recover", "a.mcap", "--out", "b.mcap"]);
    let text = recovered.stdout();
    assert!(text.contains("Steps that had not reached the file are missing"), "{text}");
    assert!(Log::outline(&folder.path("b.mcap")).expect("a log").steps().end >= steps);
}

#[test]
fn a_full_disk_takes_no_recorded_step_away() {
    let folder = Folder::new();
    fs::create_dir(folder.path("disk")).expect("a folder");
    let script = format!(
        "mount -t tmpfs -o size=700k none disk || exit 99
         {PROGRAM} run uav --realtime 2 --duration 20 -qq --out disk/a.mcap >/dev/null & run=$!
         most=0
         while kill -0 $run 2>/dev/null; do
             steps=$({PROGRAM} info disk/a.mcap 2>/dev/null | sed -n 's/.*samples *\\([0-9]*\\) steps.*/\\1/p')
             [ \"${{steps:-0}}\" -gt $most ] && most=$steps
         done
         wait $run; code=$?
         {PROGRAM} recover disk/a.mcap --out b.mcap >/dev/null
         {PROGRAM} info b.mcap | sed -n 's/.*samples *\\([0-9]*\\) steps.*/\\1/p'
         echo $most $code"
    );
    let Some(end) = in_namespace(&folder, &script) else { return };
    let numbers: Vec<u64> = end.stdout().split_whitespace().map(|word| word.parse().expect("a number")).collect();
    let [kept, most, code] = numbers[..] else { panic!("{}{}", end.stdout(), end.stderr()) };
    assert!(
        code == 4 && most > 20 && kept >= most,
        "{kept} steps are kept, {most} were seen; {code}\n{}",
        end.stderr()
    );
}

/// What docs/faults.md says about logs.
const ROWS: [(&str, &str, &str); 13] = [
    (
        "a run that records no step: a program that ends at once, /dev/shm full, too few descriptors, an invalid scenario",
        "the earlier log of the name stays",
        "2, 3, 4 or 5",
    ),
    (
        "two runs of one scenario at once",
        "the second takes the next free name, `runs/uav-TSC-2.mcap`, and says so",
        "0",
    ),
    ("a run with the `--out` of an active run", "nothing is started; the process that writes is named", "2"),
    ("`phalanx recover` of the log of an active run", "it is refused", "2"),
    (
        "an output that is an input of the command: scenario, log, robot file, program; by path, symbolic or hard link",
        "it is refused",
        "2",
    ),
    ("a log in the place of a file that is no log", "nothing is started", "2"),
    ("another output in the place of a log", "it is refused", "5"),
    ("a log to a FIFO, a device, a folder, or where stdout goes", "nothing is started", "2"),
    ("another output to a FIFO or a device", "it is written; a FIFO that no process reads is refused", "0, 5"),
    ("results that cannot be written, `--json > /dev/full`", "the run is complete, its log is closed", "5"),
    ("SIGKILL while a step hangs", "the log holds every complete step except those of the last 50 ms", "-"),
    (
        "the disk of the log is full",
        "the run ends with an error; every step in the file stays; the log is closed if there is room for its end",
        "4",
    ),
    ("the size of files is limited (`ulimit -f`)", "the run ends with an error; the log is closed", "4"),
];

#[test]
fn the_rows_in_the_documentation_are_these() {
    assert_rows_of_faults(&ROWS);
}
