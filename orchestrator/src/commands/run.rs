//! `phalanx run`.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use formation::scenario::{FailurePolicy, OnFailure};
use formation::wiring::Assembly;
use lockstep::Wake;
use processes::console::{self, Dropped};
use serde_json::{Value, json};

use super::arguments::{ScenarioArgs, factor, wait_time};
use super::check::{held, players_json, show_findings, show_players};
use super::select::assemble_for;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::judge::own;
use crate::judge::verdict::Verdict;
use crate::run::control::RunControl;
use crate::run::pinning::Pin;
use crate::run::placement::Placement;
use crate::run::players::Player;
use crate::run::priority::Priority;
use crate::run::profile;
use crate::run::robots;
use crate::run::swap::{RobotSwap, Swap, check_played};
use crate::run::{Options, Outcome, run as carry_out};
use crate::terminal::{self, columns, counted, program, quoted, wrapped};
use recording::{Log, LogPlace};

/// How long an interrupted run may take to end in order.
const PATIENCE: Duration = Duration::from_millis(700);
/// Time between two looks whether its log is closed.
const LOOK: Duration = Duration::from_millis(10);

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
    /// Publish every sample, too, as iceoryx2 services for viewers and programs of your own; the run does not wait for them
    #[arg(long)]
    pub(crate) tap: bool,
    /// Put something else in the place of a participant: a program of your own, --swap controller.3=./my_controller,
    /// --swap "observer.2=python3 my_observer.py", --swap "controller.*=./mine" (a process each) or "controller.*@one=./mine" (one
    /// process); what was recorded of it, --swap controller.1=replay:LOG.mcap; a robot,
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
    /// Hold the run against the regression ranges and the thesis even if it was overridden, swapped or cut short
    #[arg(long)]
    pub(crate) strict: bool,
    /// Compute no metrics: nothing is held against the regression ranges or the thesis. Assertions are still watched
    #[arg(long, conflicts_with = "strict")]
    pub(crate) no_check: bool,
    /// Print one JSON object as the last line of stdout, and no table
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the result only: no progress, no advice; twice: no warnings either
    #[arg(short, long, action = clap::ArgAction::Count)]
    pub(crate) quiet: u8,
    /// Write what every process prints into a file of its own in this folder, and the program's own messages to phalanx.log
    #[arg(long, value_name = "DIR")]
    pub(crate) log_dir: Option<PathBuf>,
}

pub(crate) fn run(catalog: &Catalog, args: &RunArgs) -> Result<(), Failure> {
    let assembly = assemble_for(catalog, &args.scenario, &args.swap)?;
    let placement = args.placement.unwrap_or_else(|| Placement::default_of(&assembly));
    let swaps = parse_swaps(&args.swap, &assembly, placement)?;
    check_played(&assembly, &swaps)?;
    robots::check(&swaps, &assembly, args.realtime)?;
    let inputs = inputs(&args.scenario, &swaps);
    let place = if args.no_log { None } else { Some(claim(args, &assembly, &inputs)?) };
    let log = place.as_ref().map(|place| place.path().to_path_buf());
    let trace = match &args.profile {
        None => None,
        Some(None) if placement == Placement::Single && swaps.is_empty() => None,
        Some(path) => Some(path.clone().unwrap_or_else(|| default_trace(&assembly, log.as_deref()))),
    };
    if let Some(trace) = &trace {
        files::prepare(trace, inputs.iter().chain(&log))?;
    }
    if let Some(folder) = &args.log_dir {
        let names = assembly.network.nodes.iter().map(|node| node.name.as_str()).chain(["phalanx"]);
        let files = names.map(|name| folder.join(format!("{name}.log")));
        files.into_iter().try_for_each(|file| files::spare(&file, inputs.iter().chain(&log).chain(&trace)))?;
    }
    let options = Options {
        swaps,
        placement,
        pin: Pin::parse(&args.pin)?,
        progress: args.quiet == 0,
        log: log.clone(),
        place: place.clone(),
        scene: !args.no_scene,
        pace: args.realtime,
        overrun: assembly.scenario.overrun,
        trace,
        on_failure: failure_policy(args, &assembly)?,
        stress: None,
        wake: args.wake.into(),
        tap: args.tap,
        priority: Priority { priority: args.rt_priority },
        log_dir: args.log_dir.clone(),
        stand_ins: false,
    };
    if args.quiet == 0 {
        announce(&assembly, &options, place.as_ref());
    }
    let outcome = carry_out(&assembly, &options, end_on_signals)?;
    let (verdict, players) = match &outcome.log {
        Some(log) if args.no_check => (None, Log::first_step(&log.path)?.players().iter().map(Player::read).collect()),
        Some(log) => {
            let (verdict, log) =
                Verdict::read(&catalog.metrics, &assembly.scenario, &log.path, own::stream(&assembly, &log.path)?)?;
            (verdict, log.players().iter().map(Player::read).collect())
        }
        None => (None, Player::all(&options.swaps)),
    };
    let verdict = verdict.map(|verdict| held(verdict, &players, outcome.ending.reason(), args.strict));
    if args.json {
        println!("{}", to_json(&assembly, &outcome, verdict.as_ref(), &players));
    } else {
        show(&outcome, verdict.as_ref(), &players, args.quiet > 0);
        if args.profile.is_some() {
            show_profile(&outcome, options.trace.as_deref());
        }
    }
    conclude(outcome, verdict.as_ref())
}

