//! `phalanx replay`.

use std::path::Path;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use clap::Args;
use formation::scenario::Selection;
use formation::wiring::{Assembly, EXTERNAL, Role};
use processes::Settings;
use serde_json::{Value, json};

use super::arguments::not_negative;
use super::check::players_json;
use super::select::from_head;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::files;
use crate::run::control::RunControl;
use crate::run::pinning::Pin;
use crate::run::players::Player;
use crate::run::priority::Priority;
use crate::run::robots::{self, Robots};
use crate::run::swap::{Swap, node_called, own_program};
use crate::terminal::table::{Left, Right, Table};
use crate::terminal::{columns, plain};
use crate::trial::replay::{Departures, Outcome, ReplaySetup, rerun};
use recording::Log;

/// What asks for the component of Phalanx where a log names another player.
const BUILTIN: &str = "builtin";
/// How long both processes may take to connect.
const START_TIMEOUT: Duration = Duration::from_secs(30);

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// A log that `phalanx run` recorded
    pub(crate) log: PathBuf,
    /// The participant that is run again; all others are played from the log: controller.3, plant
    #[arg(long, value_name = "NODE")]
    pub(crate) only: String,
    /// What is run in its place [default: our own component of the scenario in the log]: a program of yours,
    /// --swap controller.3=./my_controller, what another log holds of it, --swap controller.3=replay:LOG.mcap, or a robot, --swap
    /// plant.2=hardware:robot2.toml
    #[arg(long, value_name = "NODE=COMMAND|replay:LOG")]
    pub(crate) swap: Option<String>,
    /// Take numbers for equal that are no further apart than this; if the recorded number is larger than 1, than this times
    /// the number
    #[arg(long, value_name = "NUMBER", default_value = "0", value_parser = not_negative)]
    pub(crate) tolerance: f64,
    /// Record the new run
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn replay(catalog: &Catalog, args: &ReplayArgs) -> Result<(), Failure> {
    // A recorded plant of all agents can be compared with that of one.
    let selection = Selection { swapped_plants: vec![args.only.clone()], ..Selection::default() };
    let assembly = from_head(catalog, &args.log, &selection)?;
    let names: Vec<&str> = assembly.network.nodes.iter().map(|node| node.name.as_str()).collect();
    let node = node_called(&args.only, &names);
    let node = node.map_err(|reason| Failure::Usage(format!("--only {}: {reason}", args.only)))?;
    let log = Log::outline(&args.log)?;
    if log.steps().is_empty() {
        let path = args.log.display();
        return Err(Failure::Usage(format!("{path} holds no complete step; there is nothing to compare with")));
    }
    let played: Vec<Player> = log.players().iter().map(Player::read).filter(|one| one.participant == node).collect();
    let swap = match &args.swap {
        None if played.is_empty() => None,
        None => return Err(ask(&node, &args.log, &played)),
        Some(text) if is_builtin(text, &node, &names)? => None,
        Some(text) => Some(swap_of(text, &node, &assembly)?),
    };
    // Links have no role.
    let place = names.iter().position(|name| *name == node).and_then(|place| assembly.nodes.get(place));
    if let (None, Some(place)) = (&swap, place) {
        refuse_external(&assembly, place.role, &node)?;
    }
    let player = swap.as_ref().and_then(|swap| Player::of(swap, 0));
    remark_on_changes(&played, player.as_ref());
    robots::check(swap.as_slice(), &assembly, Some(1.0))?;
    if let Some(out) = &args.out {
        files::spare(out, swap.iter().flat_map(Swap::inputs).chain([args.log.clone()]))?;
    }
    let affinity = Pin::Auto.take()?;
    let setup = ReplaySetup {
        assembly: &assembly,
        network: &assembly.network,
        log: &args.log,
        only: names.iter().position(|name| *name == node).unwrap_or_default(),
        robot: swap.as_ref().filter(|swap| swap.robot().is_some()),
        factor: 1.0,
        settings: Settings::default(),
        start_timeout: START_TIMEOUT,
        traced: 0,
        core: affinity.core,
    };
    let program = own_program()?;
    let mut robots = Robots::default();
    let command = |directory: &Path| match &swap {
        Some(swap) => robots.bridge(&program, directory, swap, Priority::default()),
        None => Ok(own_participant(&program)),
    };
    let stop = RunControl::new();
    let on_signal = stop.clone();
    // A second handler in one process cannot be set; a program that embeds this one has set its own then.
    let _ = ctrlc::set_handler(move || on_signal.request());
    let players: Vec<Player> = match args.out {
        Some(_) => cast_of(&names, &node, &args.log, player.clone()),
        None => Vec::new(),
    };
    let out = args.out.as_deref().map(|path| (path, players.as_slice()));
    let outcome = rerun(&setup, command, args.tolerance, out, &stop)?;
    if args.json {
        println!("{}", to_json(&node, &outcome, &played, player.as_ref()));
    } else {
        println!("{}", text_of(&node, &args.log, &outcome));
    }
    match outcome.stopped {
        Some(error) => Err(error.into()),
        None if outcome.departures.is_equal() => Ok(()),
        None => Err(Failure::Different),
    }
}

