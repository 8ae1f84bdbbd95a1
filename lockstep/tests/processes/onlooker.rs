//! Somebody looks at a run from outside.

use lockstep::{ChannelId, Local, LookError, Onlooker};

use crate::chain;
use crate::support::{Traces, settings, singles, start};

const STEPS: u64 = 600;

fn local() -> Local {
    let participants = (0..chain::NODES).map(|node| chain::participant(chain::AGENTS, node)).collect();
    Local::new(chain::network(chain::AGENTS), participants, 1e-3).unwrap()
}

/// Looks, and compares everything with the same step in one process; the step.
fn compare(onlooker: &mut Onlooker, local: &mut Local, done: &mut Option<u64>) -> Option<u64> {
    let step = onlooker.look()?;
    while done.is_none_or(|done| done < step) {
        *done = Some(local.step().unwrap());
    }
    for channel in (0..onlooker.network().channels.len()).map(ChannelId) {
        let (header, words) = onlooker.sample(channel);
        assert_eq!(header, local.store().header(channel, step).unwrap(), "step {step}, channel {}", channel.0);
        assert_eq!(words, local.store().read(channel, step), "step {step}, channel {}", channel.0);
    }
    Some(step)
}

#[test]
fn every_look_is_one_whole_step_and_the_last_one_is_seen() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("looked-at", &network, &singles(&network), STEPS, settings(), "chain");
    let traces = Traces::of(&conductor);
    let name = conductor.directory().name().to_string();
    let mut onlooker = Onlooker::join(&name, network.clone()).unwrap();
    // One who leaves early is not missed.
    drop(Onlooker::join(&name, network.clone()).unwrap());
    let (mut local, mut done) = (local(), None);
    let mut seen = Vec::new();
    for step in 0..STEPS {
        conductor.step().unwrap();
        if step % 7 == 0 {
            seen.extend(compare(&mut onlooker, &mut local, &mut done));
        }
    }
    assert!(seen.len() > 40, "{} looks", seen.len());
    assert!(seen.windows(2).all(|pair| pair[0] <= pair[1]), "{seen:?}");
    assert!(!onlooker.is_over());
    conductor.finish().unwrap();
    assert!(onlooker.is_over());
    assert_eq!(compare(&mut onlooker, &mut local, &mut done), Some(STEPS - 1));
    traces.assert_none();

    // Another run has the name by now; letting go of the old one does not touch it.
    let mut next = start("looked-at", &network, &singles(&network), 20, settings(), "chain");
    assert_eq!(next.directory().name(), name);
    assert!(onlooker.is_over());
    drop(onlooker);
    let mut again = Onlooker::join(&name, network.clone()).unwrap();
    for _ in 0..20 {
        next.step().unwrap();
    }
    assert_eq!(again.look(), Some(19));
    drop(again);
    let traces = Traces::of(&next);
    next.finish().unwrap();
    traces.assert_none();
    assert!(matches!(Onlooker::join(&name, network), Err(LookError::Over(_))));
}

#[test]
fn more_onlookers_than_there_are_places_are_told() {
    let network = chain::network(chain::AGENTS);
    let conductor = start("crowded", &network, &singles(&network), 10, settings(), "chain");
    let name = conductor.directory().name().to_string();
    let results: Vec<_> = (0..8).map(|_| Onlooker::join(&name, network.clone())).collect();
    let joined = results.iter().filter(|result| result.is_ok()).count();
    assert!((4..8).contains(&joined), "{joined} have joined");
    assert!(results.iter().all(|result| matches!(result, Ok(_) | Err(LookError::Service(_)))));
    drop(results);
    conductor.finish().unwrap();
}
