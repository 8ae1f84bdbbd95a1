//! A participant that fails on purpose, for the tests of what becomes of the run: `saboteur FAULT MOMENT`.
//!
//! It takes the place of any participant, `phalanx run uav --swap "plant=saboteur panic 37"`, until the
//! moment comes: `start` (before it joins the run), `connect` (after that, before it is connected), the number of a step, or
//! `end` (after the last step).

use std::fs::{self, OpenOptions};
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio, abort, exit};
use std::thread::sleep;
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FILE, run_selection, scenario_text};
use lockstep::{Fault, HEADER_BYTES, Header, Io, Participant, Period, Plan, Slice, Status, Step};
use rustix::io::FdFlags;
use rustix::process::{Pid, Signal, getpid, getppid, getuid, kill_process};
use schemes::ROLES;
use serde_json::{Value, json};

/// Where a process of a run finds what belongs to it.
const RUN_DIRECTORY: &str = "PHALANX_RUN_DIR";
/// Where it finds the number of the file that is the page of the run.
const PAGE: &str = "PHALANX_PAGE_FD";
/// What is added to the step of a sample that does not belong to this process.
const FORGED: u64 = 1_000_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fault, moment] = arguments.as_slice() else {
        eprintln!("usage: saboteur FAULT MOMENT");
        return ExitCode::from(2);
    };
    if moment == "start"
        && let Err(reason) = commit(fault)
    {
        eprintln!("{reason}");
        return ExitCode::FAILURE;
    }
    let ended = processes::serve(|plan, nodes| {
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
    let assembly =
        Assembly::load(SCENARIO_FILE, &text, &run_selection(), &ROLES).map_err(|problems| problems[0].to_string())?;
    let played = assembly.participants(nodes).map_err(|problems| problems[0].to_string())?;
    let words = |node: &usize| {
        let output = plan.network.nodes[*node].outputs.first();
        output.map_or(0, |output| plan.network.channels[output.0].layout.words())
    };
    let sabotage = |(inner, node): (Box<dyn Participant>, &usize)| {
        let (fault, at) = (fault.to_string(), moment.parse().ok());
        let agents = assembly.scenario.context.agents.len() as u32;
        let (period, words) = (plan.period, words(node));
        Box::new(Saboteur { inner, fault, at, words, period, agents }) as Box<dyn Participant>
    };
    Ok(played.into_iter().zip(nodes).map(sabotage).collect())
}

struct Saboteur {
    inner: Box<dyn Participant>,
    fault: String,
    at: Option<u64>,
    /// Size of its first output.
    words: usize,
    period: Period,
    agents: u32,
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
            "forge" => self.forge(step).map_err(Fault)?,
            fault => commit(fault).map_err(Fault)?,
        }
        Ok(())
    }
}

impl Saboteur {
    /// Writes another step into the samples of this step that other processes have published, as a stray process could.
    fn forge(&self, step: &Step) -> Result<(), String> {
        let of_agent = |agent| Header::new(step.index, self.period, agent, Status::Fresh).to_bytes();
        let genuine: Vec<[u8; HEADER_BYTES]> = (1..=self.agents).map(of_agent).collect();
        let mut forged = 0;
        for path in shared_memory()? {
            let told = |error: std::io::Error| format!("{}: {error}", path.display());
            let file = OpenOptions::new().read(true).write(true).open(&path).map_err(told)?;
            let bytes = fs::read(&path).map_err(told)?;
            for (at, window) in bytes.windows(HEADER_BYTES).enumerate() {
                if genuine.iter().any(|header| header == window) {
                    // The step stands behind the 8 bytes of the time.
                    file.write_all_at(&(step.index + FORGED).to_le_bytes(), at as u64 + 8).map_err(told)?;
                    forged += 1;
                }
            }
        }
        if forged == 0 { Err("there is no sample to forge".into()) } else { Ok(()) }
    }
}

/// The files of the run's samples.
fn shared_memory() -> Result<Vec<PathBuf>, String> {
    let directory = PathBuf::from(std::env::var(RUN_DIRECTORY).map_err(|error| error.to_string())?);
    let run = directory.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let prefix = format!("phalanx{}-{run}_", getuid().as_raw());
    let entries = fs::read_dir("/dev/shm").map_err(|error| error.to_string())?;
    let is_meant = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(&prefix) && name.ends_with(".blackboard_data")
    };
    Ok(entries.flatten().map(|entry| entry.path()).filter(is_meant).collect())
}

