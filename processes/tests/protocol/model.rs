//! The model: who is where, what stands in the page, and which accesses are next.

use std::collections::HashSet;

/// What is checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    /// Workers of every phase.
    pub(crate) sizes: &'static [u8],
    pub(crate) steps: u8,
    pub(crate) ahead: u8,
    pub(crate) ordeal: Ordeal,
    pub(crate) flaw: Option<Flaw>,
    /// The side of every worker; empty: there is one only, and nobody watches.
    pub(crate) sides: &'static [u8],
}

/// What happens to the run, at every possible moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ordeal {
    None,
    Interrupt,
    Death,
    /// A worker dies and another one takes its place.
    Replacement,
}

/// A mistake, to see that the search finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    OpenTwice,
    LookBeforeAsking,
    ClearAfterOpening,
    RingsLast,
    /// The conductor does what a dead worker may have left undone without claiming it.
    RepairUnclaimed,
    /// Nobody does what a dead worker has left undone.
    NoRepair,
    /// Who opens a gate looks whether the other side is watched before it opens it.
    LookBeforeOpening,
    /// A watcher looks at the gate a last time before it says that it watches no more.
    LookBeforeLeaving,
    /// Who opens a gate relies on a watcher of any gate.
    AnyWatcher,
    /// Nobody relieves a watcher that is dead.
    NoRelief,
}

#[derive(Debug)]
pub(crate) enum Verdict {
    Sound {
        /// How many states there are; printed when an assertion fails.
        #[allow(dead_code, reason = "for people")]
        states: usize,
    },
    Broken(String),
}

/// What to do when a gate is open, or somebody else opens it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum After {
    /// A worker goes on to its next step.
    Next,
    /// A worker that completed a step sees whether the conductor waits.
    Ring,
    /// The conductor waits.
    Await,
    /// The conductor goes on with its repair: is the gate open now?
    Opened(u8, u8),
    /// The conductor goes on with its repair: behind this phase.
    Behind(u8, u8),
}

/// The next access of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum At {
    // Worker.
    Gate,
    Sleep(u8),
    Arrive,
    Wake,
    // Both: claiming a gate or, behind the last phase, the end of a step.
    Claim(u8, u8, After),
    TakeClaim(u8, u8, u8, After),
    Completed(u8, After),
    Limit(u8, After),
    // Both: opening a gate.
    ClearMask(u8, u8, After),
    ReadGate(u8, u8, After),
    SwapGate(u8, u8, u8, After),
    WakeGate(u8, u8, After),
    /// Looking whether a side is watched, and waking those that are not; the sides to wake so far.
    Watched(u8, u8, u8, u8, After),
    // Worker: watching for its side, since it left its phase of this step.
    MayWatch,
    Watch,
    Watching,
    LookAgain,
    LookedBefore(bool),
    WakeSide,
    Bell(After),
    WakeBell(After),
    // Conductor.
    Allow,
    Allowed,
    Rings,
    Interrupted,
    Done,
    Dead,
    Ask,
    Asked,
    Rest,
    StopGate(u8),
    WakeStopped(u8),
    Asleep,
    End,
    Died,
    // Conductor: repair, of a phase and a step.
    Relieve(u8),
    WakeRelieved(u8),
    Repair,
    RepairGate(u8, u8),
    RepairClaim(u8, u8),
    RepairLimit(u8, u8),
    RepairOpened(u8, u8),
    RepairWake(u8, u8),
    RepairStillOpen(u8, u8),
    RepairMask(u8, u8),
    RepairFinish(u8),
    RepairCompleted(u8),
    Resume,
    ResumeGate(u8),
    ResumeMask(u8),
    ResumeAgain(u8, u8),
}

#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Actor {
    pub(crate) at: At,
    pub(crate) step: u8,
    /// The conductor's note of the bell.
    pub(crate) rings: u8,
}

#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct State {
    pub(crate) limit: u8,
    /// Steps claimed, for every gate and, last, for the end of a step; and by whom.
    pub(crate) claims: [(u8, u8); 4],
    pub(crate) completed: u8,
    pub(crate) wake_at: u8,
    pub(crate) bell: u8,
    pub(crate) gates: [u8; 3],
    pub(crate) masks: [u8; 3],
    /// Which gate is watched for each side, and for which step: phase plus 1, step plus 1; zeros if none is.
    pub(crate) watched: [(u8, u8); 2],
    /// Workers first, the conductor last.
    pub(crate) actors: Vec<Actor>,
    pub(crate) interrupted: bool,
    pub(crate) dead: bool,
    /// The interrupt or the death has happened; 2: and the bell has been rung for it.
    pub(crate) ordeal: u8,
}

/// Visits all states.
pub(crate) fn check(run: &Run) -> Verdict {
    let workers: u8 = run.sizes.iter().sum();
    let actor = |at| Actor { at, step: 0, rings: 0 };
    let mut actors = vec![actor(At::Gate); workers.into()];
    actors.push(actor(At::Allow));
    let (gates, masks) = ([0; 3], [0; 3]);
    let first = State {
        limit: 0,
        claims: [(0, 0); 4],
        completed: 0,
        wake_at: 0,
        bell: 0,
        gates,
        masks,
        watched: [(0, 0); 2],
        actors,
        interrupted: false,
        dead: false,
        ordeal: 0,
    };
    let mut seen = HashSet::from([first.clone()]);
    let mut open = vec![first];
    while let Some(state) = open.pop() {
        let mut stuck = true;
        for next in successors(run, &state) {
            stuck = false;
            match next {
                Ok(next) if seen.insert(next.clone()) => open.push(next),
                Ok(_) => {}
                Err(reason) => return Verdict::Broken(reason),
            }
        }
        let all_ended = || state.actors.iter().all(|actor| matches!(actor.at, At::End | At::Died));
        if stuck && !all_ended() {
            let places: Vec<String> = state.actors.iter().map(|actor| format!("{:?}", actor.at)).collect();
            return Verdict::Broken(format!("nobody can go on: {}", places.join(", ")));
        }
    }
    Verdict::Sound { states: seen.len() }
}

fn successors(run: &Run, state: &State) -> Vec<Result<State, String>> {
    let mut all = Vec::new();
    let conductor = state.actors.len() - 1;
    for index in 0..=conductor {
        if !matches!(state.actors[index].at, At::Asleep | At::End | At::Died) {
            let mut next = state.clone();
            all.push(next.advance(run, index).map(|()| next));
        }
        // Whether it watches is a matter of hints, which may be wrong.
        if state.actors[index].at == At::MayWatch {
            let mut next = state.clone();
            next.actors[index].at = At::Gate;
            all.push(Ok(next));
        }
    }
    match (run.ordeal, state.ordeal) {
        (Ordeal::Interrupt, 0) => {
            let mut next = state.clone();
            (next.interrupted, next.ordeal) = (true, 1);
            all.push(Ok(next));
        }
        (Ordeal::Death | Ordeal::Replacement, 0) => {
            for worker in (0..conductor).filter(|&worker| state.actors[worker].at != At::End) {
                let mut next = state.clone();
                (next.actors[worker].at, next.dead, next.ordeal) = (At::Died, true, 1);
                all.push(Ok(next));
            }
        }
        // Whoever reports it rings, in two accesses.
        (_, 1) => {
            let mut next = state.clone();
            (next.bell, next.ordeal) = (next.bell + 1, 2);
            all.push(Ok(next));
        }
        (_, 2) => {
            let mut next = state.clone();
            next.ordeal = 3;
            next.wake_conductor();
            all.push(Ok(next));
        }
        _ => {}
    }
    all
}
