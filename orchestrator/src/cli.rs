//! The command line.

mod documents;
mod engine;
mod look;
mod player;
mod profile;
mod robot;
mod watch;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
pub use documents::reference;
pub(crate) use documents::{ManArgs, program};
use documents::{SCHEMA_HELP, after_help};
pub(crate) use engine::{CtlArgs, CtlCommand, TopArgs, VerifyArgs};
use engine::{factor, wait_time};
use formation::config::readable;
use lockstep::Wake;
pub(crate) use look::{EchoArgs, ExportArgs, LayoutArgs, PlotArgs, ReportArgs};
pub(crate) use player::{ConformArgs, NewArgs, NewRole, ParticipantArgs, ReplayArgs, SuperviseArgs};
use processes::console;
pub(crate) use profile::ProfileArgs;
pub(crate) use robot::RobotArgs;
pub(crate) use watch::WatchArgs;

use crate::catalog::Catalog;
use crate::commands;
use crate::failure::Failure;
use crate::logging;
use crate::run::leftovers;
use crate::run::placement::Placement;
use crate::terminal;

/// Lockstep co-simulation of formation control: planner, controllers, observers and plant as processes of their own.
#[derive(Debug, Parser)]
#[command(name = "phalanx", version, after_help = after_help(), arg_required_else_help = true)]
pub struct Cli {
    /// Say more on stderr: -v what the program does, -vv in detail, -vvv everything
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Which messages to show, by level or module, such as `info` or `orchestrator::run::engine=debug`; also PHALANX_LOG
    #[arg(long, global = true, value_name = "FILTER")]
    log_filter: Option<String>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// List the scenarios that come with the program, with their variants
    List(ListArgs),
    /// Run a scenario, record it, and check what comes out
    Run(RunArgs),
    /// Check a scenario without running it
    Validate(ValidateArgs),
    /// Show the processes of a scenario, what they exchange, and in which order they run
    Graph(GraphArgs),
    /// Compute all metrics of a log and compare them with their bands
    Check(CheckArgs),
    /// Run every scenario with every variant and compare all numbers with their bands, claims and published values
    #[command(visible_alias = "thesis")]
    Campaign(CampaignArgs),
    /// Show what is in a log
    Info(InfoArgs),
    /// Compare two logs bit by bit, or run a scenario in many ways and compare what comes out
    Verify(VerifyArgs),
    /// Run one participant of a recorded run again, against the recording of the others, and show where it departs
    Replay(ReplayArgs),
    /// Write a small project for a participant of your own, with the signals of a scenario
    New(NewArgs),
    /// Try whether a program of yours keeps the contract of a participant
    Conform(ConformArgs),
    /// Pause, step, resume or stop a run from another terminal
    Ctl(CtlArgs),
    /// Show how fast a run is, and where its processes spend their time
    Top(TopArgs),
    /// Run a scenario and show where its time goes: who computes, who waits, for whom; and a trace for Perfetto
    Profile(ProfileArgs),
    /// Show a run live: the formation and its errors, in the terminal or in a browser
    Watch(WatchArgs),
    /// Write a report that shows runs in a browser, or figures for a paper
    Report(ReportArgs),
    /// Write the signals of a log as CSV, Parquet, NumPy or MATLAB files
    Export(ExportArgs),
    /// Write a layout for Foxglove, Lichtblick, PlotJuggler or Rerun
    Layout(LayoutArgs),
    /// Print the values of a topic
    Echo(EchoArgs),
    /// Draw signals of a log in the terminal
    Plot(PlotArgs),
    /// Play a robot and the cameras above it at the other end of real sockets
    Robot(RobotArgs),
    /// Close the log of a killed run, so that every tool opens it
    Recover(RecoverArgs),
    /// Remove what dead runs left in shared memory
    Doctor(DoctorArgs),
    /// Write the completions of a shell to stdout
    Completions {
        /// Which shell
        shell: Shell,
    },
    /// Write the manual pages into a folder
    Man(ManArgs),
    /// Print the JSON Schema of scenario files, for editors
    #[command(after_help = SCHEMA_HELP)]
    Schema,
    /// Serve as the bridge to a robot in a run (started by `run`, not by hand)
    #[command(hide = true)]
    Bridge {
        /// Its robot.toml
        settings: PathBuf,
    },
    /// Serve as a process of a run (started by `run`, not by hand)
    #[command(hide = true)]
    Participant(ParticipantArgs),
    /// Watch over a program under trial (started by `conform`, not by hand)
    #[command(hide = true)]
    Supervise(SuperviseArgs),
}

