//! Errors relative to the neighbours, bound to the signals that they are made of.

use formation::math::{NeighbourhoodSchedule, wrap};
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, Refusal};
use lockstep::{In, Io};

/// The tracking error `δ = state - reference` of an agent and of its in-neighbours, for one pair of signals; or an estimate of
/// theirs, which is treated alike.
#[derive(Clone, Debug)]
pub struct LocalError {
    graph: NeighbourhoodSchedule,
    own: Deviation,
    others: Vec<Deviation>,
    /// Which coordinates are angles, whose differences are taken on the circle.
    angles: [bool; 3],
}

/// What one agent contributes.
#[derive(Clone, Copy, Debug)]
struct Deviation {
    value: In<3>,
    reference: Option<In<3>>,
}

impl LocalError {
    /// Binds the signal called `name` (`position` or `velocity`) of plant and planner, of `agent` and its in-neighbours.
    ///
    /// # Errors
    /// [`Refusal`] if one of them does not offer it.
    pub fn new(context: &Context, agent: usize, bind: &mut Bind, name: &str) -> Result<Self, Refusal> {
        let error = Self::bound(context, agent, |agent| {
            Ok(Deviation { value: bind.state(agent, name)?, reference: Some(bind.reference(agent, name)?) })
        })?;
        let declared = &context.agents[agent].angles;
        let is_angle = |coordinate: usize| name == "position" && declared.get(coordinate) == Some(&true);
        Ok(Self { angles: std::array::from_fn(is_angle), ..error })
    }

    /// Binds the estimate called `name` of `agent` and its in-neighbours, in the place of δ.
    ///
    /// # Errors
    /// [`Refusal`] if one of their observers does not offer it.
    pub fn of_estimates(context: &Context, agent: usize, bind: &mut Bind, name: &str) -> Result<Self, Refusal> {
        Self::bound(context, agent, |agent| Ok(Deviation { value: bind.estimate(agent, name)?, reference: None }))
    }

    fn bound(
        context: &Context,
        agent: usize,
        mut deviation: impl FnMut(usize) -> Result<Deviation, Refusal>,
    ) -> Result<Self, Refusal> {
        let own = deviation(agent)?;
        let graph = context.topology.neighbourhood(agent);
        let others = graph.heard().iter().map(|&other| deviation(other)).collect::<Result<_, _>>()?;
        Ok(Self { graph, own, others, angles: [false; 3] })
    }

    /// The same for an agent that knows nothing of the others: its local error is its own.
    ///
    /// # Errors
    /// See [`LocalError::new`].
    pub fn alone(agent: usize, bind: &mut Bind, name: &str) -> Result<Self, Refusal> {
        let own = Deviation { value: bind.state(agent, name)?, reference: Some(bind.reference(agent, name)?) };
        Ok(Self { graph: NeighbourhoodSchedule::alone(1.0), own, others: Vec::new(), angles: [false; 3] })
    }

    /// δ of the agent itself.
    pub fn own(&self, io: &Io) -> Vector3<f64> {
        self.on_the_circle(self.own.read(io))
    }

    /// `e_i = Σ_j a_ij (δ_i - δ_j) + b_i δ_i` with the graph of this step, the differences of angles on the circle.
    pub fn local(&self, io: &Io) -> Vector3<f64> {
        let own = self.own(io);
        self.graph.local_error(io.step(), &own, |place| {
            let other = self.others[place].read(io);
            // The same where nothing is an angle, down to the bits.
            if self.angles == [false; 3] { other } else { own - self.on_the_circle(own - other) }
        })
    }

    fn on_the_circle(&self, mut difference: Vector3<f64>) -> Vector3<f64> {
        for (value, is_angle) in difference.iter_mut().zip(self.angles) {
            if is_angle {
                *value = wrap(*value);
            }
        }
        difference
    }
}

impl Deviation {
    fn read(&self, io: &Io) -> Vector3<f64> {
        let value = Vector3::from(io.get(self.value));
        self.reference.map_or(value, |reference| value - Vector3::from(io.get(reference)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lockstep::{Channel, ChannelId, Field, Input, Layout, Network, Node, Ports, Store, Timing};

    /// Gives `check` the samples of state and reference of agent 0, then of agent 1.
    fn with_samples(values: [[f64; 3]; 4], check: impl FnOnce(&Io)) {
        let layout = Layout::new([Field::vector("position", 3, "m")]);
        let channels = (0..4).map(|_| Channel { layout: layout.clone(), ..Channel::default() }).collect();
        let inputs = (0..4).map(|channel| Input { channel: ChannelId(channel), timing: Timing::SameStep }).collect();
        let node = Node { name: "controller".into(), inputs, outputs: vec![], every: 1, offset: 0 };
        let network = Network { channels, nodes: vec![node] };
        let mut store = Store::of(&network);
        for (channel, value) in values.iter().enumerate() {
            store.write(ChannelId(channel), 0).copy_from_slice(value);
        }
        let ports = Ports::of(&network.nodes[0]);
        check(&Io::new(&mut store, &ports, 0));
    }

    /// The error of agent 0, which hears agent 1 with the weight 2 and the reference with 0.5.
    fn error(angles: [bool; 3]) -> LocalError {
        let deviation = |first| Deviation { value: In::new(first, 0), reference: Some(In::new(first + 1, 0)) };
        let weights = [vec![0.0, 2.0], vec![0.0, 0.0]];
        let topology = formation::math::Topology::new(&weights, vec![0.5, 0.0]).unwrap();
        let graph = formation::math::TopologySchedule::from(topology).neighbourhood(0);
        LocalError { graph, own: deviation(0), others: vec![deviation(2)], angles }
    }

    #[test]
    fn tracking_errors_of_agent_and_neighbours_are_weighted_as_the_graph_says() {
        with_samples([[5.0, 1.0, 0.0], [2.0, 1.0, 0.5], [0.0, 7.0, 0.0], [1.0, 4.0, 0.0]], |io| {
            let error = error([false; 3]);
            // δ0 = (3, 0, -0.5), δ1 = (-1, 3, 0).
            assert_eq!(error.own(io), Vector3::new(3.0, 0.0, -0.5));
            assert_eq!(error.local(io), Vector3::new(2.0 * 4.0 + 0.5 * 3.0, 2.0 * -3.0, 2.0 * -0.5 + 0.5 * -0.5));
            // Estimates are errors already.
            let estimate = Deviation { value: In::new(0, 0), reference: None };
            assert_eq!(estimate.read(io), Vector3::new(5.0, 1.0, 0.0));
        });
    }

    #[test]
    fn differences_of_angles_are_taken_on_the_circle() {
        use std::f64::consts::TAU;
        // δ0 = 3 + 2 pi and δ1 = -3: both near half a turn, on either side of it.
        with_samples([[0.0, 0.0, TAU], [0.0, 0.0, -3.0], [0.0, 0.0, -3.0], [0.0; 3]], |io| {
            let error = error([false, false, true]);
            assert!((error.own(io)[2] - 3.0).abs() < 1e-14);
            assert!((error.local(io)[2] - (2.0 * (6.0 - TAU) + 0.5 * 3.0)).abs() < 1e-14);
        });
    }
}
