//! The memory of the search: words, each access of which is a move of its own, and functions that go on where they were.
//!
//! A process is somewhere in a function of the protocol. To go on by one access, that function is called anew: the accesses that
//! it has made before are answered from a record, the next one is made, and whatever it does behind that has no effect. That
//! works because the functions know nothing but their arguments and what they have read.

use std::cell::{Cell, RefCell};

use crate::flaws::{self, Flaw};
use crate::handles::Handle;
use crate::protocol::{Memory, WaitPoint};
use crate::run::Run;
use crate::state::{At, State};
use crate::words::{GROUPS, Name};

/// How a call has come out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// The function has returned.
    Returned,
    /// It has more accesses to make.
    Unfinished,
    /// It sleeps, or has woken, and begins anew: over a sleep it keeps nothing that matters here.
    Slept,
}

/// The memory during one move of a process.
pub(crate) struct Moves<'a> {
    pub(crate) run: &'a Run,
    pub(crate) state: RefCell<State>,
    process: usize,
    /// Accesses that are answered from the record; `None`: all are made.
    recorded: Cell<Option<usize>>,
    position: Cell<usize>,
    outcome: Cell<Outcome>,
    pub(crate) looks_at_clock: Cell<u64>,
    /// The answer to a hint that may be wrong, and whether it was asked for.
    hint: bool,
    pub(crate) has_asked: Cell<bool>,
    error: RefCell<Option<String>>,
}

impl<'a> Moves<'a> {
    /// For the next access of a process.
    pub(crate) fn of(run: &'a Run, state: &State, process: usize, hint: bool) -> Self {
        let mut memory = Self::all(run, state);
        memory.recorded.set(Some(state.actors[process].history.len()));
        (memory.process, memory.hint) = (process, hint);
        flaws::make_late_store(&mut memory.state.borrow_mut(), process);
        memory
    }

    /// For a look at everything at once.
    pub(crate) fn all(run: &'a Run, state: &State) -> Self {
        Self {
            run,
            state: RefCell::new(*state),
            process: run.conductor(),
            recorded: Cell::new(None),
            position: Cell::new(0),
            outcome: Cell::new(Outcome::Returned),
            looks_at_clock: Cell::new(0),
            hint: false,
            has_asked: Cell::new(false),
            error: RefCell::new(None),
        }
    }

    pub(crate) fn word(&self, name: Name) -> Handle<'_, 'a> {
        Handle::Word(self, name)
    }

    pub(crate) fn outcome(&self) -> Outcome {
        self.outcome.get()
    }

    /// The state after the move.
    ///
    /// # Errors
    /// What the process must not have done.
    pub(crate) fn finish(self) -> Result<State, String> {
        self.error.into_inner().map_or_else(|| Ok(self.state.into_inner()), Err)
    }

    /// One access; `make` makes it and returns what it reads.
    fn access(&self, name: Name, make: impl FnOnce(&mut State) -> u64) -> u64 {
        let position = self.position.replace(self.position.get() + 1);
        let mut state = self.state.borrow_mut();
        let Some(recorded) = self.recorded.get() else { return make(&mut state) };
        if position < recorded {
            name.unpack(state.actors[self.process].history.get(position))
        } else if position == recorded && self.outcome.get() == Outcome::Returned {
            let read = make(&mut state);
            state.actors[self.process].history.push(name.pack(read));
            read
        } else {
            if self.outcome.get() == Outcome::Returned {
                self.outcome.set(Outcome::Unfinished);
            }
            name.last()
        }
    }

    fn has_flaw(&self, flaw: Flaw) -> bool {
        self.recorded.get().is_some() && self.run.flaw == Some(flaw)
    }

    /// Polling may end at any time, so it does not matter what is seen before it ends.
    fn is_first_look_of_poll(&self) -> bool {
        self.position.get() == 1 && self.state.borrow().actors[self.process].at == At::Poll
    }

    fn is_repairing(&self, state: &State) -> bool {
        state.actors[self.process].at == At::Repair
    }