/// Fails now; an error is a failure that is reported.
fn commit(fault: &str) -> Result<(), String> {
    let send = |signal| kill_process(getpid(), signal).map_err(|error| error.to_string());
    match fault {
        "none" => return Ok(()),
        "exit-0" => exit(0),
        "exit-1" => exit(1),
        "panic" => panic!("something is broken"),
        "abort" => abort(),
        // The first one only takes away the handler that Rust installs.
        "segv" => send(Signal::SEGV).and_then(|()| send(Signal::SEGV))?,
        "kill" => send(Signal::KILL)?,
        "stop" => send(Signal::STOP)?,
        "pause" => {
            wake_again().map_err(|error| error.to_string())?;
            send(Signal::STOP)?;
        }
        "slow" => sleep(Duration::from_secs(20)),
        "refuse" => return Err("it does not want to".into()),
        "twice" => return start_again().map_err(|error| error.to_string()),
        "scenario" | "version" | "steps" | "plan" => return mislead(fault),
        "int-parent" => send_to_parent(Signal::INT)?,
        "term-parent" => send_to_parent(Signal::TERM)?,
        "hup-parent" => send_to_parent(Signal::HUP)?,
        "kill-parent" => send_to_parent(Signal::KILL)?,
        _ => return Err(format!("there is no fault called {fault}")),
    }
    // A signal may take a moment.
    sleep(Duration::from_millis(200));
    Ok(())
}

fn send_to_parent(signal: Signal) -> Result<(), String> {
    let parent: Pid = getppid().ok_or("there is no parent")?;
    kill_process(parent, signal).map_err(|error| error.to_string())
}

/// Starts a process that wakes this one from a stop, for as long as it lives.
fn wake_again() -> std::io::Result<()> {
    let pid = std::process::id();
    let script = format!("while [ -d /proc/{pid} ]; do sleep 0.1; kill -CONT {pid}; done");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    shell.spawn().map(drop)
}

/// Starts a second process for the same place and waits for its end. If this one has joined the run, the second one is turned
/// away; if not, the second one plays, and this one comes too late.
fn start_again() -> std::io::Result<()> {
    // The page is kept from programs that a participant starts; here the second one is to have it.
    let number = std::env::var(PAGE).map_err(std::io::Error::other)?;
    let page = OpenOptions::new().read(true).write(true).open(format!("/proc/self/fd/{number}"))?;
    rustix::io::fcntl_setfd(&page, FdFlags::empty())?;
    let mut second = Command::new(std::env::current_exe()?);
    second.args(["none", "connect"]).env(PAGE, page.as_raw_fd().to_string()).status()?;
    Ok(())
}

/// Goes on as a process that was given another run's files than those of its run.
fn mislead(fault: &str) -> Result<(), String> {
    let told = |error: std::io::Error| error.to_string();
    let genuine = PathBuf::from(std::env::var(RUN_DIRECTORY).map_err(|error| error.to_string())?);
    let elsewhere = genuine.join(format!("elsewhere-{}", std::process::id()));
    fs::create_dir(&elsewhere).map_err(told)?;
    symlink(genuine.join("iox"), elsewhere.join("iox")).map_err(told)?;
    let text = fs::read_to_string(genuine.join(SCENARIO_FILE)).map_err(told)?;
    let comment = if fault == "scenario" { "# another one\n" } else { "" };
    fs::write(elsewhere.join(SCENARIO_FILE), format!("{text}{comment}")).map_err(told)?;
    let plan = fs::read_to_string(genuine.join("plan.json")).map_err(told)?;
    let mut plan: Value = serde_json::from_str(&plan).map_err(|error| error.to_string())?;
    match fault {
        "version" => plan["format"] = json!(9999),
        "steps" => plan["steps"] = json!(1),
        "plan" => plan["run"] = json!("another"),
        _ => {}
    }
    fs::write(elsewhere.join("plan.json"), plan.to_string()).map_err(told)?;
    let mut again = Command::new(std::env::current_exe().map_err(told)?);
    Err(told(again.args(["none", "connect"]).env(RUN_DIRECTORY, &elsewhere).exec()))
}
