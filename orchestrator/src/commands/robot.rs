//! `phalanx robot`: a stand-in for a robot and the cameras above it, at the other end of real sockets.

use std::io::{Read, Write};
use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use formation::config::Problem;
use formation::scenario::{Scenario, Selection};
use hardware::Options;
use hardware::settings::{Emulator, Settings};
use plant::Laboratory;
use plant::laboratory::is_emulated;

use super::select::{add_present, data_source, find};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::run::priority::lock_memory_if_wanted;
use crate::run::robots::LISTENS;

#[derive(Debug, Args)]
#[command(after_help = "\
Two ways to say which robot it is:
  phalanx robot robot2.toml                            the file has a section [emulator]
  phalanx robot --scenario compensated --agent 2       a robot of a scenario; prints the address at which it listens
The controller decides whether time passes by itself or with its commands (clock in robot.toml).")]
pub(crate) struct RobotArgs {
    /// A robot.toml with a section [emulator]
    #[arg(required_unless_present = "scenario", conflicts_with = "scenario")]
    pub(crate) file: Option<PathBuf>,
    /// Name of a shipped scenario or path of a scenario file: vehicle, start and disturbance are those of its agent
    #[arg(long, requires = "agent")]
    pub(crate) scenario: Option<String>,
    /// Number of the agent, from 1; also the number of the robot
    #[arg(long, requires = "scenario")]
    pub(crate) agent: Option<u32>,
    /// Variant of the scenario
    #[arg(long, requires = "scenario")]
    pub(crate) variant: Option<String>,
    /// Change a field of the scenario: --set NAME=VALUE; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing
    #[arg(long, value_name = "NAME=VALUE", requires = "scenario")]
    pub(crate) set_if_present: Vec<String>,
    /// TCP address at which it listens for its controller; port 0 takes any
    #[arg(long, default_value = "127.0.0.1:0", conflicts_with = "file")]
    pub(crate) listen: SocketAddr,
    /// Write the true poses, which no controller sees, as CSV: t, x, y, theta, v1, v2, v3 at every tick
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) record: Option<PathBuf>,
    /// Do not report connections and the reasons for halts
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// End when stdin is closed
    #[arg(long, hide = true)]
    pub(crate) attached: bool,
}

pub(crate) fn robot(catalog: &Catalog, args: &RobotArgs) -> Result<(), Failure> {
    lock_memory_if_wanted();
    if args.attached {
        end_with_stdin();
    }
    let job = match &args.file {
        Some(file) => from_file(&Settings::load(file)?, &file.display().to_string())?,
        None => from_arguments(args),
    };
    let scenario = job.scenario(catalog)?;
    let context = &scenario.context;
    // By its number; one that is not there may be the number that it has in the file, where the command line chose some agents.
    let wanted = job.emulator.agent;
    let by_number = || context.agents.iter().position(|agent| agent.number == wanted);
    let by_id = || context.agents.iter().position(|agent| agent.id == wanted);
    let agent = by_number().or_else(by_id).ok_or_else(|| {
        let count = context.agents.len();
        Failure::Usage(format!("{} has no agent {}; it has {count}", scenario.name, job.emulator.agent))
    })?;
    if !is_emulated(&context.agents[agent].vehicle) {
        return Err(Failure::Usage(format!(
            "agent {} of {} cannot be emulated: there is a model of robots with wheel speeds only (omni, order 1)",
            job.emulator.agent, scenario.name
        )));
    }
    let laboratory = job.emulator.laboratory.clone().or_else(|| Laboratory::of(&scenario)).unwrap_or_default();
    if let Some((field, message)) = laboratory.findings().first() {
        return Err(Failure::Usage(format!("laboratory: {field}: {message}")));
    }
    if let Some(record) = &args.record {
        files::prepare(record, args.file.clone().into_iter().chain(args.scenario.iter().map(PathBuf::from)))?;
    }
    let options = Options {
        body: job.body,
        listen: job.listen,
        poses: job.poses,
        watchdog: job.emulator.watchdog,
        record: args.record.clone(),
        verbose: !args.quiet,
    };
    let announce = |address| {
        println!("robot {} {LISTENS}{address}", options.body);
        // The process that waits for the line may have ended.
        let _ = std::io::stdout().flush();
    };
    let failed = format!("play robot {} at {}", options.body, options.listen);
    hardware::serve(&options, &laboratory, context, agent, announce).map_err(Failure::system(failed))
}

/// What is to be played.
struct Job {
    body: u32,
    listen: SocketAddr,
    poses: Option<SocketAddr>,
    emulator: Emulator,
    selection: Selection,
    /// Overrides of fields that only some variants have.
    if_present: Vec<String>,
}

impl Job {
    fn scenario(&self, catalog: &Catalog) -> Result<Scenario, Failure> {
        let (file, text) = find(catalog, &self.emulator.scenario)?;
        let mut selection = self.selection.clone();
        selection.data = data_source(catalog, &self.emulator.scenario);
        add_present(catalog, &file, &text, &mut selection, &self.if_present)?;
        Ok(Scenario::load(&file, &text, &selection)?)
    }
}

fn from_file(settings: &Settings, name: &str) -> Result<Job, Failure> {
    let Some(emulator) = settings.emulator.clone() else {
        let message = "missing section `[emulator]`: it says which robot of which scenario to play";
        return Err(vec![Problem::new(None, name, message)].into());
    };
    let poses = Some(settings.mocap).filter(|address| address.port() != 0);
    let (body, listen) = (settings.body, settings.robot);
    Ok(Job { body, listen, poses, emulator, selection: Selection::default(), if_present: Vec::new() })
}

fn from_arguments(args: &RobotArgs) -> Job {
    let agent = args.agent.unwrap_or(1);
    let emulator = Emulator {
        scenario: args.scenario.clone().unwrap_or_default(),
        agent,
        watchdog: hardware::settings::EMULATOR_WATCHDOG,
        laboratory: None,
    };
    let selection = Selection { variant: args.variant.clone(), overrides: args.set.clone(), ..Selection::default() };
    let if_present = args.set_if_present.clone();
    Job { body: agent, listen: args.listen, poses: None, emulator, selection, if_present }
}

/// Ends this program when the other end of its stdin is closed.
fn end_with_stdin() {
    std::thread::spawn(|| {
        let mut byte = [0];
        while std::io::stdin().read(&mut byte).is_ok_and(|count| count > 0) {}
        std::process::exit(0);
    });
}
