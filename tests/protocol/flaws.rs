//! Mistakes in the use of the memory, to see that the search finds them: accesses that come too late, are not made, or read
//! something else.

use crate::state::State;
use crate::words::Name;

/// A mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// All processes that find that a gate may open open it: whatever a claim shows, it can be had.
    OpenTwice,
    /// A gate is opened by a plain store, over a stop.
    OpenOverStop,
    /// The worker that completes a step says so only after it has looked whether the next one is allowed.
    CompleteLate,
    /// The conductor asks to be woken only after it has looked.
    AskLate,
    /// The arrivals of the step before are cleared after the gate is open.
    ClearAfterOpening,
    /// A phase of several words is complete as soon as one of them is full.
    OneWordIsEnough,
    /// The conductor notes the rings only when it goes to sleep.
    RingsLast,
    /// The conductor does what a dead worker may have left undone without claiming it.
    RepairUnclaimed,
    /// The conductor does not do what a dead worker has left undone.
    NoRepair,
    /// A process that opens a gate looks whether it is polled for another group before it opens it.
    LookBeforeOpening,
    /// A worker that polls looks at the gate a last time before it says that it polls no more.
    LookBeforeLeaving,
    /// A process that opens a gate relies on a worker that polls any gate.
    PolledAnywhere,
    /// A dead worker is still relied on to poll.
    PollingGoesOn,
}

impl Flaw {
    /// Whether stores to this word are made after the next access only, as if they were not sequentially consistent.
    pub(crate) fn delays(self, name: Name) -> bool {
        match self {
            Self::CompleteLate => name == Name::Completed,
            Self::AskLate => name == Name::WakeAt,
            Self::LookBeforeLeaving => matches!(name, Name::Polled(_)),
            Self::ClearAfterOpening => matches!(name, Name::Arrivals(..)),
            _ => false,
        }
    }

    /// How many accesses a store that comes too late is passed by.
    fn delay(self) -> u8 {
        // Reading the gate, and opening it.
        if self == Self::ClearAfterOpening { 2 } else { 1 }
    }
}

/// A store that a process makes too late.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct LateStore {
    word: u8,
    value: u8,
    /// Accesses that are made before it.
    delay: u8,
}

impl LateStore {
    pub(crate) fn bytes(self) -> [u8; 3] {
        [self.word, self.value, self.delay]
    }
}

/// Puts a store off.
pub(crate) fn put_off(state: &mut State, process: usize, flaw: Flaw, name: Name, value: u64) {
    let late = LateStore { word: name.index() as u8, value: name.pack(value), delay: flaw.delay() };
    state.actors[process].late = Some(late);
}

/// Makes the store that a process has put off, if it is time.
pub(crate) fn make_late_store(state: &mut State, process: usize) {
    let late = &mut state.actors[process].late;
    match late {
        Some(LateStore { word, value, delay: 0 }) => {
            state.words[usize::from(*word)] = *value;
            *late = None;
        }
        Some(LateStore { delay, .. }) => *delay -= 1,
        None => {}
    }
}
