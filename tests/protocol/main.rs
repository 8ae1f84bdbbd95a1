//! The protocol of gates and arrivals (`src/page/protocol`), in all orders of its single memory accesses.
//!
//! The code of the library runs here, compiled over a memory that makes a move of every access ([`memory`]). The test only adds
//! what calls that code ([`calls`]): workers that wait at their gates and arrive; a conductor that allows steps, waits and
//! repairs; a thread that reports a death or an interrupt. Every state that can be reached is visited. If no process can continue,
//! all must have ended; no worker may run before its time; and the checks for overwritten memory must never report anything.
//!
//! Covered: two to four workers in one to three phases, several steps ahead of the conductor; one or two words of arrivals for a
//! phase; a stop, a death and a replacement at every access; two core groups with workers that poll, with any answer to hints.
//!
//! Not covered: weaker memory orders, since every access takes effect at once for all processes, as with `SeqCst`; what is
//! `Relaxed` in the code is a hint, or constant here. More than one death or stop. A worker that is asked to end (`dismiss`),
//! yielding, and sleeps that end early: they only make a worker look at its gate again. Moving workers to other core groups.
//! Numbers of steps that wrap around in a gate. States are told apart by hashes of 128 bits.

mod calls;
mod flaws;
mod handles;
mod memory;
#[allow(dead_code, reason = "the library uses all of it")]
#[path = "../../processes/src/page/protocol/mod.rs"]
mod protocol;
mod run;
mod state;
mod words;

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use flaws::Flaw;
use run::{Event, Run};
use state::State;

/// Visits all states.
///
/// # Errors
/// What goes wrong in one of them.
fn search(run: &Run) -> Result<(), String> {
    let first = State::first(run);
    let mut bytes = Vec::new();
    let mut seen = HashSet::from([fingerprint(&first, &mut bytes)]);
    let mut open = vec![first];
    while let Some(state) = open.pop() {
        let successors = state.successors(run);
        if successors.is_empty() && !state.has_ended() {
            let places: Vec<String> = state.actors.iter().map(|actor| format!("{:?}", actor.at)).collect();
            return Err(format!("no process can go on: {}", places.join(", ")));
        }
        for next in successors {
            let next = next?;
            if seen.insert(fingerprint(&next, &mut bytes)) {
                next.check(run)?;
                open.push(next);
            }
        }
    }
    Ok(())
}

/// 128 bits that tell a state from all others.
fn fingerprint(state: &State, bytes: &mut Vec<u8>) -> [u64; 2] {
    state.write_to(bytes);
    [0_u8, 1].map(|salt| {
        let mut hasher = DefaultHasher::new();
        (salt, &*bytes).hash(&mut hasher);
        hasher.finish()
    })
}

fn assert_sound(run: Run) {
    if let Err(reason) = search(&run) {
        panic!("{run:?}: {reason}");
    }
}

/// One to three phases of one to three workers, two to four in all; and how many steps are enough to see everything.
const SHAPES: [(&[u8], u8); 7] =
    [(&[2], 3), (&[1, 1], 3), (&[3], 2), (&[1, 2], 2), (&[2, 1], 2), (&[1, 1, 1], 2), (&[2, 2], 2)];

#[test]
fn every_order_ends_and_no_worker_overtakes() {
    for (sizes, steps) in SHAPES {
        for ahead in 0..=2 {
            assert_sound(Run { sizes, steps, ahead, event: Event::None, flaw: None, groups: &[] });
        }
    }
}

#[test]
fn a_stop_at_any_time_ends_all() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, event: Event::Interrupt, flaw: None, groups: &[] });
    }
}

#[test]
fn a_death_at_any_time_ends_all() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, event: Event::Death, flaw: None, groups: &[] });
    }
}