/// The exit code of a run with this verdict.
pub(super) fn conclude(outcome: Outcome, verdict: Option<&Verdict>) -> Result<(), Failure> {
    outcome.into_result()?;
    if verdict.is_some_and(|verdict| !verdict.ok()) { Err(Failure::Missed) } else { Ok(()) }
}

/// `runs/uav-TSC.mcap`, `runs/uav-TSC+plant.mcap` where the command line swaps the plant, and `runs/uav-TSC-1f0a2c3b.mcap` with a
/// digest of the overrides where there are any, so that the run as it is in its file keeps its log.
pub(super) fn default_log(assembly: &Assembly, swaps: &[String]) -> PathBuf {
    let scenario = &assembly.scenario;
    let variant = if scenario.variant.is_empty() { String::new() } else { format!("-{}", scenario.variant) };
    let names: Vec<&str> = swaps.iter().map(|swap| swap.split('=').next().unwrap_or_default()).collect();
    let swapped = assembly.swapped(&names).unwrap_or_default();
    let names: Vec<String> = swapped.iter().map(|place| assembly.network.nodes[place.node].name.clone()).collect();
    let overridden = digest(&scenario.overrides).map_or(String::new(), |digest| format!("-{digest}"));
    Path::new("runs").join(format!("{}{variant}{overridden}{}.mcap", scenario.name, marks(&names)))
}

/// Eight digits for a list of overrides; `None` if it is empty.
fn digest(overrides: &[String]) -> Option<String> {
    (!overrides.is_empty()).then(|| format!("{:08x}", crc32fast::hash(overrides.join("\n").as_bytes())))
}

/// What the name of a log says of swapped participants: `+plant`, `+controller_3`, or `+controllers` if they are several.
fn marks(names: &[String]) -> String {
    let role = |name: &str| name.split('_').next().unwrap_or_default().to_string();
    let mut marks = String::new();
    let mut roles: Vec<String> = names.iter().map(|name| role(name)).collect();
    roles.sort_unstable();
    roles.dedup();
    for one in roles {
        let mut of_role = names.iter().filter(|name| role(name) == one);
        match (of_role.next(), of_role.next()) {
            (Some(name), None) => marks.push_str(&format!("+{name}")),
            _ => marks.push_str(&format!("+{one}s")),
        }
    }
    marks
}

/// Programs of the command line, or else of the scenario.
pub(super) fn parse_swaps(texts: &[String], assembly: &Assembly, placement: Placement) -> Result<Vec<Swap>, Failure> {
    let mut swaps = Swap::collect(assembly, texts)?;
    if placement == Placement::Single {
        // In one process, the laboratory itself does what the emulators of a scenario would do.
        let is_emulated = |swap: &Swap| matches!(swap.robot(), Some(RobotSwap::Emulated(_)));
        swaps.retain(|swap| !texts.is_empty() || !is_emulated(swap));
    }
    Ok(swaps)
}

/// The scenario's, changed by the command line.
fn failure_policy(args: &RunArgs, assembly: &Assembly) -> Result<FailurePolicy, Failure> {
    let mut policy = assembly.scenario.on_failure.clone();
    for text in &args.on_failure {
        let (name, word) = text.split_once('=').map_or((None, text.as_str()), |(name, word)| (Some(name), word));
        let expected = "expected abort, restart or hold, or NODE= and one of these";
        let what = OnFailure::named(word.trim());
        let what = what.ok_or_else(|| Failure::Usage(format!("--on-failure {text}: {expected}")))?;
        match name.map(|name| name.trim().replace('.', "_")) {
            None => (policy.others, policy.participants) = (what, Vec::new()),
            Some(name) => {
                let nodes = &assembly.network.nodes;
                let is_meant = |node: &str| node == name || node.split('_').next() == Some(&name);
                if !nodes.iter().any(|node| is_meant(&node.name)) {
                    let names: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
                    let list = names.join(", ");
                    let what = format!("--on-failure {text}: there is no such participant, expected one of {list}");
                    return Err(Failure::Usage(what));
                }
                policy.participants.push((name, what));
            }
        }
    }
    policy.deadline = args.deadline.unwrap_or(policy.deadline);
    if policy.replaces_anybody() && args.no_log {
        let why = "--no-log leaves nothing to restart a participant from: record the run, or use --on-failure abort";
        return Err(Failure::Usage(why.into()));
    }
    Ok(policy)
}

