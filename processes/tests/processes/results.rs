//! What comes out of a run does not depend on how it is spread over processes.

use lockstep::{
    Channel, ChannelId, Field, Input, Layout, Local, MAX_WORDS, Network, Node, Plan, PlanError, Status, Timing, Wake,
};
use processes::{Conductor, Settings, allowed_cores};

use crate::support::{Traces, all_ways, eventually, settings, singles, start, workers};
use crate::{chain, worker};

const STEPS: u64 = 2200;
const DIGEST: &str = "401660ed0ae7a22d";

pub(crate) fn local_chain() -> Local {
    let network = chain::network(chain::AGENTS);
    let participants = (0..chain::NODES).map(|node| chain::participant(chain::AGENTS, node)).collect();
    Local::new(network, participants, 1e-3).unwrap()
}

fn digest_in_processes(name: &str, groups: &[Vec<usize>], settings: Settings, play: &str) -> String {
    digest_of(start(name, &chain::network(chain::AGENTS), groups, STEPS, settings, play))
}

fn digest_of(mut conductor: Conductor) -> String {
    let traces = Traces::of(&conductor);
    for step in 0..STEPS {
        assert_eq!(conductor.step().unwrap(), step);
    }
    assert!(conductor.step().unwrap_err().to_string().contains("over after 2200 steps"));
    let digest = chain::digest(chain::AGENTS, conductor.store(), STEPS - 1);
    conductor.finish().unwrap();
    traces.assert_none();
    digest
}

#[test]
fn chain_in_one_process() {
    for (steps, digest) in [(1, "4050ab052a0b6c44"), (10, "40509fa41c6cffbc"), (STEPS, DIGEST)] {
        let mut local = local_chain();
        for _ in 0..steps {
            local.step().unwrap();
        }
        assert_eq!(chain::digest(chain::AGENTS, local.store(), steps - 1), digest, "{steps} steps");
    }
}

#[test]
fn chain_in_fourteen_processes_without_allocations() {
    let groups = singles(&chain::network(chain::AGENTS));
    assert_eq!(digest_in_processes("fourteen", &groups, settings(), "count"), DIGEST);
    // A process connects to all listeners when it notifies for the first time, whenever that is; with events nothing is promised.
    let settings = Settings { wake: Wake::Events, ..settings() };
    assert_eq!(digest_in_processes("fourteen", &groups, settings, "chain"), DIGEST);
}

#[test]
fn chain_in_other_groupings() {
    let together = vec![(0..chain::NODES).rev().collect()];
    let halves = vec![(0..7).collect(), (7..chain::NODES).collect()];
    let mut agents = vec![vec![1], vec![0]];
    agents.extend((2..8).map(|observer| vec![observer + 6, observer]));
    for settings in all_ways() {
        for (name, groups) in [("together", &together), ("halves", &halves), ("agents", &agents)] {
            assert_eq!(digest_in_processes(name, groups, settings, "chain"), DIGEST);
        }
    }
}

/// The two cores that a test moves workers between: the same one twice if there is only one.
fn two_cores() -> [usize; 2] {
    let cores = allowed_cores().unwrap();
    [cores[0], cores[cores.len() - 1]]
}

#[test]
fn workers_are_moved_between_cores_while_the_run_goes_on() {
    let network = chain::network(chain::AGENTS);
    for settings in all_ways() {
        move_workers(start("moved", &network, &singles(&network), STEPS, settings, "chain"));
    }
}

fn move_workers(mut conductor: Conductor) {
    let cores = two_cores();
    for step in 0..STEPS {
        // Together, in turns, in halves, the other way round, and back again at once.
        let place: Option<fn(usize) -> usize> = match step {
            100 => Some(|worker| worker % 2),
            800 => Some(|worker| usize::from(worker < 7)),
            1400 => Some(|worker| usize::from(worker != 0)),
            1401 => Some(|worker| usize::from(worker == 0)),
            2000 => Some(|_| 1),
            _ => None,
        };
        if let Some(place) = place {
            let chosen: Vec<usize> = (0..chain::NODES).map(|worker| cores[place(worker)]).collect();
            conductor.spread(&chosen).unwrap();
        }
        assert_eq!(conductor.step().unwrap(), step);
    }
    assert!(conductor.spread(&cores).is_err(), "as many cores as workers");
    assert_eq!(chain::digest(chain::AGENTS, conductor.store(), STEPS - 1), DIGEST);
    conductor.finish().unwrap();
}

