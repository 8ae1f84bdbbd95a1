//! What calls the protocol: a worker, the conductor, the thread that reports what happens to the run.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering::SeqCst;
use std::time::Duration;

use crate::flaws::Flaw;
use crate::memory::Moves;
use crate::protocol::{Arrival, Page, Word};
use crate::run::{Event, Run};
use crate::state::{Actor, At, State};
use crate::words::Name;

/// What a process does when its function has returned.
pub(crate) enum Next {
    /// It goes on with another function.
    Go(At),
    /// A worker runs its step.
    Run,
    /// Its step is done; the next one begins with this function.
    Step(At),
    /// A successor resumes in the place of the dead worker, at a step.
    Resume(usize, u64),
}

impl Next {
    /// Does it.
    ///
    /// # Errors
    /// What it must not have done.
    pub(crate) fn make(self, run: &Run, process: usize, state: &mut State) -> Result<(), String> {
        let actor = &mut state.actors[process];
        match self {
            Self::Go(at) => actor.at = at,
            Self::Run => {
                state.check_order(run, process)?;
                state.actors[process].at = At::Arrive;
            }
            Self::Step(at) => {
                actor.step += 1;
                actor.at = if actor.step == run.steps { At::End } else { at };
            }
            Self::Resume(dead, step) => {
                actor.at = At::Allow;
                let successor = &mut state.actors[dead];
                (successor.step, successor.done) = (step as u8, step as u8);
                successor.at = if successor.step == run.steps { At::End } else { At::Gate };
                state.words[Name::Dead.index()] = 0;
            }
        }
        Ok(())
    }
}

/// Calls the function of the protocol that a process is in, and says what comes after it.
pub(crate) fn continue_with(run: &Run, page: &Page<Moves<'_>>, process: usize, state: &State) -> Next {
    let Actor { at, step, .. } = state.actors[process];
    let place = || run.place(process);
    let now = u64::from(step);
    match at {
        At::Poll => {
            page.poll_next_gate(process, place().0, now - 1);
            Next::Go(At::Gate)
        }
        At::Gate if page.await_gate(process, place().0, now) => Next::Run,
        At::Gate => Next::Go(At::End),
        At::Arrive => {
            let (phase, position) = place();
            let arrival = page.arrive(process, phase, position, now);
            Next::Step(if arrival == Arrival::LastOfGroup { At::Poll } else { At::Gate })
        }
        At::Allow => {
            page.allow(run.limit(step).into());
            Next::Go(At::Wait)
        }
        At::Wait => conduct(run, page, step),
        At::Repair => {
            page.repair(|worker| state.actors[worker].at == At::Died);
            Next::Go(At::Resume)
        }
        At::Resume => {
            let dead = state.actors.iter().position(|actor| actor.at == At::Died).unwrap_or_default();
            Next::Resume(dead, page.resumption(&[run.place(dead)]).0)
        }
        At::Stop => {
            page.stop();
            Next::Go(At::End)
        }
        At::Interrupt => {
            page.stop();
            Next::Go(At::Ring)
        }
        At::Ring => {
            page.ring();
            Next::Go(At::Quiet)
        }
        At::Quiet | At::End | At::Died => unreachable!("a process that is {at:?} does nothing"),
    }
}

/// The conductor waits for a step, as in `src/conductor/wait.rs`.
fn conduct(run: &Run, page: &Page<Moves<'_>>, step: u8) -> Next {
    let is_set = |name| -> bool { Word::<u64>::load(&page.memory.word(name), SeqCst) != 0 };
    let enough = (step + 1 + run.ahead / 2).min(run.steps);
    let waited = page.sleep_unless(enough.into(), || {
        if is_set(Name::Interrupted) {
            // The thread that interrupts the run stops the workers; the conductor would only do so once more.
            ControlFlow::Break(Next::Go(At::End))
        } else if page.completed() > step.into() {
            ControlFlow::Break(Next::Step(At::Allow))
        } else if !is_set(Name::Dead) {
            ControlFlow::Continue(Duration::MAX)
        } else if run.event == Event::Death {
            ControlFlow::Break(Next::Go(At::Stop))
        } else if run.flaw == Some(Flaw::NoRepair) {
            ControlFlow::Break(Next::Go(At::Resume))
        } else {
            ControlFlow::Break(Next::Go(At::Repair))
        }
    });
    waited.break_value().unwrap_or(Next::Go(At::Wait))
}