#[test]
fn a_worker_that_dies_at_any_time_can_be_replaced() {
    // The states of four workers, of whom each may die at every access, are too many.
    let cases: [(&[u8], u8); 5] = [(&[2], 1), (&[1, 1], 1), (&[3], 0), (&[1, 2], 0), (&[2, 1], 0)];
    for (sizes, ahead) in cases {
        assert_sound(Run { sizes, steps: 2, ahead, event: Event::Replacement, flaw: None, groups: &[] });
    }
}

/// One to three phases on two core groups, with the steps and the steps ahead that are enough.
const GROUPED: [(&[u8], &[u8], u8, u8); 5] = [
    (&[2], &[0, 1], 3, 1),
    (&[1, 1], &[0, 1], 3, 1),
    (&[3], &[0, 1, 1], 2, 1),
    (&[1, 2], &[0, 0, 1], 2, 0),
    (&[1, 1, 1], &[0, 1, 0], 2, 0),
];

#[test]
fn a_group_for_which_a_worker_polls_is_woken() {
    for (sizes, groups, steps, ahead) in GROUPED {
        for event in [Event::None, Event::Interrupt, Event::Death] {
            assert_sound(Run { sizes, steps, ahead, event, flaw: None, groups });
        }
    }
    // Four workers, two of them in each group.
    let (sizes, groups): (&[u8], &[u8]) = (&[2, 2], &[0, 1, 0, 1]);
    assert_sound(Run { sizes, steps: 1, ahead: 0, event: Event::None, flaw: None, groups });
}

#[test]
fn no_worker_relies_on_a_dead_one_to_poll() {
    for (sizes, groups, _, ahead) in &GROUPED[..4] {
        let ahead = if sizes.len() == 1 { *ahead } else { 0 };
        assert_sound(Run { sizes, steps: 2, ahead, event: Event::Replacement, flaw: None, groups });
    }
}

#[test]
fn flaws_are_found() {
    const STUCK: &str = "no process can go on";
    const BOTH: &[Event] = &[Event::None, Event::Interrupt];
    const REPLACEMENT: &[Event] = &[Event::Replacement];
    const PHASES: (&[u8], &[u8], u8) = (&[2, 1], &[], 3);
    const GROUPS: (&[u8], &[u8], u8) = (&[3], &[0, 1, 1], 2);
    const PAIR: (&[u8], &[u8], u8) = (&[2], &[0, 1], 2);
    const WORDS: (&[u8], &[u8], u8) = (&[3], &[], 2);
    // Enough steps for a conductor that is asleep when a step should open.
    const STEPS: (&[u8], &[u8], u8) = (&[2], &[], 4);
    let cases = [
        (Flaw::OpenTwice, 1, PHASES, BOTH, ""),
        (Flaw::OpenOverStop, 1, PHASES, BOTH, STUCK),
        (Flaw::CompleteLate, 2, STEPS, BOTH, STUCK),
        (Flaw::AskLate, 1, PHASES, BOTH, STUCK),
        (Flaw::ClearAfterOpening, 1, PHASES, BOTH, ""),
        (Flaw::OneWordIsEnough, 1, WORDS, BOTH, "worker"),
        (Flaw::RingsLast, 0, PHASES, BOTH, STUCK),
        (Flaw::NoRepair, 1, PHASES, REPLACEMENT, STUCK),
        (Flaw::RepairUnclaimed, 1, PHASES, REPLACEMENT, ""),
        (Flaw::LookBeforeOpening, 0, GROUPS, BOTH, STUCK),
        (Flaw::LookBeforeLeaving, 0, GROUPS, BOTH, STUCK),
        (Flaw::PolledAnywhere, 1, GROUPS, BOTH, STUCK),
        (Flaw::PollingGoesOn, 0, PAIR, REPLACEMENT, STUCK),
    ];
    for (flaw, ahead, (sizes, groups, steps), events, expected) in cases {
        let find = |&event: &Event| search(&Run { sizes, steps, ahead, event, flaw: Some(flaw), groups }).err();
        let reason = events.iter().find_map(find).unwrap_or_else(|| panic!("{flaw:?} was not found"));
        assert!(reason.contains(expected), "{flaw:?}: {reason}");
    }
}
