//! The smallest formation: a plant, a planner, and an observer and a controller per agent that exchange vectors of 12 numbers.

use lockstep::{
    Channel, ChannelId, Fault, Field, In, Input, Io, Layout, Network, Node, Out, Participant, Step, Store, Timing,
};

/// Numbers in a sample.
pub(crate) const WIDTH: usize = 12;
/// Agents of the formation that gave it its name.
pub(crate) const AGENTS: usize = 6;
/// Nodes of that one: the plant, the planner, the observers, the controllers.
pub(crate) const NODES: usize = nodes(AGENTS);

type Vector = [f64; WIDTH];

/// Number of nodes with so many agents.
pub(crate) const fn nodes(agents: usize) -> usize {
    2 + 2 * agents
}

/// The nodes and channels. Channel i is the output of node i.
pub(crate) fn network(agents: usize) -> Network {
    let mut names = vec!["plant".to_string(), "planner".to_string()];
    names.extend((1..=agents).map(|agent| format!("observer_{agent}")));
    names.extend((1..=agents).map(|agent| format!("controller_{agent}")));
    let same_step = |node: usize| Input { channel: ChannelId(node), timing: Timing::SameStep };
    let delayed = |node: usize| Input { channel: ChannelId(node), timing: Timing::Delayed };
    let channel = |name: &String| Channel {
        topic: format!("/{name}"),
        agent: 0,
        layout: Layout::new([Field::vector("value", WIDTH, "")]),
        initial: Vec::new(),
    };
    let node = |(index, name): (usize, &String)| {
        let inputs = match index {
            0 => (0..agents).map(|agent| delayed(2 + agents + agent)).collect(),
            1 => vec![same_step(0)],
            observer if observer < 2 + agents => vec![same_step(0), same_step(1)],
            controller => vec![same_step(0), same_step(1), same_step(controller - agents)],
        };
        Node { name: name.clone(), inputs, outputs: vec![ChannelId(index)], every: 1, offset: 0 }
    };
    Network { channels: names.iter().map(channel).collect(), nodes: names.iter().enumerate().map(node).collect() }
}

/// The participant of a node of [`network`].
pub(crate) fn participant(agents: usize, node: usize) -> Box<dyn Participant> {
    match node {
        0 => Box::new(Plant { agents, x: std::array::from_fn(|j| j as f64) }),
        1 => Box::new(Planner { w: std::array::from_fn(|j| 0.01 * j as f64) }),
        observer if observer < 2 + agents => Box::new(Observer { z: [0.0; WIDTH] }),
        controller => Box::new(Controller { gain: 0.01 * (controller - 2 - agents + 1) as f64 }),
    }
}

/// What identifies the result: the sum of the plant's state after `step`, the last that was run, bit by bit.
pub(crate) fn digest(agents: usize, store: &Store, step: u64) -> String {
    let read = |channel| {
        let mut value = [0.0; WIDTH];
        value.copy_from_slice(store.read(ChannelId(channel), step));
        value
    };
    let mut x = read(0);
    move_on(&mut x, agents, |agent| read(2 + agents + agent));
    let sum = x.iter().fold(0.0, |sum, value| sum + value);
    format!("{:016x}", sum.to_bits())
}

fn input(port: usize) -> In<WIDTH> {
    In::new(port, 0)
}

fn publish(io: &mut Io, value: Vector) {
    io.set(Out::new(0, 0), value);
}

fn move_on(x: &mut Vector, agents: usize, command: impl Fn(usize) -> Vector) {
    let mut sum = [0.0; WIDTH];
    for agent in 0..agents {
        let command = command(agent);
        sum.iter_mut().zip(command).for_each(|(sum, value)| *sum += value);
    }
    x.iter_mut().zip(sum).for_each(|(value, sum)| *value += 0.01 * sum);
}

struct Plant {
    agents: usize,
    x: Vector,
}

impl Participant for Plant {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        if !step.is_first() {
            move_on(&mut self.x, self.agents, |agent| io.get(input(agent)));
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