#[test]
fn the_best_number_of_cores_is_searched_and_told() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("balanced", &network, &singles(&network), STEPS, settings(), "chain");
    let cores = two_cores();
    assert_eq!(conductor.core_findings(), None);
    conductor.spread(&[cores[1]; chain::NODES]).unwrap();
    conductor.tune_cores(vec![cores[1], cores[0]]);
    for step in 0..STEPS {
        assert_eq!(conductor.step().unwrap(), step);
    }
    assert_eq!(chain::digest(chain::AGENTS, conductor.store(), STEPS - 1), DIGEST);
    let found = conductor.core_findings().unwrap();
    assert!(found.alone.is_some_and(|time| !time.is_zero()), "{found:?}");
    assert_eq!(found.cores[0], cores[1]);
    conductor.finish().unwrap();
}

#[test]
fn two_runs_of_one_name_at_once() {
    let run = || digest_in_processes("twins", &singles(&chain::network(chain::AGENTS)), settings(), "chain");
    std::thread::scope(|scope| {
        let runs = [scope.spawn(run), scope.spawn(run)];
        assert_eq!(runs.map(|run| run.join().unwrap()), [DIGEST, DIGEST]);
    });
}

#[test]
fn without_recording_the_store_stays_as_it_was() {
    let mut conductor = start(
        "blind",
        &chain::network(chain::AGENTS),
        &singles(&chain::network(chain::AGENTS)),
        20,
        settings(),
        "chain",
    );
    conductor.set_recording(false);
    for _ in 0..18 {
        conductor.step().unwrap();
    }
    assert_eq!(conductor.store().header(ChannelId(0), 17), None);
    conductor.set_recording(true);
    for _ in 18..20 {
        conductor.step().unwrap();
    }
    assert_eq!(conductor.store().header(ChannelId(0), 19).unwrap().step, 19);
    let mut local = local_chain();
    for _ in 0..20 {
        local.step().unwrap();
    }
    assert_eq!(chain::digest(chain::AGENTS, conductor.store(), 19), chain::digest(chain::AGENTS, local.store(), 19));
    conductor.finish().unwrap();
}

/// Nodes that run at different rates, with same-step and delayed edges between all of them.
fn rates() -> Network {
    let node = |index: usize, every, offset, inputs: &[(usize, Timing)]| Node {
        name: format!("n{index}"),
        inputs: inputs.iter().map(|&(c, timing)| Input { channel: ChannelId(c), timing }).collect(),
        outputs: vec![ChannelId(index)],
        every,
        offset,
    };
    use Timing::{Delayed, SameStep};
    let nodes = vec![
        node(0, 1, 0, &[(3, Delayed), (2, Delayed)]),
        node(1, 3, 0, &[(0, SameStep), (3, Delayed)]),
        node(2, 5, 2, &[(0, SameStep), (1, SameStep), (2, Delayed)]),
        node(3, 1, 4, &[(1, SameStep), (2, SameStep), (0, Delayed)]),
    ];
    let channel = |index| Channel {
        topic: format!("/c{index}"),
        agent: index,
        layout: Layout::new([Field::scalar("value", "")]),
        initial: if index % 2 == 0 { vec![0.25 * f64::from(index) + 1.0] } else { Vec::new() },
    };
    Network { channels: (0..4).map(channel).collect(), nodes }
}

#[test]
fn nodes_at_lower_rates_hold_their_samples_alike_everywhere() {
    let network = rates();
    for (name, groups) in [("rates-4", singles(&network)), ("rates-2", vec![vec![0, 2], vec![1, 3]])] {
        let plan = Plan::new(name, network.clone(), 1_000_000, 60, workers(&network, &groups)).unwrap();
        let participants = (0..4).map(|node| worker::participant("sum", &plan, node)).collect();
        let mut local = Local::new(network.clone(), participants, plan.dt).unwrap();
        let mut conductor = start(name, &network, &groups, 60, settings(), "sum");
        for step in 0..60 {
            local.step().unwrap();
            conductor.step().unwrap();
            for channel in (0..4).map(ChannelId) {
                let (ours, theirs) = (local.store(), conductor.store());
                assert_eq!(ours.header(channel, step), theirs.header(channel, step), "{channel:?} at {step}");
                assert_eq!(ours.read(channel, step), theirs.read(channel, step), "{channel:?} at {step}");
            }
        }
        let header = |step| conductor.store().header(ChannelId(1), step).copied().unwrap();
        assert_eq!((header(58).step, header(58).status), (57, Status::Held as u32));
        assert_eq!((header(59).step, header(59).time_ns()), (57, 57_000_000));
        conductor.finish().unwrap();
    }
}

