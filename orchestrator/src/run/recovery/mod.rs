//! What becomes of a run when a participant fails, and of a participant whose place another program takes.
//!
//! What is done is said by the scenario ([`FailurePolicy`]); how it is done is the conductor's business
//! ([`processes::Conductor::replace`]); what has happened so far comes from the log.

mod event;
mod tail;

use std::path::PathBuf;
use std::time::Instant;

use formation::scenario::{FailurePolicy, OnFailure};
use processes::{Replacement, RunError};

use crate::run::engine::Engine;
use crate::run::observer::{Flow, Observer, StepView};
use crate::run::players::Player;
use crate::run::swap::Swap;
use event::Events;
use recording::{LogError, PLAYER, Recorder};
use tail::{Past, Tail};

/// Why a participant keeps its program.
const SHARED: &str = "it shares its process with others: nothing was changed";
const ROBOT: &str = "it is a robot, which cannot be changed for another one while it drives: nothing was changed";
const OVER: &str = "the run is at its end: nothing was changed";
const WORN_OUT: &str = "it was replaced as often as this run has room for: nothing was changed";
/// Processes that a swap takes at most: the new program, and its predecessor again.
const STARTS_OF_A_SWAP: u32 = 2;

/// Replaces participants of one run.
pub(crate) struct Recovery {
    policy: FailurePolicy,
    /// The log that is being written.
    log: PathBuf,
    tail: Tail,
    /// What plays each worker.
    tenures: Vec<Tenure>,
    events: Events,
    /// Programs that have taken a place, for the log.
    players: Vec<Player>,
    /// What was done, in words.
    told: Vec<String>,
}

/// How the program came to its worker that plays it now.
#[derive(Clone, Copy, Debug, Default)]
struct Tenure {
    /// The first step that it has to answer for; before that, other programs played.
    since: u64,
    /// How often it has failed.
    failures: u32,
    /// Whether it plays no more: its last samples stand.
    is_held: bool,
}

impl Tenure {
    /// What a process does that continues what this one did.
    fn replacement(self) -> Replacement {
        if self.is_held { Replacement::Hold } else { Replacement::Recompute { since: self.since } }
    }
}

impl Recovery {
    /// For a run that writes the log `log`.
    pub(crate) fn new(policy: FailurePolicy, log: PathBuf) -> Self {
        let (tenures, players, told) = (Vec::new(), Vec::new(), Vec::new());
        Self { policy, log, tail: Tail::new(), tenures, events: Events::default(), players, told }
    }

    /// Replaces participants that have failed, as their policies say.
    ///
    /// # Errors
    /// The error that ends the run: `error` itself if a policy says so, or why a participant could not be replaced.
    pub(crate) fn mend(&mut self, engine: &mut Engine, recorder: &Recorder, error: RunError) -> Result<(), RunError> {
        let mut error = error;
        loop {
            let failed_workers = engine.failed_workers(&error);
            // Before the first step there is no sample that could stand.
            let holds_nothing = |policy| policy == OnFailure::Hold && self.tail.is_empty();
            let ends = |policy| policy == OnFailure::Abort || holds_nothing(policy);
            let aborts = |&worker: &usize| ends(self.policy_of(engine, worker));
            if failed_workers.is_empty() || failed_workers.iter().any(aborts) {
                return Err(error);
            }
            let mut failed = None;
            for worker in failed_workers {
                if let Err(again) = self.relieve(engine, recorder, worker, &error) {
                    failed = Some(again);
                }
            }
            match failed {
                Some(again) => error = again,
                None => return Ok(()),
            }
        }
    }

    /// Puts a program of the user in the place of a participant; returns the first step that it runs, or why nothing has
    /// changed. If the program cannot take the place, the one before it is started again and computes the steps anew that it
    /// has to answer for.
    ///
    /// # Errors
    /// The error that ends the run, if that one cannot take its place either.
    pub(crate) fn swap(
        &mut self,
        engine: &mut Engine,
        recorder: &Recorder,
        swap: Swap,
    ) -> Result<Result<u64, String>, RunError> {
        let (node, program) = (swap.node.clone(), swap.to_string());
        let Some(worker) = engine.worker_of(&node) else { return Ok(Err(SHARED.into())) };
        if engine.is_robot(worker) {
            return Ok(Err(ROBOT.into()));
        }
        if engine.replacements_left(worker) < self.policy.restarts + STARTS_OF_A_SWAP {
            return Ok(Err(WORN_OUT.into()));
        }
        let player = Player::of(&swap, 0);
        let before = engine.take_on(&node, Some(swap));
        match self.replace(engine, recorder, worker, Replacement::Adopt) {
            Ok(Some(step)) => {
                *self.tenure(worker) = Tenure { since: step, ..Tenure::default() };
                self.players.extend(player.map(|player| Player { from_step: step, ..player }));
                self.events.push(&node, format!("played by `{program}` from step {step} on"));
                self.tell(format!("{node} is played by `{program}` from step {step} on"));
                Ok(Ok(step))
            }
            Ok(None) => Ok(Err(OVER.into())),
            Err(error @ RunError::Interrupted { .. }) => Err(error),
            Err(error) => {
                engine.take_on(&node, before);
                let replacement = self.tenure(worker).replacement();
                self.replace(engine, recorder, worker, replacement)?;
                self.tell(format!("`{program}` cannot play {node}, which plays on as before: {error}"));
                Ok(Err(format!("{error}\n{node} plays on as before")))
            }
        }
    }

