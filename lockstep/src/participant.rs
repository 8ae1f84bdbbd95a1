//! What a participant is, and what it sees of its channels.

use crate::{ChannelId, Node, Store, Timing};

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Number of the step, from 0.
    pub index: u64,
    /// Length of a step in seconds.
    pub dt: f64,
}

impl Step {
    /// Simulated time at the start of the step, in seconds.
    pub fn time(&self) -> f64 {
        self.index as f64 * self.dt
    }

    /// Whether this is step 0, at which nothing precedes and delayed inputs read as the initial samples of their channels.
    pub fn is_first(&self) -> bool {
        self.index == 0
    }
}

/// A participant that cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Fault(pub String);

/// A node of the step graph: reads its inputs, computes, writes its outputs, once per step.
///
/// `step` must be a deterministic function of the inputs and of the participant's own state: no clock, no randomness that
/// is not seeded, no I/O. It must not allocate once the first steps are over.
pub trait Participant: Send {
    /// Computes one step.
    ///
    /// # Errors
    /// A [`Fault`] says in words that a reader of the log understands why the participant cannot go on.
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault>;
}

/// A readable signal of `D` numbers, bound when the participant was built.
#[derive(Clone, Copy, Debug)]
pub struct In<const D: usize> {
    pub(crate) port: usize,
    pub(crate) offset: usize,
}

/// A writable signal of `D` numbers, bound when the participant was built.
#[derive(Clone, Copy, Debug)]
pub struct Out<const D: usize> {
    pub(crate) port: usize,
    pub(crate) offset: usize,
}

/// A signal whose length was known only when the participant was built.
#[derive(Clone, Copy, Debug)]
pub struct Slice {
    pub(crate) port: usize,
    pub(crate) offset: usize,
    /// Number of values.
    pub length: usize,
}

impl<const D: usize> In<D> {
    /// The signal at `offset` words in the sample of input number `port`.
    pub fn new(port: usize, offset: usize) -> Self {
        Self { port, offset }
    }
}

impl<const D: usize> Out<D> {
    /// The signal at `offset` words in the sample of output number `port`.
    pub fn new(port: usize, offset: usize) -> Self {
        Self { port, offset }
    }
}

impl Slice {
    /// The `length` words at `offset` in the sample of input or output number `port`.
    pub fn new(port: usize, offset: usize, length: usize) -> Self {
        Self { port, offset, length }
    }
}

/// Which channels the ports of a participant are.
#[derive(Clone, Debug, Default)]
pub struct Ports {
    /// Input ports in order of binding.
    pub inputs: Vec<(ChannelId, Timing)>,
    /// Output ports in order of binding.
    pub outputs: Vec<ChannelId>,
}

impl Ports {
    /// The ports of a node.
    pub fn of(node: &Node) -> Self {
        Self {
            inputs: node.inputs.iter().map(|input| (input.channel, input.timing)).collect(),
            outputs: node.outputs.clone(),
        }
    }
}

/// The inputs and outputs of a participant during one step.
#[derive(Debug)]
pub struct Io<'a> {
    store: &'a mut Store,
    ports: &'a Ports,
    step: u64,
}

impl<'a> Io<'a> {
    /// The view that a participant with these ports has of `store` at `step`.
    pub fn new(store: &'a mut Store, ports: &'a Ports, step: u64) -> Self {
        Self { store, ports, step }
    }

    /// Number of the step, from 0.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The value of an input. Until its writer has run, an input reads as the initial sample of its channel; so does a delayed
    /// one at step 0.
    pub fn get<const D: usize>(&self, signal: In<D>) -> [f64; D] {
        let mut value = [0.0; D];
        value.copy_from_slice(&self.input(signal.port)[signal.offset..signal.offset + D]);
        value
    }

    /// The values of an input of run-time length.
    pub fn slice(&self, signal: Slice) -> &[f64] {
        &self.input(signal.port)[signal.offset..signal.offset + signal.length]
    }

    /// Writes an output. Every number is to be written at every step; one that is not ends the run, and is named.
    pub fn set<const D: usize>(&mut self, signal: Out<D>, value: [f64; D]) {
        self.output(signal.port)[signal.offset..signal.offset + D].copy_from_slice(&value);
    }

    /// The place of an output of run-time length.
    pub fn slice_mut(&mut self, signal: Slice) -> &mut [f64] {
        &mut self.output(signal.port)[signal.offset..signal.offset + signal.length]
    }

    /// Where the values of an input are, for another language. Valid, as is that of [`Io::output_pointer`], until the step is
    /// done.
    pub fn input_pointer(&self, signal: Slice) -> *const f64 {
        let (channel, timing) = self.ports.inputs[signal.port];
        self.store.pointer(channel, self.step, timing, signal.offset, signal.length)
    }

    /// Where the values of an output belong, for another language.
    pub fn output_pointer(&mut self, signal: Slice) -> *mut f64 {
        self.store.pointer_mut(self.ports.outputs[signal.port], self.step, signal.offset, signal.length)
    }

    /// Says that the sample to which an output belongs is not new: a measurement that did not come, for which the last one
    /// stands. Its header says [`Status::Held`](crate::Status::Held) then, so that readers and the log can tell.
    pub fn mark_held<const D: usize>(&mut self, signal: Out<D>) {
        self.store.mark(self.ports.outputs[signal.port]);
    }

    /// [`Io::mark_held`] for an output of run-time length.
    pub fn mark_slice_held(&mut self, signal: Slice) {
        self.store.mark(self.ports.outputs[signal.port]);
    }

    #[inline]
    fn input(&self, port: usize) -> &[f64] {
        let (channel, timing) = self.ports.inputs[port];
        match timing {
            Timing::SameStep => self.store.read(channel, self.step),
            Timing::Delayed => self.store.read_before(channel, self.step),
        }
    }

    #[inline]
    fn output(&mut self, port: usize) -> &mut [f64] {
        self.store.write(self.ports.outputs[port], self.step)
    }
}