fn default_trace(assembly: &Assembly, log: Option<&Path>) -> PathBuf {
    let path = log.map_or_else(|| PathBuf::from(&assembly.scenario.name), Path::to_path_buf);
    path.with_extension("trace.json")
}

fn announce(assembly: &Assembly, options: &Options, place: Option<&LogPlace>) {
    let scenario = &assembly.scenario;
    let timing = scenario.context.timing;
    let processes = match options.placement {
        _ if options.in_one_process() => 1,
        placement => placement.workers(assembly, &options.swaps).len() + 1,
    };
    let title = if scenario.title.is_empty() { String::new() } else { format!("{}; ", scenario.title) };
    eprintln!(
        "{}: {title}{}, {}, {} s in steps of {} s",
        scenario.label(),
        counted(scenario.context.agents.len(), "agent"),
        counted(processes, "process"),
        timing.duration,
        timing.dt
    );
    if let Some(place) = place.filter(|place| place.replaces()) {
        eprintln!("the log replaces that of an earlier run, {}", place.path().display());
    }
}

/// Takes the place of the log. Without `--out`, a run beside another one takes the next free name.
fn claim(args: &RunArgs, assembly: &Assembly, inputs: &[PathBuf]) -> Result<LogPlace, Failure> {
    let usual = args.out.clone().unwrap_or_else(|| default_log(assembly, &args.swap));
    files::spare(&usual, inputs)?;
    if args.out.is_some() {
        return Ok(LogPlace::claim(&usual)?);
    }
    let place = LogPlace::claim_free(&usual)?;
    if place.path() != usual && args.quiet < 2 {
        eprintln!("another run writes {}; the log of this run is {}", usual.display(), place.path().display());
    }
    Ok(place)
}

/// Files that a run reads: its scenario, and what its swaps name.
pub(super) fn inputs(scenario: &ScenarioArgs, swaps: &[Swap]) -> Vec<PathBuf> {
    [PathBuf::from(&scenario.scenario)].into_iter().chain(swaps.iter().flat_map(Swap::inputs)).collect()
}

/// Ctrl-C, SIGTERM and SIGHUP end the run in order.
pub(super) fn end_on_signals(stop: RunControl) {
    // A second handler in one process cannot be set; a program that embeds this one has set its own then.
    let _ = ctrlc::set_handler(move || {
        stop.request();
        end_the_process(&stop);
    });
}

/// Ends the process if the run has not done so after a while. The operating system may keep the main thread for as long as it
/// likes, in the start of a process or the opening of a file; and the metrics of a long log take their time. Only the closing
/// of a log is waited for.
fn end_the_process(stop: &RunControl) {
    thread::sleep(PATIENCE);
    while !stop.may_be_abandoned() {
        thread::sleep(LOOK);
    }
    eprintln!("error: {}", Failure::Interrupted);
    terminal::printing::settle();
    std::process::exit(Failure::Interrupted.exit_code().into());
}

