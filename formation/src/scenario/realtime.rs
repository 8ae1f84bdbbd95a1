//! `[realtime]`: what is to be done about steps that are late.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::config::{Node, Problems, read};

/// What is done about a step whose time has passed because the step before took too long. None of it changes a number: every
/// step is computed and recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Overrun {
    /// It starts with the next period: the run falls behind the clock by whole periods, and a robot gets one command per period.
    Skip,
    /// It starts at once, and so do the next ones, until the run keeps pace with the clock again.
    CatchUp,
    /// The run ends if it is late by a period or more.
    Abort,
}

/// `[realtime]`: how a run keeps pace with the clock, with `--realtime`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RealtimeSection {
    /// What is done about steps that are late; by default `skip` if robots take part and else `catch_up`.
    overrun: Option<Overrun>,
}

/// What the scenario says about late steps, if anything.
pub(super) fn read_overrun(root: &Node, problems: &mut Problems) -> Option<Overrun> {
    let node = root.at("realtime")?;
    read::<RealtimeSection>(node, "realtime", problems)?.overrun
}
