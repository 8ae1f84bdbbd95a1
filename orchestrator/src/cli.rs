//! The command line.

mod documents;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
pub use documents::reference;
use documents::{SCHEMA_HELP, after_help, program};
use formation::config::readable;
use processes::console;

use crate::catalog::Catalog;
use crate::commands;
use crate::failure::Failure;
use crate::logging;
use crate::run::leftovers;
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
    List(commands::list::ListArgs),
    /// Run a scenario, record it, and check what comes out
    Run(commands::run::RunArgs),
    /// Check a scenario without running it
    Validate(commands::validate::ValidateArgs),
    /// Show the processes of a scenario, what they exchange, and in which order they run
    Graph(commands::graph::GraphArgs),
    /// Compute all metrics of a log and compare them with their regression ranges and the thesis
    Check(commands::check::CheckArgs),
    /// Run every scenario with every variant and compare all numbers with their regression ranges, claims and published values
    #[command(visible_alias = "thesis")]
    Campaign(commands::campaign::CampaignArgs),
    /// Show what is in a log
    Info(commands::info::InfoArgs),
    /// Show what the links between agents did in a run, beside what was asked of them
    Links(commands::links::LinksArgs),
    /// Compare two logs bit by bit, or run a scenario in many ways and compare what comes out
    Verify(commands::verify::VerifyArgs),
    /// Run one participant of a recorded run again, against the recording of the others, and show where it departs
    Replay(commands::replay::ReplayArgs),
    /// Write a small project for a participant of your own, with the signals of a scenario
    New(commands::new::NewArgs),
    /// Try whether a program of yours keeps the contract of a participant
    Conform(commands::conform::ConformArgs),
    /// Pause, step, resume or stop a run from another terminal
    Ctl(commands::ctl::CtlArgs),
    /// Show how fast a run is, and where its processes spend their time
    Top(commands::top::TopArgs),
    /// Run a scenario and show where its time goes: which participants compute, which wait, and for which; with a trace for Perfetto
    Profile(commands::profile::ProfileArgs),
    /// Show a run live: the formation and its errors, in the terminal or in a browser
    Watch(commands::watch::WatchArgs),
    /// Write a report that shows runs in a browser, or figures for a paper
    Report(commands::report::ReportArgs),
    /// Write the signals of a log as CSV, Parquet, NumPy or MATLAB files
    Export(commands::export::ExportArgs),
    /// Write a layout for Foxglove, Lichtblick, PlotJuggler or Rerun
    Layout(commands::layout::LayoutArgs),
    /// Print the values of a topic
    Echo(commands::echo::EchoArgs),
    /// Draw signals of a log in the terminal
    Plot(commands::plot::PlotArgs),
    /// Play a robot and the cameras above it at the other end of real sockets
    Robot(commands::robot::RobotArgs),
    /// Close the log of a killed run, so that every tool opens it
    Recover(commands::recover::RecoverArgs),
    /// Remove what dead runs left in shared memory
    Doctor(commands::doctor::DoctorArgs),
    /// Write the completions of a shell to stdout
    Completions {
        /// Which shell
        shell: Shell,
    },
    /// Write the manual pages into a folder
    Man(commands::man::ManArgs),
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
    Participant(commands::participant::ParticipantArgs),
    /// Watch over a program under trial (started by `conform`, not by hand)
    #[command(hide = true)]
    Supervise(commands::conform::SuperviseArgs),
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
            eprintln!("{}", shown.trim_end());
            return ExitCode::from(Failure::Usage(String::new()).exit_code());
        }
        error.exit()
    })
}

/// Runs the program and returns its exit code.
pub fn main(catalog: &Catalog) -> ExitCode {
    terminal::name_program();
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
        // Without it, a file that grows beyond `ulimit -f` ends the program; with it, writing fails with an error.
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
        Command::Links(args) => commands::links::links(catalog, &args),
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
            clap_complete::generate(shell, &mut Cli::command(), terminal::program(), &mut script);
            print!("{}", String::from_utf8_lossy(&script));
            Ok(())
        }
        Command::Robot(args) => commands::robot::robot(catalog, &args),
        Command::Man(args) => commands::man::man(&args, program()),
        Command::Schema => commands::schema::schema(catalog),
        Command::Bridge { settings } => return commands::bridge::bridge(&settings),
        Command::Participant(args) => return commands::participant::participant(catalog, &args),
    };
    let result = match (result, terminal::printing::finish()) {
        // The results did not arrive, so the command has failed.
        (Ok(()) | Err(Failure::Missed | Failure::Different | Failure::Nonconforming), Some(error)) => {
            Err(Failure::Unwritten(error.to_string()))
        }
        (result, _) => result,
    };
    let code = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::Missed | Failure::Different | Failure::Nonconforming) {
                eprintln!("error: {}", terminal::in_own_name(&sentence(&failure)));
            }
            if let Some(advice) = failure.advice() {
                eprintln!("help: {}", terminal::in_own_name(advice));
            }
            ExitCode::from(failure.exit_code())
        }
    };
    terminal::printing::settle();
    code
}
