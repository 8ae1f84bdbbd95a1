//! Where every process of a run is, and what each of them does next.

use crate::calls::continue_with;
use crate::flaws::LateStore;
use crate::memory::{Moves, Outcome};
use crate::protocol::{Page, WaitPoint};
use crate::run::{Event, Run};
use crate::words::{Name, WORDS};

/// Most processes: four workers, the conductor, and the one that reports what happens to the run.
const PROCESSES: usize = 6;

/// The function that a process is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum At {
    // A worker.
    Poll,
    Gate,
    Arrive,
    // The conductor.
    Allow,
    Wait,
    Repair,
    Resume,
    Stop,
    // The thread that reports what happens.
    Quiet,
    Interrupt,
    Ring,
    // Any of them.
    End,
    Died,
}

/// The accesses that a process has made in the function that it is in, by what they read.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct History {
    length: u8,
    read: [u8; 63],
}

impl History {
    const EMPTY: Self = Self { length: 0, read: [0; 63] };

    pub(crate) fn len(&self) -> usize {
        self.length.into()
    }

    pub(crate) fn get(&self, position: usize) -> u8 {
        self.read[position]
    }

    /// Forgets what the last access has read.
    pub(crate) fn forget_last(&mut self) {
        self.read[usize::from(self.length) - 1] = 0;
    }

    pub(crate) fn push(&mut self, read: u8) {
        self.read[usize::from(self.length)] = read;
        self.length += 1;
    }
}

/// A process.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Actor {
    pub(crate) at: At,
    pub(crate) step: u8,
    /// Steps at which it has arrived.
    pub(crate) done: u8,
    /// The core groups as one of which it sleeps, as bits; 0: it is awake.
    pub(crate) asleep: u8,
    pub(crate) history: History,
    /// What flaws need: a store that is still to be made, and what was read too early.
    pub(crate) late: Option<LateStore>,
    pub(crate) noted: [u8; 2],
}

impl Actor {
    fn new(at: At) -> Self {
        Self { at, step: 0, done: 0, asleep: 0, history: History::EMPTY, late: None, noted: [0; 2] }
    }
}

/// All that a run consists of at a moment.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct State {
    pub(crate) words: [u8; WORDS],
    pub(crate) actors: [Actor; PROCESSES],
    has_happened: bool,
}

impl State {
    pub(crate) fn first(run: &Run) -> Self {
        let mut actors = [Actor::new(At::End); PROCESSES];
        let conductor = run.conductor();
        actors[..conductor].fill(Actor::new(At::Gate));
        actors[conductor].at = At::Allow;
        actors[conductor + 1].at = At::Quiet;
        Self { words: [0; WORDS], actors, has_happened: false }
    }

    /// The state in as few bytes as tell it from all others.
    pub(crate) fn write_to(&self, bytes: &mut Vec<u8>) {
        bytes.clear();
        bytes.extend(self.words);
        bytes.push(self.has_happened.into());
        for actor in &self.actors {
            bytes.extend([actor.at as u8, actor.step, actor.done, actor.asleep, actor.history.length]);
            bytes.extend(&actor.history.read[..actor.history.len()]);
            bytes.extend(actor.noted);
            bytes.extend(actor.late.map_or([u8::MAX; 3], LateStore::bytes));
        }
    }

    /// Wakes the processes of some core groups that sleep at a point.
    pub(crate) fn wake(&mut self, run: &Run, point: WaitPoint, groups: u8) {
        let conductor = run.conductor();
        for (process, actor) in self.actors[..=conductor].iter_mut().enumerate() {
            let is_there = match point {
                WaitPoint::Bell => process == conductor,
                WaitPoint::Gate(phase) => process < conductor && run.place(process).0 == phase,
            };
            if is_there && actor.asleep & groups != 0 {
                actor.asleep = 0;
            }
        }
    }

    /// Whether no process has anything left to do.
    pub(crate) fn has_ended(&self) -> bool {
        self.actors.iter().all(|actor| matches!(actor.at, At::End | At::Died | At::Quiet))
    }

