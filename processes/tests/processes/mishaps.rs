//! Whatever goes wrong is told with its name, and nothing is left.

use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use lockstep::{Local, Plan};
use processes::{Conductor, Death, RunDirectory, RunError, Settings};
use rustix::process::{Pid, Signal, kill_process};

use crate::chain;
use crate::support::{
    PLAY, Traces, all_ways, eventually, launch, settings, shared_files, singles, start, step_to_error, this_binary,
    workers,
};
use crate::worker::participant;

/// Number of the node and worker that mishaps happen to.
const VICTIM: usize = 10;
const VICTIM_NAME: &str = "controller_3";

fn start_chain(name: &str, settings: Settings, play: &str) -> Conductor {
    start(name, &chain::network(chain::AGENTS), &singles(&chain::network(chain::AGENTS)), u64::MAX, settings, play)
}

fn signal(pid: u32, signal: Signal) {
    kill_process(Pid::from_raw(pid as i32).unwrap(), signal).unwrap();
}

/// Runs a chain to its error, which must come soon after `mishap`, and expects nothing to be left.
fn error_after(name: &str, settings: Settings, play: &str, mishap: impl FnOnce(u32) + Send) -> RunError {
    let mut conductor = start_chain(name, settings, play);
    let traces = Traces::of(&conductor);
    let victim = conductor.pid(VICTIM).unwrap();
    let error = std::thread::scope(|scope| {
        scope.spawn(move || {
            std::thread::sleep(Duration::from_millis(30));
            mishap(victim);
        });
        step_to_error(&mut conductor)
    });
    assert!(matches!(conductor.step(), Err(RunError::Over { .. })), "a failed run goes on");
    conductor.finish().unwrap();
    traces.assert_none();
    error
}

#[test]
fn a_killed_worker_is_named_at_once() {
    for settings in all_ways() {
        let (sender, receiver) = std::sync::mpsc::channel();
        let error = error_after("killed", settings, "chain", move |pid| {
            sender.send(Instant::now()).unwrap();
            signal(pid, Signal::KILL);
        });
        // Includes the orderly end of the thirteen others.
        assert!(receiver.recv().unwrap().elapsed() < Duration::from_secs(2));
        let RunError::Died { worker, death, step, .. } = &error else { panic!("{error}") };
        assert_eq!((worker.as_str(), *death), (VICTIM_NAME, Death::Signal(9)));
        assert!(step.is_some());
        assert!(error.to_string().contains("SIGKILL"), "{error}");
    }
}

#[test]
fn a_worker_that_exits_is_named_with_its_last_lines() {
    let error = error_after("exits", settings(), "exit:10:40", |_| {});
    let RunError::Died { worker, death, step, phase, last_lines, .. } = error else { panic!("{error}") };
    assert_eq!((worker.as_str(), death, step, phase), (VICTIM_NAME, Death::Exit(3), Some(40), Some(3)));
    assert!(last_lines.ends_with(&["first line".into(), "second line".into()]), "{last_lines:?}");
}

#[test]
fn a_number_that_is_not_finite_is_named() {
    let error = error_after("nan", settings(), "nan:10:77", |_| {});
    assert_eq!(error.to_string(), "controller_3 at step 77: output /controller_3: value[5] is NaN");
}

#[test]
fn one_process_tells_the_same() {
    let network = chain::network(chain::AGENTS);
    let groups = singles(&network);
    let plan = Plan::new("local", network.clone(), 1_000_000, 100, workers(&network, &groups)).unwrap();
    let participants = (0..chain::NODES).map(|node| participant("nan:10:77", &plan, node)).collect();
    let mut local = Local::new(network, participants, plan.dt).unwrap();
    let error = (0..100).find_map(|_| local.step().err()).unwrap();
    assert_eq!(error.to_string(), "controller_3 at step 77: output /controller_3: value[5] is NaN");
}

#[test]
fn of_two_faults_in_a_phase_that_of_the_first_node_is_told() {
    for _ in 0..5 {
        let error = error_after("faults", settings(), "fault:13+10+12:77", |_| {});
        assert_eq!(error.to_string(), "controller_3 at step 77: the reference is out of reach");
    }
}

#[test]
fn a_fault_is_told_as_it_was_said() {
    for settings in all_ways() {
        let error = error_after("fault", settings, "fault:10:77", |_| {});
        assert_eq!(error.to_string(), "controller_3 at step 77: the reference is out of reach");
    }
}

