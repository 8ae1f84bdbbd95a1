//! A participant that fails on purpose, for the tests of what becomes of the run: `saboteur FAULT MOMENT`.
//!
//! It plays whatever participant it is put in the place of, `phalanx run uav --swap "plant=saboteur panic 37"`, until the
//! moment comes: `connect` (before it is connected), the number of a step, or `end` (after the last step).

use std::process::{ExitCode, abort, exit};
use std::thread::sleep;
use std::time::Duration;

use formation::scenario::Selection;
use formation::wiring::{Assembly, SCENARIO_FILE, scenario_text};
use lockstep::{Fault, Io, Participant, Plan, Slice, Step};
use orchestrator::catalog::ROLES;
use rustix::process::{Signal, getpid, kill_process};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fault, moment] = arguments.as_slice() else {
        eprintln!("usage: saboteur FAULT MOMENT");
        return ExitCode::from(2);
    };
    let ended = lockstep::serve(|plan, nodes| {
        if moment == "connect" {
            commit(fault)?;
        }
        participants(plan, nodes, fault, moment)
    });
    if moment == "end"
        && let Err(reason) = commit(fault)
    {
        eprintln!("{reason}");
    }
    ended
}

fn participants(plan: &Plan, nodes: &[usize], fault: &str, moment: &str) -> Result<Vec<Box<dyn Participant>>, String> {
    let text = scenario_text()?;
    let assembly = Assembly::load(SCENARIO_FILE, &text, &Selection::default(), &ROLES)
        .map_err(|problems| problems[0].to_string())?;
    let played = assembly.participants(nodes).map_err(|problems| problems[0].to_string())?;
    let words = |node: &usize| {
        let output = plan.network.nodes[*node].outputs.first();
        output.map_or(0, |output| plan.network.channels[output.0].layout.words())
    };
    let sabotage = |(inner, node): (Box<dyn Participant>, &usize)| {
        let (fault, at) = (fault.to_string(), moment.parse().ok());
        Box::new(Saboteur { inner, fault, at, words: words(node) }) as Box<dyn Participant>
    };
    Ok(played.into_iter().zip(nodes).map(sabotage).collect())
}

struct Saboteur {
    inner: Box<dyn Participant>,
    fault: String,
    at: Option<u64>,
    /// Size of its first output.
    words: usize,
}

impl Participant for Saboteur {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.inner.step(step, io)?;
        if self.at != Some(step.index) {
            return Ok(());
        }
        match self.fault.as_str() {
            "nan" => io.slice_mut(Slice::new(0, 0, self.words))[0] = f64::NAN,
            "infinity" => io.slice_mut(Slice::new(0, 0, self.words))[0] = f64::INFINITY,
            fault => commit(fault).map_err(Fault)?,
        }
        Ok(())
    }
}

/// Fails now; an error is a failure that is told.
fn commit(fault: &str) -> Result<(), String> {
    let send = |signal| kill_process(getpid(), signal).map_err(|error| error.to_string());
    match fault {
        "exit-0" => exit(0),
        "exit-1" => exit(1),
        "panic" => panic!("something is broken"),
        "abort" => abort(),
        // The first one only takes away the handler that Rust installs.
        "segv" => send(Signal::SEGV).and_then(|()| send(Signal::SEGV))?,
        "kill" => send(Signal::KILL)?,
        "stop" => send(Signal::STOP)?,
        "slow" => sleep(Duration::from_secs(20)),
        "refuse" => return Err("it does not want to".into()),
        _ => return Err(format!("there is no fault called {fault}")),
    }
    // A signal may take a moment.
    sleep(Duration::from_millis(200));
    Ok(())
}
