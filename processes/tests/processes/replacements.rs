//! Processes that take the place of others while the run goes on.

use std::io;
use std::ops::Range;
use std::time::Duration;

use lockstep::{ChannelId, Header, Local, Status, Store};
use processes::{Conductor, History, Replacement, RunError, Settings, allowed_cores};
use rustix::process::{Pid, Signal, kill_process};

use crate::chain;
use crate::support::{Traces, all_ways, settings, singles, start, worker_command};

const STEPS: u64 = 2200;
const DIGEST: &str = "401660ed0ae7a22d";

/// All samples of all steps, as a recorder would have them.
#[derive(Default)]
struct Memory {
    steps: Vec<Vec<(Option<Header>, Vec<f64>)>>,
}

impl Memory {
    fn note(&mut self, conductor: &Conductor, step: u64) {
        let store = conductor.store();
        let channels = (0..conductor.plan().network.channels.len()).map(ChannelId);
        let sample = |channel| (store.header(channel, step).copied(), store.read(channel, step).to_vec());
        self.steps.push(channels.map(sample).collect());
    }
}

impl History for Memory {
    fn play(&mut self, steps: Range<u64>, visit: &mut dyn FnMut(&Store, u64) -> io::Result<()>) -> io::Result<()> {
        let network = chain::network(chain::AGENTS);
        let mut store = Store::new(network.channels.iter().map(|channel| &channel.layout));
        for step in steps {
            for (channel, (header, words)) in self.steps[step as usize].iter().enumerate() {
                store.write(ChannelId(channel), step).copy_from_slice(words);
                header.iter().for_each(|header| store.stamp(ChannelId(channel), step, *header));
            }
            visit(&store, step)?;
        }
        Ok(())
    }
}

fn kill(conductor: &Conductor, worker: usize) {
    kill_process(Pid::from_raw(conductor.pid(worker).unwrap() as i32).unwrap(), Signal::KILL).unwrap();
}

/// Replaces the workers that have failed until the run can go on.
fn mend(conductor: &mut Conductor, memory: &mut Memory, mut error: RunError) -> usize {
    let mut replaced = 0;
    loop {
        let failed_workers = conductor.failed_workers(&error);
        assert!(!failed_workers.is_empty(), "{error}");
        let mut failed = None;
        for worker in failed_workers {
            let result =
                conductor.replace(worker, worker_command("chain"), None, Replacement::Recompute { since: 0 }, memory);
            failed = result.err();
            replaced += 1;
        }
        match failed {
            Some(again) => error = again,
            None => return replaced,
        }
    }
}

/// Runs a chain and kills workers: `victims` of a step, when the conductor has seen it; returns the digest.
fn digest_with_kills(
    name: &str,
    groups: &[Vec<usize>],
    settings: Settings,
    victims: impl Fn(u64) -> Vec<usize>,
) -> (String, usize) {
    let network = chain::network(chain::AGENTS);
    finish_with_kills(start(name, &network, groups, STEPS, settings, "chain"), victims)
}

fn finish_with_kills(mut conductor: Conductor, victims: impl Fn(u64) -> Vec<usize>) -> (String, usize) {
    let mut memory = Memory::default();
    let mut replaced = 0;
    for step in 0..STEPS {
        loop {
            match conductor.step() {
                Ok(done) => break assert_eq!(done, step),
                Err(error) => replaced += mend(&mut conductor, &mut memory, error),
            }
        }
        memory.note(&conductor, step);
        victims(step).into_iter().for_each(|worker| kill(&conductor, worker));
    }
    let traces = Traces::of(&conductor);
    let digest = chain::digest(chain::AGENTS, conductor.store(), STEPS - 1);
    conductor.finish().unwrap();
    traces.assert_none();
    (digest, replaced)
}

#[test]
fn killed_workers_are_replaced_without_a_trace() {
    let groups = singles(&chain::network(chain::AGENTS));
    // A plant, a planner, an observer and a controller, at different moments of their steps, since they run ahead.
    let victims = |step| match step {
        0 => vec![3],
        40 => vec![0],
        41 => vec![1],
        300 => vec![10, 4, 0],
        1000 => vec![13],
        1002 => vec![13],
        _ => vec![],
    };
    for settings in all_ways() {
        let (digest, replaced) = digest_with_kills("replacement", &groups, settings, victims);
        assert_eq!(digest, DIGEST);
        assert!(replaced >= 7, "{replaced}");
    }
}

