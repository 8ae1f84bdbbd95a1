//! Errors relative to the neighbours, bound to the signals that they are made of.

use formation::math::Topology;
use formation::nalgebra::Vector3;
use formation::scenario::Context;
use formation::wiring::{Bind, Refusal};
use lockstep::{In, Io};

/// The tracking error `δ = state - reference` of an agent and of its in-neighbours, for one pair of signals.
#[derive(Clone, Debug)]
pub struct LocalError {
    agent: usize,
    topology: Topology,
    own: (In<3>, In<3>),
    others: Vec<(In<3>, In<3>)>,
}

impl LocalError {
    /// Binds the signal called `name` (`position` or `velocity`) of plant and planner, of `agent` and its in-neighbours.
    ///
    /// # Errors
    /// [`Refusal`] if one of them does not offer it.
    pub fn new(context: &Context, agent: usize, bind: &mut Bind, name: &str) -> Result<Self, Refusal> {
        let mut pair = |agent| Ok((bind.state::<3>(agent, name)?, bind.reference::<3>(agent, name)?));
        let own = pair(agent)?;
        let others = context.topology.neighbours(agent).iter().map(|&other| pair(other)).collect::<Result<_, _>>()?;
        Ok(Self { agent, topology: context.topology.clone(), own, others })
    }

    /// The same for an agent that knows nothing of the others: its local error is its own.
    ///
    /// # Errors
    /// See [`LocalError::new`].
    pub fn alone(agent: usize, bind: &mut Bind, name: &str) -> Result<Self, Refusal> {
        let topology = Topology::new(&[vec![0.0]], vec![1.0]).map_err(Refusal)?;
        let own = (bind.state::<3>(agent, name)?, bind.reference::<3>(agent, name)?);
        Ok(Self { agent: 0, topology, own, others: Vec::new() })
    }

    /// δ of the agent itself.
    pub fn own(&self, io: &Io) -> Vector3<f64> {
        difference(io, self.own)
    }

    /// `e_i = Σ_j a_ij (δ_i - δ_j) + b_i δ_i`.
    pub fn local(&self, io: &Io) -> Vector3<f64> {
        let others = self.others.iter().map(|pair| difference(io, *pair));
        self.topology.local_error(self.agent, &self.own(io), others)
    }
}

fn difference(io: &Io, (state, reference): (In<3>, In<3>)) -> Vector3<f64> {
    Vector3::from(io.get(state)) - Vector3::from(io.get(reference))
}
