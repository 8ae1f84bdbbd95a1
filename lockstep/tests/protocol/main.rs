//! The protocol of gates and arrivals (`src/page.rs`), checked in all interleavings of its single memory accesses.
//!
//! The model follows the code access by access. Every state that can be reached is visited; a state in which nobody can go on
//! must be one in which everybody has ended, and at no state may anybody be where it must not be. An exhaustive search of a
//! model, not of the code: `loom` knows no futex, and a thread of its own for every process cannot die in the middle.

mod model;
mod moves;

use model::{Flaw, Ordeal, Run, Verdict, check};

fn assert_sound(run: Run) {
    let verdict = check(&run);
    assert!(matches!(verdict, Verdict::Sound { .. }), "{run:?}: {verdict:?}");
}

/// One to three phases of one to three workers, two to four in all; and how many steps are enough to see everything.
const SHAPES: [(&[u8], u8); 7] =
    [(&[2], 3), (&[1, 1], 3), (&[3], 2), (&[1, 2], 2), (&[2, 1], 2), (&[1, 1, 1], 2), (&[2, 2], 2)];

#[test]
fn every_order_ends_and_nobody_overtakes() {
    for (sizes, steps) in SHAPES {
        for ahead in 0..=2 {
            assert_sound(Run { sizes, steps, ahead, ordeal: Ordeal::None, flaw: None });
        }
    }
}

#[test]
fn a_stop_at_any_time_ends_everybody() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, ordeal: Ordeal::Interrupt, flaw: None });
    }
}

#[test]
fn a_death_at_any_time_ends_everybody() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, ordeal: Ordeal::Death, flaw: None });
    }
}

#[test]
fn a_worker_that_dies_at_any_time_can_be_replaced() {
    // The states of four workers, of whom each may die at every access, are too many.
    let cases: [(&[u8], u8); 5] = [(&[2], 1), (&[1, 1], 1), (&[3], 0), (&[1, 2], 0), (&[2, 1], 0)];
    for (sizes, ahead) in cases {
        assert_sound(Run { sizes, steps: 2, ahead, ordeal: Ordeal::Replacement, flaw: None });
    }
}

#[test]
fn what_the_protocol_guards_against_is_found() {
    let cases = [
        // Both who find that a step may start open it.
        (Flaw::OpenTwice, 1, ""),
        // The conductor asks to be woken only after it has looked.
        (Flaw::LookBeforeAsking, 1, "nobody can go on"),
        // The arrivals of the step before are cleared after the gate is open.
        (Flaw::ClearAfterOpening, 1, ""),
        // The conductor notes the rings only after it has looked at everything else.
        (Flaw::RingsLast, 0, "nobody can go on"),
        // What a dead worker left undone stays undone.
        (Flaw::NoRepair, 1, "nobody can go on"),
        // The conductor opens a gate that somebody alive is about to open.
        (Flaw::RepairUnclaimed, 1, ""),
    ];
    for (flaw, ahead, expected) in cases {
        let found = [Ordeal::None, Ordeal::Interrupt, Ordeal::Replacement].into_iter().find_map(|ordeal| {
            match check(&Run { sizes: &[2, 1], steps: 3, ahead, ordeal, flaw: Some(flaw) }) {
                Verdict::Broken(reason) => Some(reason),
                Verdict::Sound { .. } => None,
            }
        });
        let reason = found.unwrap_or_else(|| panic!("{flaw:?} was not found"));
        assert!(reason.contains(expected), "{flaw:?}: {reason}");
    }
}
