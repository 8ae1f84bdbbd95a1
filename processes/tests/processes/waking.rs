//! Processes that wake each other by events, which may be lost.

use std::time::Duration;

use lockstep::{Plan, Wake};
use processes::{Conductor, RunDirectory, Settings};

use crate::chain;
use crate::results::local_chain;
use crate::support::{Traces, launch_by, settings, singles, worker_command, workers};

#[test]
fn wake_ups_that_are_lost_cost_time_only() {
    let network = chain::network(chain::AGENTS);
    let (groups, steps) = (singles(&network), 200);
    let settings = Settings { wake: Wake::Events, ..settings() };
    let lossy = || {
        let mut command = worker_command("chain");
        // One time in three, a process that opens a gate wakes no other.
        command.env("PHALANX_LOSE_WAKE_UPS", "3");
        command
    };
    let mut conductor = launch_by("lossy", &network, &groups, steps, settings, lossy);
    conductor.wait_ready(Duration::from_secs(60)).unwrap();
    let traces = Traces::of(&conductor);
    let mut local = local_chain();
    for _ in 0..steps {
        local.step().unwrap();
        conductor.step().unwrap();
    }
    let [expected, found] =
        [local.store(), conductor.store()].map(|store| chain::digest(chain::AGENTS, store, steps - 1));
    assert_eq!(found, expected);
    conductor.finish().unwrap();
    traces.assert_none();
}

#[test]
fn a_name_too_long_for_sockets_is_refused_in_words() {
    let network = chain::network(chain::AGENTS);
    let name = "a-name-of-thirty-characters---";
    let plan = Plan::new(name, network.clone(), 1_000_000, 1, workers(&network, &singles(&network))).unwrap();
    let settings = Settings { wake: Wake::Events, ..settings() };
    let Err(error) = Conductor::new(RunDirectory::create(name).unwrap(), plan, settings) else {
        panic!("its sockets cannot be there")
    };
    let message = error.to_string();
    assert!(message.contains(name) && message.contains("call it `a-name-"), "{message}");
}