/// Prints the result, and unless `is_quiet`, what can be done with it.
fn show(outcome: &Outcome, verdict: Option<&Verdict>, players: &[Player], is_quiet: bool) {
    if let Some(verdict) = verdict.filter(|verdict| !verdict.rows.is_empty()) {
        println!("{}", verdict.table(columns()));
        print!("{}", verdict.summary(columns()));
    }
    // First: the assertions are then about a part of the run.
    if let Some(reason) = outcome.ending.reason() {
        let until = if outcome.findings.0.is_empty() { "" } else { " The assertions are about the time until then." };
        println!("{}", wrapped(&format!("The run ended before its time: {reason}.{until}"), columns()));
    }
    show_findings(&outcome.findings);
    show_players(players);
    let say = |text: String| println!("{}", wrapped(&text, columns()));
    say(format!(
        "{} in {:.2} s: {:.0} steps/s, {:.1} x real time, {}",
        counted(outcome.steps as usize, "step"),
        outcome.wall,
        outcome.steps_per_second(),
        outcome.simulated / outcome.wall.max(1e-9),
        counted(outcome.processes, "process")
    ));
    let Dropped { lines, bytes } = console::dropped();
    if bytes > 0 {
        say(format!(
            "stderr was not read fast enough: {lines} lines ({bytes} bytes) of participants' output were dropped"
        ));
    }
    if let Some(cores) = &outcome.cores {
        say(format!("cores: {cores}"));
    }
    if let Some(pacing) = &outcome.pacing {
        let [half, tenth, hundredth, thousandth] = pacing.quantiles.map(|delay| delay * 1e3);
        say(format!(
            "pace: {} of {} steps were late because the step before was not done, {} by more than a period; starts were late by \
             less than {half:.3} ms (50 %), {tenth:.3} (90 %), {hundredth:.3} (99 %), {thousandth:.3} (99.9 %), {:.3} at most",
            pacing.overruns,
            pacing.steps,
            pacing.beyond,
            pacing.worst * 1e3
        ));
        if pacing.skipped > 0 {
            say(format!("pace: {} periods were skipped; the run is behind the clock by as many", pacing.skipped));
        }
    }
    if let Some(log) = &outcome.log {
        let path = log.path.display();
        say(format!(
            "log: {path} ({:.1} MB, {} messages, sha256 {})",
            log.bytes as f64 / 1e6,
            log.messages,
            &log.sha256[..16]
        ));
    }
    if let Some(log) = outcome.log.as_ref().filter(|_| !is_quiet) {
        // Commands are not broken, so that one can copy them.
        let word = quoted(&log.path.display().to_string());
        let program = program();
        println!("\nNext:\n  {program} report {word}    # shows it in a browser");
        println!("  {program} check {word}     # computes this table again");
        say("Foxglove, Lichtblick, Rerun and PlotJuggler open the file as it is.".into());
    }
    // Last, so that a long table does not scroll it away.
    for finding in outcome.findings.0.iter().filter(|finding| !finding.ok()) {
        say(format!("\n{}", finding.attention()));
    }
}

pub(super) fn show_profile(outcome: &Outcome, trace: Option<&Path>) {
    println!("\n{}", profile::table(&outcome.usage, outcome.wall));
    if let Some(path) = trace {
        println!("trace of the last steps: {}; ui.perfetto.dev opens it", path.display());
    }
}

fn to_json(assembly: &Assembly, outcome: &Outcome, verdict: Option<&Verdict>, players: &[Player]) -> Value {
    let scenario = &assembly.scenario;
    json!({
        "scenario": scenario.name,
        "variant": scenario.variant,
        "steps": outcome.steps,
        "sim_s": outcome.simulated,
        "wall_s": outcome.wall,
        "steps_per_s": outcome.steps_per_second(),
        "processes": outcome.processes,
        "log": outcome.log.as_ref().map(|log| log.path.display().to_string()),
        "sha256": outcome.log.as_ref().map(|log| log.sha256.clone()),
        "ending": outcome.ending.word(),
        "metrics": verdict.map(Verdict::to_json),
        "not_held": verdict.and_then(|verdict| verdict.not_held.clone()),
        "replaced": outcome.replaced,
        "players": players_json(players),
        "dropped_output": console::dropped().bytes,
        "assertions": outcome.findings.to_json(),
        "overruns": outcome.pacing.map(|pacing| pacing.overruns),
        "pace": outcome.pacing.map(|pacing| json!({
            "steps": pacing.steps, "overruns": pacing.overruns, "beyond_period": pacing.beyond,
            "skipped": pacing.skipped,
            "late_s": {
                "p50": pacing.quantiles[0], "p90": pacing.quantiles[1], "p99": pacing.quantiles[2],
                "p99.9": pacing.quantiles[3], "max": pacing.worst,
            },
        })),
        "ok": outcome.ending.is_whole() && outcome.findings.ok() && verdict.is_none_or(Verdict::ok),
    })
}

#[cfg(test)]
mod tests {
    use super::marks;

    #[test]
    fn a_name_says_who_was_swapped() {
        let marks = |names: &[&str]| marks(&names.iter().map(|name| name.to_string()).collect::<Vec<_>>());
        assert_eq!(marks(&[]), "");
        assert_eq!(marks(&["plant", "controller_3"]), "+controller_3+plant");
        assert_eq!(marks(&["controller_3", "observer_1", "controller_1"]), "+controllers+observer_1");
    }
}
