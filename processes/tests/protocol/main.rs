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
            assert_sound(Run { sizes, steps, ahead, ordeal: Ordeal::None, flaw: None, sides: &[] });
        }
    }
}

#[test]
fn a_stop_at_any_time_ends_everybody() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, ordeal: Ordeal::Interrupt, flaw: None, sides: &[] });
    }
}

#[test]
fn a_death_at_any_time_ends_everybody() {
    for (sizes, steps) in SHAPES {
        assert_sound(Run { sizes, steps, ahead: 1, ordeal: Ordeal::Death, flaw: None, sides: &[] });
    }
}

#[test]
fn a_worker_that_dies_at_any_time_can_be_replaced() {
    // The states of four workers, of whom each may die at every access, are too many.
    let cases: [(&[u8], u8); 5] = [(&[2], 1), (&[1, 1], 1), (&[3], 0), (&[1, 2], 0), (&[2, 1], 0)];
    for (sizes, ahead) in cases {
        assert_sound(Run { sizes, steps: 2, ahead, ordeal: Ordeal::Replacement, flaw: None, sides: &[] });
    }
}

/// One to three phases on two sides, with the steps and the steps ahead that are enough.
const SIDES: [(&[u8], &[u8], u8, u8); 5] = [
    (&[2], &[0, 1], 3, 1),
    (&[1, 1], &[0, 1], 3, 1),
    (&[3], &[0, 1, 1], 2, 1),
    (&[1, 2], &[0, 0, 1], 2, 0),
    (&[1, 1, 1], &[0, 1, 0], 2, 0),
];

#[test]
fn a_side_that_is_watched_is_woken() {
    for (sizes, sides, steps, ahead) in SIDES {
        for ordeal in [Ordeal::None, Ordeal::Interrupt, Ordeal::Death] {
            assert_sound(Run { sizes, steps, ahead, ordeal, flaw: None, sides });
        }
    }
    // Four workers, two of them on each side.
    let (sizes, sides): (&[u8], &[u8]) = (&[2, 2], &[0, 1, 0, 1]);
    assert_sound(Run { sizes, steps: 1, ahead: 0, ordeal: Ordeal::None, flaw: None, sides });
}

#[test]
fn a_watcher_that_dies_is_relieved() {
    for (sizes, sides, _, ahead) in &SIDES[..4] {
        let ahead = if sizes.len() == 1 { *ahead } else { 0 };
        assert_sound(Run { sizes, steps: 2, ahead, ordeal: Ordeal::Replacement, flaw: None, sides });
    }
}

#[test]
fn what_the_protocol_guards_against_is_found() {
    let cases = [
        // Who opens a gate and who watches it: both look before they leap.
        (Flaw::LookBeforeOpening, 0, "nobody can go on"),
        (Flaw::LookBeforeLeaving, 0, "nobody can go on"),
        (Flaw::AnyWatcher, 1, "nobody can go on"),
        (Flaw::NoRelief, 0, "nobody can go on"),
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
        let (sizes, sides, steps): (&[u8], &[u8], u8) = match flaw {
            Flaw::AnyWatcher | Flaw::LookBeforeOpening | Flaw::LookBeforeLeaving | Flaw::NoRelief => {
                (&[3], &[0, 1, 1], 2)
            }
            _ => (&[2, 1], &[], 3),
        };
        let ordeals: &[Ordeal] = match flaw {
            Flaw::NoRepair | Flaw::NoRelief | Flaw::RepairUnclaimed => &[Ordeal::Replacement],
            _ => &[Ordeal::None, Ordeal::Interrupt],
        };
        let found = ordeals.iter().find_map(|&ordeal| {
            match check(&Run { sizes, steps, ahead, ordeal, flaw: Some(flaw), sides }) {
                Verdict::Broken(reason) => Some(reason),
                Verdict::Sound { .. } => None,
            }
        });
        let reason = found.unwrap_or_else(|| panic!("{flaw:?} was not found"));
        assert!(reason.contains(expected), "{flaw:?}: {reason}");
    }
}