    pub(crate) fn load(&self, name: Name) -> u64 {
        if self.is_first_look_of_poll() {
            return 0;
        }
        self.access(name, |state| {
            let value = name.unpack(state.words[name.index()]);
            match name {
                Name::Gate(_) if self.has_flaw(Flaw::LookBeforeOpening) => {
                    state.actors[self.process].noted = [0, 1].map(|group| state.words[Name::Polled(group).index()]);
                    value
                }
                Name::Polled(group) if self.has_flaw(Flaw::LookBeforeOpening) => {
                    name.unpack(state.actors[self.process].noted[group])
                }
                Name::Polled(_) if self.has_flaw(Flaw::PolledAnywhere) && value != 0 => {
                    name.unpack(state.actors[self.process].noted[0])
                }
                Name::Arrivals(phase, word) if self.has_flaw(Flaw::OneWordIsEnough) => {
                    let members = usize::from(self.run.sizes[phase]) - Self::WORKERS_PER_WORD * word;
                    (1 << members.min(Self::WORKERS_PER_WORD)) - 1
                }
                Name::GateClaim(_) if self.has_flaw(Flaw::RepairUnclaimed) && self.is_repairing(state) => 0,
                _ => value,
            }
        })
    }

    pub(crate) fn store(&self, name: Name, value: u64) {
        self.access(name, |state| {
            match name {
                _ if let Some(flaw) = self.run.flaw.filter(|flaw| flaw.delays(name)) => {
                    flaws::put_off(state, self.process, flaw, name, value);
                }
                Name::Polled(_) if self.has_flaw(Flaw::PollingGoesOn) && self.is_repairing(state) => {}
                _ => state.words[name.index()] = name.pack(value),
            }
            0
        });
    }

    pub(crate) fn replace(&self, name: Name, current: u64, new: u64) -> bool {
        let replaced = self.access(Name::Dead, |state| {
            let is_claim = matches!(name, Name::GateClaim(_) | Name::CompletionClaim);
            if matches!(name, Name::GateClaim(_)) && self.has_flaw(Flaw::RepairUnclaimed) && self.is_repairing(state) {
                return 1;
            }
            let is_forced = is_claim && self.has_flaw(Flaw::OpenTwice)
                || matches!(name, Name::Gate(_)) && self.has_flaw(Flaw::OpenOverStop);
            if !matches!(name, Name::Polled(_)) {
                // Read just before, to be replaced. It is not used again, so states that differ in it are the same; 0 passes
                // all comparisons that it has passed.
                state.actors[self.process].history.forget_last();
            }
            let word = &mut state.words[name.index()];
            if name.unpack(*word) != current && !is_forced {
                return 0;
            }
            *word = name.pack(new);
            if let Name::Gate(phase) = name
                && self.has_flaw(Flaw::PolledAnywhere)
            {
                state.actors[self.process].noted[0] = Name::Polled(0).pack(new << 32 | (phase as u64 + 1));
            }
            1
        });
        replaced != 0
    }

    /// A worker arrives.
    pub(crate) fn fetch_or(&self, name: Name, bits: u64) -> u64 {
        self.access(name, |state| {
            let before = name.unpack(state.words[name.index()]);
            state.words[name.index()] = name.pack(before | bits);
            if let Name::Arrivals(..) = name {
                if before & bits != 0 {
                    *self.error.borrow_mut() = Some(format!("process {} arrives twice", self.process));
                }
                state.actors[self.process].done += 1;
            }
            before
        })
    }

    /// Counts a worker of a group of so many, rightly or not.
    pub(crate) fn count(&self, members: u64) -> u64 {
        self.access(Name::Limit, |_| {
            self.has_asked.set(true);
            // It tells other processes nothing: one more access belongs to this move.
            self.recorded.set(self.recorded.get().map(|recorded| recorded + 1));
            if self.hint { members - 1 } else { members }
        })
    }

    pub(crate) fn fetch_add(&self, name: Name, value: u64) -> u64 {
        self.access(name, |state| {
            let before = name.unpack(state.words[name.index()]);
            state.words[name.index()] = name.pack(before + value);
            before
        })
    }

    pub(crate) fn sleep_while(&self, point: WaitPoint, value: u32, groups: u8) {
        let name = match point {
            WaitPoint::Bell => Name::Bell,
            WaitPoint::Gate(phase) => Name::Gate(phase),
        };
        let mut has_slept = false;
        self.access(Name::Dead, |state| {
            let shown = name.unpack(state.words[name.index()]);
            let is_asleep = shown == u64::from(value) || name == Name::Bell && self.has_flaw(Flaw::RingsLast);
            state.actors[self.process].asleep = if is_asleep { groups } else { 0 };
            has_slept = true;
            0
        });
        if has_slept {
            self.outcome.set(Outcome::Slept);
        }
    }

    pub(crate) fn wake(&self, point: WaitPoint, groups: u8) {
        self.access(Name::Dead, |state| {
            let is_first = state.actors[self.process].history.len() < GROUPS + self.run.sizes.len();
            if !(self.has_flaw(Flaw::PollingGoesOn) && self.is_repairing(state) && is_first) {
                state.wake(self.run, point, groups);
            }
            0
        });
    }
}