    /// Everything that may come next.
    pub(crate) fn successors(&self, run: &Run) -> Vec<Result<State, String>> {
        let mut all = Vec::new();
        for (process, actor) in self.actors.iter().enumerate() {
            if actor.asleep != 0 || matches!(actor.at, At::End | At::Died | At::Quiet) {
                continue;
            }
            let (next, has_asked) = self.after(run, process, false);
            all.push(next);
            if has_asked {
                all.push(self.after(run, process, true).0);
            }
        }
        if !self.has_happened {
            self.happen(run, &mut all);
        }
        all
    }

    /// The state after the next access of a process, and whether that was a hint.
    fn after(&self, run: &Run, process: usize, hint: bool) -> (Result<State, String>, bool) {
        let page = Page { memory: Moves::of(run, self, process, hint) };
        let next = continue_with(run, &page, process, self);
        let (outcome, has_asked) = (page.memory.outcome(), page.memory.has_asked.get());
        let state = page.memory.finish().and_then(|mut state| {
            if outcome != Outcome::Unfinished {
                state.actors[process].history = History::EMPTY;
            }
            if outcome == Outcome::Returned {
                next.make(run, process, &mut state)?;
            }
            Ok(state)
        });
        (state, has_asked)
    }

    fn happen(&self, run: &Run, all: &mut Vec<Result<State, String>>) {
        let conductor = run.conductor();
        let mut next = Self { has_happened: true, ..*self };
        match run.event {
            Event::None => {}
            Event::Interrupt => {
                next.words[Name::Interrupted.index()] = 1;
                next.actors[conductor + 1].at = At::Interrupt;
                all.push(Ok(next));
            }
            Event::Death | Event::Replacement => {
                next.words[Name::Dead.index()] = 1;
                next.actors[conductor + 1].at = At::Ring;
                for worker in (0..conductor).filter(|&worker| self.actors[worker].at != At::End) {
                    let mut next = next;
                    next.actors[worker] = Actor::new(At::Died);
                    all.push(Ok(next));
                }
            }
        }
    }

    /// No worker may run a step before those that it reads from have, or before it is allowed.
    pub(crate) fn check_order(&self, run: &Run, worker: usize) -> Result<(), String> {
        let (phase, _) = run.place(worker);
        let (step, conductor) = (self.actors[worker].step, run.conductor());
        let current = self.actors[conductor].step;
        if step > current + run.ahead {
            return Err(format!("step {step} runs while the conductor is at {current}"));
        }
        for (other, actor) in self.actors[..conductor].iter().enumerate() {
            let needed = if run.place(other).0 < phase { step + 1 } else { step };
            if !matches!(actor.at, At::End | At::Died) && actor.done < needed {
                return Err(format!("worker {worker} runs step {step} before worker {other} has done {needed} steps"));
            }
        }
        Ok(())
    }

    /// What must be so at any time.
    ///
    /// # Errors
    /// What is not.
    pub(crate) fn check(&self, run: &Run) -> Result<(), String> {
        let page = Page { memory: Moves::all(run, self) };
        let conductor = run.conductor();
        for (worker, actor) in self.actors[..conductor].iter().enumerate() {
            let (phase, position) = run.place(worker);
            let is_running = actor.at == At::Arrive && actor.done == actor.step;
            if is_running && !page.expects_arrival(phase, position, actor.step.into()) {
                return Err(format!("worker {worker} finds the page overwritten while it runs step {}", actor.step));
            }
        }
        let Actor { at, step, .. } = self.actors[conductor];
        let is_stopped = self.words[Name::Interrupted.index()] != 0;
        let limit = run.limit(step).into();
        if at == At::Wait
            && !is_stopped
            && let Some(what) = page.invalid_words(step.into(), limit, limit)
        {
            return Err(format!("the conductor finds {what} overwritten"));
        }
        Ok(())
    }
}