    /// What was done, in words.
    pub(crate) fn into_told(self) -> Vec<String> {
        self.told
    }

    /// The strictest policy of the participants that a worker hosts.
    fn policy_of(&self, engine: &Engine, worker: usize) -> OnFailure {
        // What a robot has done cannot be done again.
        if engine.is_robot(worker) {
            return OnFailure::Abort;
        }
        let policies: Vec<OnFailure> = engine.hosted(worker).map(|node| self.policy.of(node)).collect();
        let order = [OnFailure::Abort, OnFailure::Hold, OnFailure::Restart];
        order.into_iter().find(|policy| policies.contains(policy)).unwrap_or_default()
    }

    fn relieve(
        &mut self,
        engine: &mut Engine,
        recorder: &Recorder,
        worker: usize,
        error: &RunError,
    ) -> Result<(), RunError> {
        let count = self.tenure(worker).failures;
        let name = engine.worker_name(worker);
        if count >= self.policy.restarts {
            let reason = format!("it was restarted {count} times already, and failed again: {error}");
            return Err(RunError::NotReplaced { worker: name, step: engine.steps_done(), reason });
        }
        let is_held = self.policy_of(engine, worker) == OnFailure::Hold;
        let tenure = self.tenure(worker);
        (tenure.failures, tenure.is_held) = (count + 1, is_held);
        let replacement = tenure.replacement();
        let start = Instant::now();
        let Some(step) = self.replace(engine, recorder, worker, replacement)? else { return Ok(()) };
        let took = start.elapsed().as_secs_f64();
        let number = count + 1;
        if replacement == Replacement::Hold {
            for node in engine.hosted(worker) {
                self.events.push(node, format!("failed; its last sample stands from step {step} on"));
            }
            self.tell(format!("{error}\n{name} is held: its last samples stand from step {step} on, marked as stale"));
        } else {
            let most = self.policy.restarts;
            self.tell(format!(
                "{error}\n{name} was restarted and goes on at step {step} (restart {number} of {most}; caught up in {took:.2} s)"
            ));
        }
        Ok(())
    }

    fn tenure(&mut self, worker: usize) -> &mut Tenure {
        if self.tenures.len() <= worker {
            self.tenures.resize(worker + 1, Tenure::default());
        }
        &mut self.tenures[worker]
    }

    fn replace(
        &mut self,
        engine: &mut Engine,
        recorder: &Recorder,
        worker: usize,
        replacement: Replacement,
    ) -> Result<Option<u64>, RunError> {
        let Engine::Processes { conductor, programs, .. } = engine else { return Ok(None) };
        let network = conductor.plan().network.clone();
        let mut past = Past { network: &network, tail: &self.tail, log: &self.log, recorder };
        let name = &conductor.plan().workers[worker].name;
        let command = match replacement {
            Replacement::Hold => programs.own_program(),
            _ => programs.command(name, conductor.directory().path()).map_err(|failure| RunError::NotReplaced {
                worker: name.clone(),
                step: conductor.statistics().read().completed,
                reason: failure.to_string(),
            })?,
        };
        conductor.replace(worker, command, programs.core, replacement, &mut past)
    }

    fn tell(&mut self, text: String) {
        eprintln!("{text}");
        self.told.push(text);
    }
}

impl Observer for Recovery {
    /// Keeps the samples of the step, which was recorded, and records what has happened to participants.
    fn step(&mut self, view: &mut StepView, log: Option<&mut Recorder>) -> Result<Flow, LogError> {
        self.tail.note(view.network, view.store, view.step);
        view.remarks.drain(..).for_each(|(participant, text)| self.events.push(&participant, text));
        let Some(log) = log else { return Ok(Flow::Continue) };
        for player in self.players.drain(..) {
            log.note(PLAYER, &player.to_metadata())?;
        }
        self.events.write(view.step, view.period, log)?;
        Ok(Flow::Continue)
    }
}