#[test]
fn polling_workers_are_killed_and_replaced_without_a_trace() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("watchers", &network, &singles(&network), STEPS, settings(), "chain");
    let cores = allowed_cores().unwrap();
    let turns = (0..chain::NODES).map(|worker| cores[worker % cores.len().min(2)]);
    conductor.spread(&turns.collect::<Vec<_>>()).unwrap();
    // Who watches is a matter of chance: so many are killed that some of them do.
    let victims = |step: u64| if step % 70 == 60 { vec![2 + (step / 70) as usize % 12] } else { vec![] };
    let (digest, replaced) = finish_with_kills(conductor, victims);
    assert_eq!(digest, DIGEST);
    assert!(replaced > 20, "{replaced}");
}

#[test]
fn a_worker_with_nodes_in_several_phases_comes_back() {
    let mut groups = vec![vec![1], vec![0]];
    groups.extend((2..8).map(|observer| vec![observer + 6, observer]));
    let victims = |step: u64| if step.is_multiple_of(250) { vec![2 + (step / 250) as usize % 6] } else { vec![] };
    let (digest, _) = digest_with_kills("replacement-agents", &groups, settings(), victims);
    assert_eq!(digest, DIGEST);
}

#[test]
fn a_failed_worker_is_held() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("held", &network, &singles(&network), 200, settings(), "chain");
    let mut memory = Memory::default();
    let mut last = Vec::new();
    let mut held_from = None;
    for step in 0..200 {
        while let Err(error) = conductor.step() {
            assert_eq!(conductor.failed_workers(&error), [10]);
            held_from = Some(step);
            conductor.replace(10, worker_command("chain"), None, Replacement::Hold, &mut memory).unwrap();
        }
        memory.note(&conductor, step);
        let channel = ChannelId(network.nodes[10].outputs[0].0);
        let status = conductor.store().header(channel, step).unwrap().status;
        let words = conductor.store().read(channel, step);
        if status == Status::Stale as u32 {
            assert_eq!(words, last);
        } else {
            assert_eq!(held_from.filter(|&from| step > from), None, "it is fresh again at {step}");
            last = words.to_vec();
        }
        if step == 50 {
            kill(&conductor, 10);
        }
    }
    assert!(held_from.is_some_and(|from| (50..60).contains(&from)), "{held_from:?}");
    conductor.finish().unwrap();
}

#[test]
fn another_program_takes_over_at_a_step() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("adopted", &network, &singles(&network), 100, settings(), "chain");
    let mut memory = Memory::default();
    for step in 0..100 {
        if step == 40 {
            conductor.replace(10, worker_command("sum"), None, Replacement::Adopt, &mut memory).unwrap();
        }
        conductor.step().unwrap();
        memory.note(&conductor, step);
    }
    let participants = (0..chain::NODES).map(|node| chain::participant(chain::AGENTS, node)).collect();
    let mut local = Local::new(network.clone(), participants, 1e-3).unwrap();
    let channel = network.nodes[10].outputs[0];
    let mut departures = (0..100).filter(|&step| {
        local.step().unwrap();
        local.store().read(channel, step) != memory.steps[step as usize][channel.0].1
    });
    // Its last sample at the moment of the change may still be that of the program before.
    assert!(departures.next().is_some_and(|step| (40..=48).contains(&step)));
    conductor.finish().unwrap();
}

#[test]
fn what_does_not_follow_from_its_inputs_cannot_come_back() {
    let network = chain::network(chain::AGENTS);
    let mut conductor = start("drift", &network, &singles(&network), 100, settings(), "drift:10:20");
    let mut memory = Memory::default();
    for step in 0..60 {
        conductor.step().unwrap();
        memory.note(&conductor, step);
    }
    let result =
        conductor.replace(10, worker_command("drift:10:20"), None, Replacement::Recompute { since: 0 }, &mut memory);
    let message = result.unwrap_err().to_string();
    assert!(message.contains("it recomputes /controller_3 value[0] of step 20"), "{message}");
    conductor.finish().unwrap();
}

#[test]
fn a_worker_that_hangs_is_replaced_after_the_deadline() {
    let network = chain::network(chain::AGENTS);
    for settings in all_ways() {
        let settings = Settings { deadline: Duration::from_millis(500), ..settings };
        let mut conductor = start("hung", &network, &singles(&network), 300, settings, "chain");
        let mut memory = Memory::default();
        for step in 0..300 {
            while let Err(error) = conductor.step() {
                assert!(matches!(error, RunError::Deadline { .. }), "{error}");
                mend(&mut conductor, &mut memory, error);
            }
            memory.note(&conductor, step);
            if step == 100 {
                kill_process(Pid::from_raw(conductor.pid(5).unwrap() as i32).unwrap(), Signal::STOP).unwrap();
            }
        }
        conductor.finish().unwrap();
    }
}
