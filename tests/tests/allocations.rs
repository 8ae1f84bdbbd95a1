//! No law of any scenario takes memory once a run is warm, nor does the recorder on the thread that steps.
//!
//! One test in a file of its own: all threads of the program are counted.

use std::alloc::System;
use std::collections::BTreeMap;

use formation::scenario::Selection;
use formation::wiring::Assembly;
use lockstep::{Header, Local, Status};
use recording::{Recorder, RunInfo};
use schemes::{ROLES, SCENARIOS};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps until a run is warm: two chunks of the log, of 100 steps each.
const WARM: u64 = 210;
/// Steps after which the threads that compress are given time, so that the chunk they had can be used again.
const HALF: u64 = 150;
/// Steps that are counted. They end before a chunk of the log does, since the threads that compress it are not meant.
const COUNTED: u64 = 85;

/// Allocations of a scenario's default variant while it is warm.
fn allocations(name: &str) -> usize {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == name).expect("a shipped scenario");
    let assembly = Assembly::load(shipped.file, shipped.text, &Selection::default(), &ROLES)
        .unwrap_or_else(|problems| panic!("{}", problems[0]));
    let nodes: Vec<usize> = (0..assembly.network.nodes.len()).collect();
    let timing = assembly.scenario.context.timing;
    let participants = assembly.participants(&nodes).expect("participants");
    let mut local = Local::new(assembly.network.clone(), participants, timing.dt).expect("phases");
    let path = std::env::temp_dir().join(format!("phalanx-allocations-{}-{name}.mcap", std::process::id()));
    let (metadata, period) = (BTreeMap::new(), timing.period());
    let info = RunInfo { network: &assembly.network, period, scenario: "", metadata: &metadata, flush_every: 100 };
    let mut recorder = Recorder::create(&path, &info).expect("a log");
    let mut step = || {
        let step = local.step().unwrap_or_else(|error| panic!("{name}: {error:?}"));
        let absent = Header::new(step, period, 0, Status::Held);
        let header = |channel| local.store().header(channel, step).copied().unwrap_or(absent);
        recorder.record(step, local.store(), header).expect("it is recorded");
    };
    for index in 0..WARM {
        if index == HALF {
            std::thread::sleep(std::time::Duration::from_millis(200));
        }
        step();
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let region = Region::new(ALLOCATOR);
    (0..COUNTED).for_each(|_| step());
    let change = region.change();
    recorder.finish().expect("the log is closed");
    std::fs::remove_file(path).expect("the log is removed");
    change.allocations + change.reallocations
}

#[test]
fn a_warm_step_allocates_nothing() {
    let found: Vec<(&str, usize)> = SCENARIOS.iter().map(|shipped| (shipped.name, allocations(shipped.name))).collect();
    let wrong: Vec<&(&str, usize)> = found.iter().filter(|(_, count)| *count > 0).collect();
    assert!(wrong.is_empty(), "allocations in {COUNTED} steps: {wrong:?}");
}
