//! The program `phalanx` with one more command, `trial misbehave FAULT`: a controller that breaks its contract on purpose.

use std::fs::{File, OpenOptions};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use formation::wiring::{Assembly, SCENARIO_FILE, run_selection, scenario_text};
use lockstep::{Fault, Io, Participant, Plan, Slice, Step};
use schemes::ROLES;

/// Before a participant does anything wrong, it does some steps right.
const SOME_STEPS: u64 = 30;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().collect();
    match words.get(1..) {
        Some([command, fault]) if command == "misbehave" => misbehave(fault),
        _ => orchestrator::cli::main(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS)),
    }
}

fn misbehave(fault: &str) -> ExitCode {
    let directory = std::env::var_os("PHALANX_RUN_DIR").map(PathBuf::from);
    match (fault, &directory) {
        ("silent-alone", None) => return ExitCode::SUCCESS,
        ("any-plan", Some(directory)) if Plan::read(directory).is_err() => return ExitCode::SUCCESS,
        _ => {}
    }
    let code = processes::serve(|plan, nodes| build(fault, plan, nodes));
    match fault {
        "deaf" if directory.is_some() => sleep_forever(),
        "other-code" if code == ExitCode::SUCCESS => ExitCode::from(3),
        _ => code,
    }
}

fn sleep_forever() -> ! {
    loop {
        std::thread::sleep(Duration::from_secs(600));
    }
}

fn build(fault: &str, plan: &Plan, nodes: &[usize]) -> Result<Vec<Box<dyn Participant>>, String> {
    let text = scenario_text()?;
    let loaded = Assembly::load(SCENARIO_FILE, &text, &run_selection(), &ROLES);
    let assembly = loaded.map_err(|problems| problems[0].to_string())?;
    if assembly.network != plan.network && fault != "any-signals" {
        return Err("the signals are not mine".into());
    }
    match fault {
        "no-start" => sleep_forever(),
        "leaves-a-child" => {
            std::process::Command::new("sleep").arg("600").spawn().map_err(|error| error.to_string())?;
        }
        _ => {}
    }
    let inner = assembly.participants(nodes).map_err(|problems| problems[0].to_string())?.remove(0);
    let node = &plan.network.nodes[nodes[0]];
    let words = |channel: lockstep::ChannelId| plan.network.channels[channel.0].layout.words();
    Ok(vec![Box::new(Misbehaving {
        fault: fault.into(),
        inner,
        input: Slice::new(0, 0, words(node.inputs[0].channel)),
        output: Slice::new(0, 0, words(node.outputs[0])),
    })])
}

/// Does what the controller of the scenario does, and something wrong.
struct Misbehaving {
    fault: String,
    inner: Box<dyn Participant>,
    input: Slice,
    output: Slice,
}

impl Participant for Misbehaving {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let late = step.index >= SOME_STEPS;
        if self.fault == "stops-writing" && late {
            return Ok(());
        }
        if self.fault == "brittle" && io.slice(self.input).iter().any(|word| word.abs() > 1e100) {
            sleep_forever();
        }
        self.inner.step(step, io)?;
        match self.fault.as_str() {
            "exits" if late => std::process::exit(0),
            "aborts" if late => std::process::abort(),
            "hangs" if late => sleep_forever(),
            "nan" if late => io.slice_mut(self.output)[0] = f64::NAN,
            // Another number in every process.
            "random" if late => io.slice_mut(self.output)[0] += f64::from(std::process::id()),
            "chatters" => println!("step {}: {}", step.index, "all is well ".repeat(80)),
            "scribbles" if step.index == SOME_STEPS => scribble(io.slice(self.input)[0]),
            _ => {}
        }
        Ok(())
    }
}

/// Replaces `number` in all shared memory of the run by another one.
fn scribble(number: f64) {
    let directory = PathBuf::from(std::env::var_os("PHALANX_RUN_DIR").expect("a run"));
    let run = directory.file_name().expect("a name").to_string_lossy().into_owned();
    let is_of_run = |path: &PathBuf| path.is_file() && path.to_string_lossy().contains(&run);
    let shared = std::fs::read_dir("/dev/shm").expect("shared memory").flatten().map(|entry| entry.path());
    shared.filter(is_of_run).for_each(|path| replace(&path, number));
}

fn replace(path: &Path, number: f64) {
    let Ok(file) = OpenOptions::new().read(true).write(true).open(path) else { return };
    let bytes = std::fs::read(path).unwrap_or_default();
    let pattern = number.to_le_bytes();
    let places = bytes.windows(8).enumerate().filter(|(_, window)| *window == pattern);
    places.for_each(|(at, _)| write(&file, at, number + 1.0));
}

fn write(file: &File, at: usize, number: f64) {
    file.write_all_at(&number.to_le_bytes(), at as u64).expect("shared memory can be written");
}
