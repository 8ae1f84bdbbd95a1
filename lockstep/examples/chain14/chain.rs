//! The smallest formation: a plant, a planner, six observers and six controllers that exchange vectors of 12 numbers.

use lockstep::{
    Channel, ChannelId, Fault, Field, In, Input, Io, Layout, Network, Node, Out, Participant, Step, Store, Timing,
};

/// Numbers in a sample.
pub(crate) const WIDTH: usize = 12;
/// Observers, and controllers.
pub(crate) const AGENTS: usize = 6;
/// Nodes: the plant, the planner, the observers, the controllers.
pub(crate) const NODES: usize = 2 + 2 * AGENTS;

type Vector = [f64; WIDTH];

/// The nodes and channels. Channel i is the output of node i.
pub(crate) fn network() -> Network {
    let mut names = vec!["plant".to_string(), "planner".to_string()];
    names.extend((1..=AGENTS).map(|agent| format!("observer_{agent}")));
    names.extend((1..=AGENTS).map(|agent| format!("controller_{agent}")));
    let same_step = |node: usize| Input { channel: ChannelId(node), timing: Timing::SameStep };
    let delayed = |node: usize| Input { channel: ChannelId(node), timing: Timing::Delayed };
    let channel = |name: &String| Channel {
        topic: format!("/{name}"),
        agent: 0,
        layout: Layout::new([Field::vector("value", WIDTH, "")]),
    };
    let node = |(index, name): (usize, &String)| {
        let inputs = match index {
            0 => (0..AGENTS).map(|agent| delayed(2 + AGENTS + agent)).collect(),
            1 => vec![same_step(0)],
            observer if observer < 2 + AGENTS => vec![same_step(0), same_step(1)],
            controller => vec![same_step(0), same_step(1), same_step(controller - AGENTS)],
        };
        Node { name: name.clone(), inputs, outputs: vec![ChannelId(index)], every: 1, offset: 0 }
    };
    Network { channels: names.iter().map(channel).collect(), nodes: names.iter().enumerate().map(node).collect() }
}

/// The participant of a node of [`network`].
pub(crate) fn participant(node: usize) -> Box<dyn Participant> {
    match node {
        0 => Box::new(Plant { x: std::array::from_fn(|j| j as f64) }),
        1 => Box::new(Planner { w: std::array::from_fn(|j| 0.01 * j as f64) }),
        observer if observer < 2 + AGENTS => Box::new(Observer { z: [0.0; WIDTH] }),
        controller => Box::new(Controller { gain: 0.01 * (controller - 2 - AGENTS + 1) as f64 }),
    }
}

/// What identifies the result: the sum of the plant's state after `step`, the last that was run, bit by bit.
pub(crate) fn digest(store: &Store, step: u64) -> String {
    let read = |channel| {
        let mut value = [0.0; WIDTH];
        value.copy_from_slice(store.read(ChannelId(channel), step));
        value
    };
    let mut x = read(0);
    move_on(&mut x, |agent| read(2 + AGENTS + agent));
    let sum = x.iter().fold(0.0, |sum, value| sum + value);
    format!("{:016x}", sum.to_bits())
}

fn input(port: usize) -> In<WIDTH> {
    In::new(port, 0)
}

fn publish(io: &mut Io, value: Vector) {
    io.set(Out::new(0, 0), value);
}

fn move_on(x: &mut Vector, command: impl Fn(usize) -> Vector) {
    let commands: [Vector; AGENTS] = std::array::from_fn(command);
    for (j, value) in x.iter_mut().enumerate() {
        let mut sum = 0.0;
        for command in &commands {
            sum += command[j];
        }
        *value += 0.01 * sum;
    }
}

struct Plant {
    x: Vector,
}

impl Participant for Plant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if !step.is_first() {
            move_on(&mut self.x, |agent| io.get(input(agent)));
        }
        publish(io, self.x);
        Ok(())
    }
}

struct Planner {
    w: Vector,
}

impl Participant for Planner {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let x = io.get(input(0));
        publish(io, std::array::from_fn(|j| 0.5 * x[j] + self.w[j]));
        self.w.iter_mut().for_each(|value| *value += 0.0001);
        Ok(())
    }
}

struct Observer {
    z: Vector,
}

impl Participant for Observer {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let (x, r) = (io.get(input(0)), io.get(input(1)));
        for (j, value) in self.z.iter_mut().enumerate() {
            *value += 0.1 * (x[j] - *value) + 0.001 * r[j];
        }
        publish(io, self.z);
        Ok(())
    }
}

struct Controller {
    gain: f64,
}

impl Participant for Controller {
    fn step(&mut self, _: &Step, io: &mut Io) -> Result<(), Fault> {
        let (x, r, z) = (io.get(input(0)), io.get(input(1)), io.get(input(2)));
        publish(io, std::array::from_fn(|j| 0.5 * (r[j] - z[j]) - self.gain * x[j]));
        Ok(())
    }
}
