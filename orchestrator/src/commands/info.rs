//! `phalanx info`.

use std::path::PathBuf;

use clap::Args;
use lockstep::Shape;
use serde_json::json;

use super::check::players_json;
use crate::failure::Failure;
use crate::run::players::Player;
use crate::terminal::table::{Left, Right, Table};
use crate::terminal::{columns, plain, program};
use recording::{Log, LogChannel, Unfinished};

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

pub(crate) fn info(args: &InfoArgs) -> Result<(), Failure> {
    let log = Log::outline(&args.log)?;
    if args.scenario {
        let Some(text) = log.scenario_text() else {
            return Err(Failure::Usage(format!("{} holds no scenario", args.log.display())));
        };
        print!("{text}");
        return Ok(());
    }
    let players: Vec<Player> = log.players().iter().map(Player::read).collect();
    let duration = log.times().last().map_or(0.0, |ns| *ns as f64 / 1e9);
    if args.json {
        let channels: Vec<_> = log
            .channels()
            .iter()
            .map(|channel| json!({
                "topic": channel.topic, "schema": channel.schema, "messages": channel.messages, "fields": fields(channel),
            }))
            .collect();
        let summary = json!({
            "log": args.log.display().to_string(), "complete": log.is_complete(), "metadata": log.metadata(),
            "players": players_json(&players),
            "steps": log.steps().end - log.steps().start, "duration": duration, "channels": channels,
        });
        println!("{summary}");
        return Ok(());
    }
    let mut about = Table::new([("", Left), ("", Left)]).indented(2);
    let mut tell = |name: &str, value: String| about.row([plain(name).into_owned(), value]);
    for (name, value) in log.metadata().into_iter().flatten() {
        tell(name, plain(&value.replace('\n', ", ")).into_owned());
    }
    for player in &players {
        tell(&player.participant, format!("by {}", player.what()));
    }
    tell("samples", format!("{} steps, up to {duration} s", log.steps().end - log.steps().start));
    let state = match log.unfinished() {
        None => "complete".into(),
        Some(Unfinished::Growing) => "not closed yet: its run goes on".to_string(),
        Some(Unfinished::Cut) => format!("{}; `{} recover` closes it", Unfinished::Cut, program()),
    };
    tell("file", state);
    let mut topics = Table::new([("topic", Left), ("messages", Right), ("fields", Left)]);
    for channel in log.channels() {
        topics.row([plain(&channel.topic).into_owned(), channel.messages.to_string(), fields(channel).join(" ")]);
    }
    println!("{}", args.log.display());
    print!("{}\n{}", about.text(columns()), topics.text(columns()));
    Ok(())
}

fn fields(channel: &LogChannel) -> Vec<String> {
    let Some(layout) = &channel.layout else { return Vec::new() };
    let field = |field: &lockstep::Field| match field.shape {
        Shape::Scalar => field.name.clone(),
        Shape::Vector(length) => format!("{}[{length}]", field.name),
    };
    layout.fields().iter().map(field).collect()
}