#[test]
fn a_hundred_workers_in_one_phase() {
    let channel = |index| Channel {
        topic: format!("/c{index}"),
        agent: index,
        layout: Layout::new([Field::vector("value", 2, "")]),
        initial: Vec::new(),
    };
    let before = |index: usize| Input { channel: ChannelId((index + 99) % 100), timing: Timing::Delayed };
    let node = |index| Node {
        name: format!("n{index}"),
        inputs: vec![before(index)],
        outputs: vec![ChannelId(index)],
        every: 1,
        offset: 0,
    };
    let network = Network { channels: (0..100).map(channel).collect(), nodes: (0..100).map(node).collect() };
    let plan = Plan::new("hundred", network.clone(), 1_000_000, 200, workers(&network, &singles(&network))).unwrap();
    let participants = (0..100).map(|node| worker::participant("sum", &plan, node)).collect();
    let mut local = Local::new(network.clone(), participants, plan.dt).unwrap();
    let mut conductor = start("hundred", &network, &singles(&network), 200, settings(), "sum");
    let traces = Traces::of(&conductor);
    for step in 0..200 {
        local.step().unwrap();
        assert_eq!(conductor.step().unwrap(), step);
    }
    for channel in (0..100).map(ChannelId) {
        assert_eq!(local.store().read(channel, 199), conductor.store().read(channel, 199));
    }
    conductor.finish().unwrap();
    traces.assert_none();
}

#[test]
fn two_hundred_processes_give_the_same_bits_and_leave_nothing() {
    let (agents, steps) = (100, 50);
    let network = chain::network(agents);
    let participants = (0..chain::nodes(agents)).map(|node| chain::participant(agents, node)).collect();
    let mut local = Local::new(network.clone(), participants, 1e-3).unwrap();
    (0..steps).for_each(|_| local.step().map(drop).unwrap());
    for settings in all_ways() {
        let mut conductor = start("two-hundred", &network, &singles(&network), steps, settings, "chain100");
        let traces = Traces::of(&conductor);
        (0..steps).for_each(|_| conductor.step().map(drop).unwrap());
        let [ours, theirs] = [local.store(), conductor.store()].map(|store| chain::digest(agents, store, steps - 1));
        assert_eq!(ours, theirs);
        conductor.finish().unwrap();
        traces.assert_none();
    }
}

#[test]
fn no_worker_runs_ahead_of_a_conductor_that_does_not_want_it() {
    let mut conductor = start(
        "abreast",
        &chain::network(chain::AGENTS),
        &singles(&chain::network(chain::AGENTS)),
        40,
        settings(),
        "chain",
    );
    let statistics = conductor.statistics();
    conductor.set_ahead(0);
    for step in 0..20 {
        conductor.step().unwrap();
        assert_eq!(statistics.read().completed, step + 1);
    }
    conductor.set_ahead(1000);
    conductor.step().unwrap();
    eventually("they run ahead", || statistics.read().completed == 28);
    let snapshot = statistics.read();
    assert_eq!(snapshot.awaited, ["plant"]);
    assert!(snapshot.workers.iter().all(|worker| worker.runs == 28 && !worker.compute.is_zero()), "{snapshot:?}");
    for _ in 21..40 {
        conductor.step().unwrap();
    }
    conductor.finish().unwrap();
    assert_eq!(statistics.read().completed, 40);
}

#[test]
fn a_sample_that_fits_no_cell_is_refused_in_words() {
    let mut network = rates();
    network.channels[2].layout = Layout::new([Field::vector("image", MAX_WORDS + 1, "")]);
    let error = Plan::new("large", network.clone(), 1, 1, workers(&network, &singles(&network))).unwrap_err();
    assert!(matches!(error, PlanError::Large { words: 513, .. }));
    assert!(error.to_string().contains("/c2"), "{error}");
    network.channels[2].layout = Layout::new([Field::vector("image", MAX_WORDS, "")]);
    network.channels[2].initial = vec![0.5; MAX_WORDS];
    let mut conductor = start("large", &network, &singles(&network), 10, settings(), "sum");
    for _ in 0..10 {
        conductor.step().unwrap();
    }
    conductor.finish().unwrap();
}