/// A scenario and what is changed about it.
#[derive(Debug, Clone, Default, Args)]
pub struct ScenarioArgs {
    /// Name of a shipped scenario (see `phalanx list`) or path of a scenario file
    pub scenario: String,
    /// Variant to run, as listed by `phalanx list`
    #[arg(long)]
    pub variant: Option<String>,
    /// Change a field: `--set controller.c_p=3`, `--set agents.2.position=[1,2,0]`, `--set phase=0.5`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// The same for a field that only some variants have: in the others it does nothing. A field that no variant has is an
    /// error
    #[arg(long, value_name = "NAME=VALUE")]
    pub set_if_present: Vec<String>,
    /// Length of a step in s; short for --set timing.dt=...
    #[arg(long, value_name = "SECONDS")]
    pub dt: Option<String>,
    /// Length of the run in s; short for --set timing.duration=...
    #[arg(long, value_name = "SECONDS")]
    pub duration: Option<String>,
    /// Seed of all random numbers; short for --set seed=...
    #[arg(long)]
    pub seed: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// List the components that scenarios can name instead
    #[arg(long)]
    pub(crate) components: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What the processes of a run wake each other with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Waking {
    /// Futexes on shared memory, as Linux has them
    Futex,
    /// Events of iceoryx2, for systems without such futexes; slower
    Events,
}

impl From<Waking> for Wake {
    fn from(waking: Waking) -> Self {
        match waking {
            Waking::Futex => Self::Futex,
            Waking::Events => Self::Events,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// Where the log goes [default: runs/<scenario>-<variant>.mcap]
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
    /// Record nothing and check nothing
    #[arg(long, conflicts_with = "out")]
    pub(crate) no_log: bool,
    /// Record the signals only, without the messages (/tf, /scene/..., /rosout) from which viewers draw the formation
    #[arg(long, conflicts_with = "no_log")]
    pub(crate) no_scene: bool,
    /// How the participants are spread over processes; changes no bit of the result [default: groups if the scenario has
    /// any, else processes]
    #[arg(long, value_enum)]
    pub(crate) placement: Option<Placement>,
    /// Cores of the processes: `auto` (one core that no other run has taken; more if what the participants compute is worth
    /// the wake-ups, which is measured), `none` (the operating system decides) or the number of a core
    #[arg(long, default_value = "auto")]
    pub(crate) pin: String,
    /// What the processes wake each other with; changes no bit of the result
    #[arg(long, value_enum, default_value_t = Waking::Futex)]
    pub(crate) wake: Waking,
    /// Keep pace with the clock: so many simulated seconds per second
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "1", value_parser = factor)]
    pub(crate) realtime: Option<f64>,
    /// Let the processes of the run go before all others: SCHED_FIFO with this priority, and memory that is not swapped, where
    /// the system permits it
    #[arg(long, value_name = "1...99", value_parser = clap::value_parser!(u8).range(1..=99))]
    pub(crate) rt_priority: Option<u8>,
    /// Print where the time went, and write the last steps as a trace for ui.perfetto.dev [default: <log>.trace.json]
    #[arg(long, value_name = "TRACE.json", num_args = 0..=1)]
    pub(crate) profile: Option<Option<PathBuf>>,
    /// Publish every sample, too, as iceoryx2 services for viewers and programs of your own; nobody waits for them
    #[arg(long)]
    pub(crate) tap: bool,
    /// Put something else in the place of a participant: a program of your own, --swap controller.3=./my_controller,
    /// --swap "observer.2=python3 my_observer.py"; what was recorded of it, --swap controller.1=replay:LOG.mcap; a robot,
    /// --swap plant.2=hardware:robot2.toml; or an emulated one, --swap plant.2=emulator (emulator:free if its time passes by
    /// itself). May be repeated; the section [swap] of a scenario says the same
    #[arg(long, value_name = "NODE=COMMAND|replay:LOG|hardware:FILE")]
    pub(crate) swap: Vec<String>,
    /// What to do when a participant fails: `abort`, `restart` (started anew, and the log does not show it) or `hold` (its
    /// last sample stands, marked as stale); for all, or as NODE=POLICY such as controller.3=restart; may be repeated
    #[arg(long, value_name = "[NODE=]POLICY")]
    pub(crate) on_failure: Vec<String>,
    /// How long a step may wait for a participant before it counts as failed, s [default: 10, or the scenario's]
    #[arg(long, value_name = "SECONDS", value_parser = wait_time)]
    pub(crate) deadline: Option<f64>,
    /// Hold the bands of the scenario against the run even if it was overridden, swapped or cut short
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print one JSON object as the last line of stdout, and no table
    #[arg(long)]
    pub(crate) json: bool,
    /// Show no progress; twice: no warnings either
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub(crate) quiet: u8,
    /// Write what every process prints into a file of its own in this folder, and the program's own messages to phalanx.log
    #[arg(long, value_name = "DIR")]
    pub(crate) log_dir: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the effective scenario, with variant and overrides applied, as TOML
    #[arg(long, conflicts_with = "json")]
    pub(crate) print: bool,
}

/// How a graph is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GraphFormat {
    /// For a terminal
    Text,
    /// For Markdown that renders Mermaid
    Mermaid,
    /// For Graphviz
    Dot,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct GraphArgs {
    #[command(flatten)]
    pub(crate) scenario: ScenarioArgs,
    /// How the graph is written
    #[arg(long, value_enum, default_value_t = GraphFormat::Text)]
    pub(crate) format: GraphFormat,
    /// Same as --format json
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// Hold the bands of the scenario against the run even if it was overridden, swapped or cut short
    #[arg(long)]
    pub(crate) strict: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// For a terminal
    Text,
    /// For a document
    Markdown,
    /// For programs
    Json,
}

#[derive(Debug, Args)]
pub(crate) struct CampaignArgs {
    /// Names of scenarios (see `phalanx list`) [default: all]
    pub(crate) scenarios: Vec<String>,
    /// How the tables are written
    #[arg(long, value_enum, default_value_t = TableFormat::Text)]
    pub(crate) format: TableFormat,
    /// Same as --format json
    #[arg(long)]
    pub(crate) json: bool,
    /// Where the tables go [default: stdout]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// Print the scenario that the log holds, with all overrides, as TOML
    #[arg(long, conflicts_with = "json")]
    pub(crate) scenario: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RecoverArgs {
    /// The log of a killed run
    pub(crate) log: PathBuf,
    /// Where the closed log goes [default: <log>-recovered.mcap]
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl Command {
    /// Whether it first removes what dead runs have left: those that start runs. What only reads, or talks to a run, does not
    /// depend on what stands in shared memory.
    fn is_to_sweep(&self) -> bool {
        matches!(
            self,
            Command::Run(_)
                | Command::Profile(_)
                | Command::Replay(_)
                | Command::Verify(_)
                | Command::Campaign(_)
                | Command::Conform(_)
        )
    }

    /// Whether it is started by a run, which reads what it prints.
    fn is_part(&self) -> bool {
        matches!(self, Command::Participant(_) | Command::Bridge { .. } | Command::Supervise(_))
    }
}

/// What a failure says. Problems of a scenario show lines of files as they are, and shorten the rest themselves.
fn sentence(failure: &Failure) -> String {
    match failure {
        Failure::Invalid(_) => failure.to_string(),
        other => readable(&other.to_string()),
    }
}

/// The command line, or what is wrong with it and the exit code.
fn parsed() -> Result<Cli, ExitCode> {
    Cli::try_parse().map_err(|error| {
        let text = error.render().to_string();
        let shown = readable(&text);
        if error.use_stderr() && shown != text {
            eprint!("{shown}");
            return ExitCode::from(Failure::Usage(String::new()).exit_code());
        }
        error.exit()
    })
}

/// Runs the program and returns its exit code.
pub fn main(catalog: &Catalog) -> ExitCode {
    let cli = match parsed() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let (quiet, directory) = match &cli.command {
        Command::Run(args) => (args.quiet, args.log_dir.as_deref()),
        _ => (0, None),
    };
    let choice = logging::Choice { verbose: cli.verbose, quiet, filter: cli.log_filter.as_deref(), directory };
    // A participant starts a stream of its own, for the pipe that the orchestrator reads.
    if !matches!(cli.command, Command::Participant(_) | Command::Bridge { .. })
        && let Err(failure) = logging::start(&choice)
    {
        eprintln!("error: {failure}");
        return ExitCode::from(failure.exit_code());
    }
    if !cli.command.is_part() {
        console::start();
        // Without it, a file that grows beyond `ulimit -f` ends the program; with it, writing fails, and the error is told.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    }
    if cli.command.is_to_sweep() {
        leftovers::sweep_silently();
    }
    let result = match cli.command {
        Command::List(args) => commands::list::list(catalog, &args),
        Command::Run(args) => commands::run::run(catalog, &args),
        Command::Validate(args) => commands::validate::validate(catalog, &args),
        Command::Graph(args) => commands::graph::graph(catalog, &args),
        Command::Check(args) => commands::check::check(catalog, &args),
        Command::Campaign(args) => commands::campaign::campaign(catalog, &args),
        Command::Info(args) => commands::info::info(&args),
        Command::Verify(args) => commands::verify::verify(catalog, &args),
        Command::New(args) => commands::new::new(catalog, &args),
        Command::Conform(args) => commands::conform::conform(catalog, &args),
        Command::Supervise(args) => return commands::conform::supervise(&args),
        Command::Replay(args) => commands::replay::replay(catalog, &args),
        Command::Ctl(args) => commands::ctl::ctl(&args),
        Command::Top(args) => commands::top::top(&args),
        Command::Profile(args) => commands::profile::profile(catalog, &args),
        Command::Watch(args) => commands::watch::watch(catalog, &args),
        Command::Report(args) => commands::report::report(catalog, &args),
        Command::Export(args) => commands::export::export(&args),
        Command::Layout(args) => commands::layout::layout(catalog, &args),
        Command::Echo(args) => commands::echo::echo(&args),
        Command::Plot(args) => commands::plot::plot(&args),
        Command::Recover(args) => commands::recover::recover(&args),
        Command::Doctor(args) => commands::doctor::doctor(&args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "phalanx", &mut script);
            print!("{}", String::from_utf8_lossy(&script));
            Ok(())
        }
        Command::Robot(args) => commands::robot::robot(catalog, &args),
        Command::Man(args) => commands::man::man(&args),
        Command::Schema => commands::schema::schema(catalog),
        Command::Bridge { settings } => return commands::bridge::bridge(&settings),
        Command::Participant(args) => return commands::participant::participant(catalog, &args),
    };
    let result = match (result, terminal::printing::finish()) {
        // What was asked for did not arrive, whatever it says.
        (Ok(()) | Err(Failure::Missed | Failure::Different | Failure::Nonconforming), Some(error)) => {
            Err(Failure::Unwritten(error.to_string()))
        }
        (result, _) => result,
    };
    let code = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::Missed | Failure::Different | Failure::Nonconforming) {
                eprintln!("error: {}", sentence(&failure));
            }
            if let Some(advice) = failure.advice() {
                eprintln!("help: {advice}");
            }
            ExitCode::from(failure.exit_code())
        }
    };
    terminal::printing::settle();
    code
}
