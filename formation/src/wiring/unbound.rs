//! Outputs that a program in the place of a participant does not bind: they are zero at every step.

use std::sync::{Arc, Mutex, PoisonError};

use lockstep::{ChannelId, Fault, Io, Participant, Slice, Step};

use super::Signals;

/// The parts of outputs that are bound: port, offset and length of each. Its clones are one.
#[derive(Clone, Debug, Default)]
pub(super) struct Bound(Arc<Mutex<Vec<[usize; 3]>>>);

impl Bound {
    /// Adds one.
    pub(super) fn add(&self, part: [usize; 3]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(part);
    }

    /// The parts of these outputs that are not bound.
    pub(super) fn unbound(&self, signals: &Signals, outputs: &[ChannelId]) -> Vec<Slice> {
        let bound = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut unbound = Vec::new();
        for (port, &output) in outputs.iter().enumerate() {
            let mut offset = 0;
            for field in signals.layout(output).fields() {
                let length = field.shape.words();
                // A field is bound as a whole or not at all.
                if !bound.contains(&[port, offset, length]) {
                    unbound.push(Slice::new(port, offset, length));
                }
                offset += length;
            }
        }
        unbound
    }
}

/// A participant that does not know all of its outputs.
struct Partial {
    inner: Box<dyn Participant>,
    unbound: Vec<Slice>,
}

impl Participant for Partial {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        self.unbound.iter().for_each(|part| io.slice_mut(*part).fill(0.0));
        self.inner.step(step, io)
    }
}

/// The participant, with zeros in its `unbound` outputs.
pub(super) fn zeroed(inner: Box<dyn Participant>, unbound: Vec<Slice>) -> Box<dyn Participant> {
    if unbound.is_empty() { inner } else { Box::new(Partial { inner, unbound }) }
}

#[cfg(test)]
mod tests {
    use lockstep::{Channel, Field, Layout, Ports, Store};

    use super::*;
    use crate::wiring::Role;

    struct Nothing;

    impl Participant for Nothing {
        fn step(&mut self, _: &Step, _: &mut Io) -> Result<(), Fault> {
            Ok(())
        }
    }

    #[test]
    fn what_is_not_bound_is_zero_and_what_is_bound_is_left_to_the_participant() {
        let layout =
            Layout::new([Field::vector("input", 2, ""), Field::scalar("norm", ""), Field::scalar("level", "")]);
        let channel = Channel { topic: "/agent_1/command".into(), agent: 1, layout, initial: Vec::new() };
        let mut store = Store::new([&channel.layout]);
        let signals = Signals::new(vec![channel], vec![Some((Role::Controller, 0))]);
        let bound = Bound::default();
        bound.add([0, 0, 2]);
        bound.clone().add([0, 3, 1]);
        let ports = Ports { inputs: Vec::new(), outputs: vec![ChannelId(0)] };
        store.write(ChannelId(0), 0).fill(f64::NAN);
        let mut participant = zeroed(Box::new(Nothing), bound.unbound(&signals, &ports.outputs));
        participant.step(&Step { index: 0, dt: 1.0 }, &mut Io::new(&mut store, &ports, 0)).unwrap();
        let finite: Vec<bool> = store.read(ChannelId(0), 0).iter().map(|word| word.is_finite()).collect();
        assert_eq!(finite, [false, false, true, false]);
        assert_eq!(store.read(ChannelId(0), 0)[2], 0.0);
    }
}