/// Asks for what played `node`: a command is not carried out only because a file names it.
fn ask(node: &str, log: &Path, played: &[Player]) -> Failure {
    let what = played.iter().map(Player::what).collect::<Vec<_>>().join(", then ");
    let last = played.last().map_or(String::new(), |player| plain(&player.command).into_owned());
    let argument = format!("{node}={last}").replace('\'', "'\"'\"'");
    Failure::Usage(format!(
        "in {}, {node} was not played by Phalanx but by {what}; a command is not run only because a log names it: ask for it with \
         --swap '{argument}', or for the component of Phalanx with --swap {node}={BUILTIN}",
        log.display()
    ))
}

/// Whether `text` asks for the component of Phalanx itself.
fn is_builtin(text: &str, node: &str, names: &[&str]) -> Result<bool, Failure> {
    let Some((name, player)) = text.split_once('=') else { return Ok(false) };
    if player.trim() != BUILTIN {
        return Ok(false);
    }
    let meant = node_called(name, names).map_err(|reason| Failure::Usage(format!("--swap {name}: {reason}")))?;
    if meant == node {
        return Ok(true);
    }
    Err(Failure::Usage(format!("--swap {text}: only {node} is run, all others are played from the log")))
}

/// A participant without a law of its own cannot be run again without a program.
fn refuse_external(assembly: &Assembly, role: Role, node: &str) -> Result<(), Failure> {
    if !assembly.is_external(role) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{node} has the kind `{EXTERNAL}`, which has no law: say what is run in its place, --swap {node}=./my_program"
    )))
}

/// Says which files are no longer those that played.
fn remark_on_changes(played: &[Player], player: Option<&Player>) {
    let (Some(player), Some(recorded)) = (player, played.last()) else { return };
    for (file, digest) in recorded.files.iter().filter(|(_, digest)| !digest.is_empty()) {
        if player.files.iter().all(|(_, now)| now != digest) {
            let short = plain(digest.get(..16).unwrap_or(digest)).into_owned();
            eprintln!("note: no file of this command is the {} (sha256 {short}) that played", plain(file));
        }
    }
}

/// The participants that run again; the others come from the log.
fn cast_of(names: &[&str], node: &str, log: &Path, player: Option<Player>) -> Vec<Player> {
    let recorded = Player::from_log("", log);
    let others = names.iter().filter(|name| **name != node);
    let others = others.map(|name| Player { participant: name.to_string(), ..recorded.clone() });
    player.into_iter().chain(others).collect()
}

/// Our own participants.
fn own_participant(program: &Path) -> Command {
    let mut command = Command::new(program);
    command.arg("participant");
    command
}

/// What is run instead of our own participant.
fn swap_of(text: &str, node: &str, assembly: &Assembly) -> Result<Swap, Failure> {
    let swaps = Swap::collect(assembly, &[text.to_string()])?;
    match swaps.into_iter().find(|swap| swap.node == node) {
        Some(swap) => Ok(swap),
        None => Err(Failure::Usage(format!("--swap {text}: only {node} is run, all others are played from the log"))),
    }
}

fn text_of(node: &str, log: &Path, outcome: &Outcome) -> String {
    let departures = &outcome.departures;
    let Departures { steps, samples, differing_samples, numbers, differing, .. } = departures;
    let log = log.display();
    let mut text = match &departures.first {
        None => format!("equal: {node} gives all {numbers} numbers of {log} again, in {steps} steps"),
        Some(first) => format!(
            "different: {node} departs from {log} first at step {} (t = {} s), {} {}:\n  recorded {:e}, now {:e}, difference \
             {:e}, {} ulp\n{differing_samples} of {samples} samples differ, {differing} of {numbers} numbers\n",
            first.step,
            first.time,
            first.topic,
            first.field,
            first.recorded,
            first.now,
            first.difference(),
            first.ulps(),
        ),
    };
    if !departures.is_equal() {
        let mut table =
            Table::new([("field", Left), ("differ", Right), ("largest difference", Right), ("at step", Right)]);
        for field in departures.fields() {
            let name = format!("{} {}", field.topic, field.field);
            table.row([name, field.differing.to_string(), format!("{:.6e}", field.largest), field.step.to_string()]);
        }
        text.push_str(&format!("\n{}", table.text(columns()).trim_end()));
    }
    if let Some(log) = &outcome.log {
        text.push_str(&format!("\nlog: {}", log.path.display()));
    }
    text
}

fn to_json(node: &str, outcome: &Outcome, played: &[Player], player: Option<&Player>) -> Value {
    let departures = &outcome.departures;
    let fields: Vec<Value> = departures
        .fields()
        .map(|field| {
            json!({
                "topic": field.topic, "field": field.field, "differing": field.differing, "largest": field.largest,
                "step": field.step,
            })
        })
        .collect();
    json!({
        "node": node,
        "recorded_players": players_json(played),
        "player": player.map(Player::to_json),
        "equal": departures.is_equal() && outcome.stopped.is_none(),
        "steps": departures.steps,
        "samples": departures.samples, "differing_samples": departures.differing_samples,
        "numbers": departures.numbers, "differing": departures.differing,
        "first": departures.first.as_ref().map(|first| json!({
            "step": first.step, "time": first.time, "topic": first.topic, "field": first.field, "recorded": first.recorded,
            "now": first.now, "difference": first.difference(), "ulps": first.ulps(),
        })),
        "fields": fields,
        "log": outcome.log.as_ref().map(|log| log.path.display().to_string()),
        "sha256": outcome.log.as_ref().map(|log| log.sha256.clone()),
    })
}
