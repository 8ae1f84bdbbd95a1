//! What the workers of the tests do. A play is `kind`, or `kind:node:step` for a mishap at a node (or nodes, with `+` in
//! between) and step.

use std::alloc::{GlobalAlloc, Layout, System};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use lockstep::{Fault, Io, Node, Participant, Plan, Slice, Step};

use crate::{chain, support::PLAY};

/// Counts what is allocated.
struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Not a test: this is what a worker process of the tests runs.
#[test]
fn worker_entry() {
    if std::env::var_os("PHALANX_WORKER").is_some() {
        if let Some(step) = std::env::var(PLAY).ok().and_then(|play| play.strip_prefix("hasty:")?.parse().ok()) {
            std::process::exit(if hurry(step).is_ok() { 0 } else { 1 });
        }
        let ended = processes::serve(build);
        std::process::exit(if ended == ExitCode::SUCCESS { 0 } else { 1 });
    }
}

/// Asks for its steps itself, with zeros for outputs; the controller of agent 3 asks for one too many at `step`.
fn hurry(step: u64) -> Result<(), Fault> {
    let worker = processes::Worker::join().map_err(|reason| Fault(reason.to_string()))?;
    let hasty = worker.nodes() == [10];
    let mut link = worker.connect()?;
    assert!(link.io().is_none(), "inputs before a step");
    while let Some(due) = link.next()? {
        assert_eq!(due.number, 0);
        link.io().expect("outputs in a step").slice_mut(Slice::new(0, 0, chain::WIDTH)).fill(0.0);
        if hasty && due.step.index == step {
            link.next()?;
        }
        link.done()?;
    }
    Ok(())
}

fn build(plan: &Plan, nodes: &[usize]) -> Result<Vec<Box<dyn Participant>>, String> {
    let play = std::env::var(PLAY).map_err(|error| error.to_string())?;
    if play == "refuse" && nodes.contains(&3) {
        return Err("there is no such observer".into());
    }
    if play == "late" && nodes.contains(&3) {
        std::thread::sleep(std::time::Duration::from_secs(60));
    }
    Ok(nodes.iter().map(|&node| participant(&play, plan, node)).collect())
}

/// The participant of a node.
pub(crate) fn participant(play: &str, plan: &Plan, node: usize) -> Box<dyn Participant> {
    let parts: Vec<&str> = play.split(':').collect();
    let inner = match parts[0] {
        "sum" => Box::new(Sum::of(plan, node)),
        "chain100" => chain::participant(100, node),
        _ => chain::participant(chain::AGENTS, node),
    };
    match parts[..] {
        ["count"] => Box::new(Frugal { inner, allocations: 0 }),
        [mishap, at_nodes, at_step] if at_nodes.split('+').any(|at| at.parse() == Ok(node)) => {
            Box::new(Unlucky { inner, mishap: mishap.into(), at: at_step.parse().unwrap() })
        }
        _ => inner,
    }
}

/// Adds up all its inputs, the number of the step and what it had before.
struct Sum {
    inputs: usize,
    output: Slice,
    total: f64,
}

impl Sum {
    fn of(plan: &Plan, node: usize) -> Self {
        let Node { inputs, outputs, .. } = &plan.network.nodes[node];
        let words = plan.network.channels[outputs[0].0].layout.words();
        Self { inputs: inputs.len(), output: Slice::new(0, 0, words), total: node as f64 }
    }
}

impl Participant for Sum {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.total = 0.3 * self.total + step.time();
        for port in 0..self.inputs {
            self.total += 0.1 * io.slice(Slice::new(port, 0, 1))[0];
        }
        io.slice_mut(self.output).fill(self.total);
        Ok(())
    }
}

/// Complains if the process allocates once the first steps are over.
struct Frugal {
    inner: Box<dyn Participant>,
    allocations: u64,
}

impl Participant for Frugal {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        match (step.index, ALLOCATIONS.load(Relaxed)) {
            (100, count) => self.allocations = count,
            (101.., count) if count != self.allocations => return Err(Fault("it allocates".into())),
            _ => {}
        }
        self.inner.step(step, io)
    }
}

/// Something happens to it at one step.
struct Unlucky {
    inner: Box<dyn Participant>,
    mishap: String,
    at: u64,
}

impl Participant for Unlucky {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.inner.step(step, io)?;
        if step.index != self.at {
            return Ok(());
        }
        match self.mishap.as_str() {
            "nan" => io.slice_mut(Slice::new(0, 0, chain::WIDTH))[5] = f64::NAN,
            // Another number in every process.
            "drift" => io.slice_mut(Slice::new(0, 0, chain::WIDTH))[0] = std::process::id().into(),
            "fault" => return Err(Fault("the reference is out of reach".into())),
            "panic" => panic!("an index of {} is out of range", 17),
            "exit" => {
                eprintln!("first line\nsecond line");
                std::process::exit(3);
            }
            _ => {}
        }
        Ok(())
    }
}