#[test]
fn a_step_that_is_asked_for_too_early_is_a_fault() {
    let error = error_after("hasty", settings(), "hasty:77", |_| {});
    let expected = "controller_3 at step 77: the next step was asked for before this one was done";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_panic_is_a_fault() {
    let error = error_after("panic", settings(), "panic:10:77", |_| {});
    let RunError::Fault { node, step, message } = error else { panic!("{error}") };
    assert_eq!((node.as_str(), step), (VICTIM_NAME, 77));
    assert!(message.starts_with("panicked at ") && message.ends_with("an index of 17 is out of range"), "{message}");
}

#[test]
fn a_stopped_worker_is_named_after_the_deadline() {
    for settings in all_ways() {
        let settings = Settings { deadline: Duration::from_millis(300), ..settings };
        let error = error_after("stopped", settings, "chain", |pid| signal(pid, Signal::STOP));
        let RunError::Deadline { late, phase, waited, .. } = &error else { panic!("{error}") };
        assert_eq!((late.len(), late[0].worker.as_str(), late[0].state, *phase), (1, VICTIM_NAME, 'T', 3));
        assert!(*waited >= Duration::from_millis(300) && *waited < Duration::from_secs(2), "{waited:?}");
        assert!(error.to_string().contains("stopped"), "{error}");
    }
}

#[test]
fn an_interrupt_ends_a_step_that_does_not_end() {
    for settings in all_ways() {
        let mut conductor = start_chain("interrupt", settings, "chain");
        let traces = Traces::of(&conductor);
        let (interrupt, victim) = (conductor.interrupt(), conductor.pid(VICTIM).unwrap());
        let late = interrupt.clone();
        let raised = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(30));
            signal(victim, Signal::STOP);
            std::thread::sleep(Duration::from_millis(30));
            interrupt.raise();
            Instant::now()
        });
        let error = step_to_error(&mut conductor);
        assert!(raised.join().unwrap().elapsed() < Duration::from_secs(1));
        assert!(matches!(error, RunError::Interrupted { .. }), "{error}");
        // Without `finish`.
        drop(conductor);
        traces.assert_none();
        // An interrupt that comes after the end does nothing, and leaves nothing either.
        late.raise();
        drop(late);
        traces.assert_none();
    }
}

#[test]
fn a_worker_that_refuses_is_quoted() {
    let mut conductor = launch(
        "refuse",
        &chain::network(chain::AGENTS),
        &singles(&chain::network(chain::AGENTS)),
        10,
        settings(),
        "refuse",
    );
    let traces = Traces::of(&conductor);
    let error = conductor.wait_ready(Duration::from_secs(60)).unwrap_err();
    assert_eq!(error.to_string(), "observer_2 cannot start: there is no such observer");
    drop(conductor);
    traces.assert_none();
}

#[test]
fn a_worker_that_does_not_connect_is_named() {
    let settings = Settings { grace: Duration::from_millis(100), ..settings() };
    let mut conductor =
        launch("late", &chain::network(chain::AGENTS), &singles(&chain::network(chain::AGENTS)), 10, settings, "late");
    let traces = Traces::of(&conductor);
    let error = conductor.wait_ready(Duration::from_secs(5)).unwrap_err();
    let RunError::NotReady { missing, .. } = &error else { panic!("{error}") };
    assert_eq!(missing.iter().map(|late| late.worker.as_str()).collect::<Vec<_>>(), ["observer_2"]);
    drop(conductor);
    traces.assert_none();
}

#[test]
fn a_start_that_is_given_up_leaves_nothing() {
    let conductor = launch(
        "given-up",
        &chain::network(chain::AGENTS),
        &singles(&chain::network(chain::AGENTS)),
        10,
        settings(),
        "chain",
    );
    let traces = Traces::of(&conductor);
    drop(conductor);
    traces.assert_none();
}

#[test]
fn no_other_user_may_look_into_a_run() {
    for settings in all_ways() {
        let conductor = start_chain("private", settings, "chain");
        let mut paths = shared_files(conductor.directory().name());
        assert!(!paths.is_empty());
        // Below its directory, the modes do not matter: no other user gets in.
        paths.push(conductor.directory().path().to_path_buf());
        paths.push(conductor.directory().path().join("plan.json"));
        let open: Vec<_> = paths.iter().filter(|path| fs::metadata(path).unwrap().mode() & 0o077 != 0).collect();
        assert!(open.is_empty(), "{open:?}");
    }
}

/// Not a test: the conductor process that is killed by the next one.
#[test]
fn conductor_entry() {
    if std::env::var_os(PLAY).is_some() {
        let mut conductor = start_chain("doomed", settings(), "chain");
        let traces = Traces::of(&conductor);
        println!("\nrun {} {}", conductor.directory().name(), conductor.pid(VICTIM).unwrap());
        let _ = step_to_error(&mut conductor);
        traces.assert_none();
    }
}

#[test]
fn what_a_killed_conductor_left_is_swept_and_nothing_else() {
    let mut command = this_binary("mishaps::conductor_entry");
    let mut doomed = command.env(PLAY, "conduct").stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(doomed.stdout.take().unwrap()).lines().map(|line| line.unwrap());
    let line = lines.find(|line| line.starts_with("run ")).expect("it says its name");
    let mut words = line.split(' ').skip(1);
    let (run, victim) = (words.next().unwrap(), words.next().unwrap());
    let mut living = start_chain("living", settings(), "chain");
    assert!(!RunDirectory::sweep().removed.contains(&run.to_string()));

    doomed.kill().unwrap();
    doomed.wait().unwrap();
    eventually("its workers die", || !Path::new("/proc").join(victim).exists());
    let directory = living.directory().path().with_file_name(run);
    assert!(directory.exists() && !shared_files(run).is_empty(), "it should have left something");
    assert!(RunDirectory::sweep().removed.contains(&run.to_string()));
    assert!(!directory.exists() && shared_files(run).is_empty());

    assert_eq!(living.step().unwrap(), 0);
    living.finish().unwrap();
}
