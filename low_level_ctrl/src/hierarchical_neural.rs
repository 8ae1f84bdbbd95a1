//! The low-level controllers of section 7.3: a robot of order 1 or 2 tracks its virtual agent, and a network that is tuned
//! by the tracking error cancels what disturbs it.

use formation::nalgebra::{SVector, Vector3, Vector6};
use formation::networks::{Leak, OutputLayer};
use formation::scenario::Context;
use formation::vehicle::Omni;
use formation::wiring::{Bind, BoundOutputs, Checks, Component, Outputs, Refusal};
use lockstep::{Fault, Field, In, Io, Participant, Step};
use schemars::JsonSchema;
use serde::Deserialize;

/// Gains, the same for both orders.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HierarchicalNeural {
    /// Gain of the tracking error (order 1) or of the sliding variable (order 2), 1/s.
    pub k: f64,
    /// λ, slope of the sliding surface, 1/s. Order 2 only.
    pub lam: f64,
    /// η1, learning rate; 0 switches the network off.
    pub eta1: f64,
    /// η2, leakage.
    pub eta2: f64,
}

/// The virtual agent that a robot tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualAgent {
    /// x̄, m and rad.
    pub position: Vector3<f64>,
    /// v̄.
    pub velocity: Vector3<f64>,
    /// ū.
    pub acceleration: Vector3<f64>,
}

/// What both orders have in common: the model, the network and what is published.
///
/// `P` is the number of regressors: the coordinates, and for order 2 also the velocities.
#[derive(Clone, Debug)]
pub struct NeuralTracking<const P: usize> {
    gains: HierarchicalNeural,
    vehicle: Omni,
    layer: OutputLayer<P, 3>,
    /// u, wheel speeds in m/s or wheel forces in N.
    pub input: Vector3<f64>,
    /// δx = x - x̄.
    pub error: Vector3<f64>,
    /// The error that tunes the network: δx (order 1) or s (order 2).
    pub sliding: Vector3<f64>,
    /// ŵ, the network's estimate of the disturbance.
    pub network: Vector3<f64>,
}

impl<const P: usize> NeuralTracking<P> {
    /// A controller for `vehicle` with zero weights.
    pub fn new(gains: HierarchicalNeural, vehicle: Omni) -> Self {
        let zero = Vector3::zeros();
        let layer = OutputLayer::default();
        Self { gains, vehicle, layer, input: zero, error: zero, sliding: zero, network: zero }
    }

    /// Frobenius norm of Ŵ.
    pub fn weight_norm(&self) -> f64 {
        self.layer.weights.norm()
    }

    /// Tunes the weights with the error of now, then asks them: `sliding` has to be set. (7.61), (7.65), (7.52)
    ///
    /// Using the weights before this update would be the explicit method, which rings as soon as the robots are far out.
    fn estimate(&mut self, step: &Step, regressor: &SVector<f64, P>) {
        let HierarchicalNeural { eta1, eta2, .. } = self.gains;
        if !step.is_first() {
            self.layer.learn(step.dt, eta1, regressor, &self.sliding, Leak::ByError(eta2));
        }
        self.network = self.layer.output(regressor);
    }

    /// The input that causes `rate` (velocity or acceleration, by order) at a heading in rad.
    fn allocate(&mut self, heading: f64, rate: &Vector3<f64>) {
        self.input = self.vehicle.inverse(heading) * rate;
    }
}

impl NeuralTracking<3> {
    /// Computes the wheel speeds of a robot of order 1.
    pub fn update(&mut self, step: &Step, position: &Vector3<f64>, reference: &VirtualAgent) {
        self.error = position - reference.position; // (7.59)
        self.sliding = self.error;
        self.estimate(step, position);
        let rate = -self.network + reference.velocity - self.gains.k * self.error;
        self.allocate(position[2], &rate); // (7.60)
    }
}

impl NeuralTracking<6> {
    /// Computes the wheel forces of a robot of order 2.
    pub fn update(&mut self, step: &Step, position: &Vector3<f64>, velocity: &Vector3<f64>, reference: &VirtualAgent) {
        let HierarchicalNeural { k, lam, .. } = self.gains;
        let rate_error = velocity - reference.velocity;
        self.error = position - reference.position;
        self.sliding = rate_error + lam * self.error; // (7.63)
        let regressor = Vector6::from_fn(|j, _| if j < 3 { position[j] } else { velocity[j - 3] });
        self.estimate(step, &regressor);
        let rate = -self.network + reference.acceleration - lam * rate_error - self.error - k * self.sliding;
        self.allocate(position[2], &rate); // (7.64)
    }
}

impl Component for HierarchicalNeural {
    fn check(&self, _: &Context) -> Checks {
        Checks::default()
            .positive("k", self.k)
            .positive("lam", self.lam)
            .not_negative("eta1", self.eta1)
            .not_negative("eta2", self.eta2)
    }

    fn outputs(&self, context: &Context, agent: usize) -> Vec<Field> {
        match context.agents[agent].vehicle.order() {
            1 => published::<3>(context, agent).fields(),
            _ => published::<6>(context, agent).fields(),
        }
    }

    fn build(&self, context: &Context, agents: &[usize], bind: &mut Bind) -> Result<Box<dyn Participant>, Refusal> {
        let agent = agents[0];
        let vehicle = context.agents[agent].nominal.omni().ok_or_else(|| {
            Refusal(
                "the controller `hierarchical_neural` drives planar robots with three coordinates; this vehicle is not one"
                    .into(),
            )
        })?;
        let inputs = Inputs::new(agent, bind)?;
        if vehicle.order() == 1 {
            let tracking = NeuralTracking::new(self.clone(), vehicle.clone());
            let outputs = published(context, agent).bind(agent, bind)?;
            return Ok(Box::new(FirstOrder { tracking, inputs, outputs }));
        }
        let tracking = NeuralTracking::new(self.clone(), vehicle.clone());
        let outputs = published(context, agent).bind(agent, bind)?;
        Ok(Box::new(SecondOrder { tracking, inputs, velocity: bind.state(agent, "velocity")?, outputs }))
    }
}

fn published<const P: usize>(context: &Context, agent: usize) -> Outputs<NeuralTracking<P>> {
    let vehicle = &context.agents[agent].vehicle;
    let [rate, sliding] = match vehicle.order() {
        1 => ["m/s, m/s, rad/s", "m, m, rad"],
        _ => ["m/s^2, m/s^2, rad/s^2", "m/s, m/s, rad/s"],
    };
    Outputs::new()
        .field(vehicle.input_field(), |tracking: &NeuralTracking<P>| tracking.input)
        .vector("error", "m, m, rad", |tracking| tracking.error)
        .vector("sliding", sliding, |tracking| tracking.sliding)
        .vector("network", rate, |tracking| tracking.network)
        .scalar("weight_norm", "", NeuralTracking::weight_norm)
}

/// The signals that do not depend on the order.
struct Inputs {
    position: In<3>,
    reference: [In<3>; 3],
}

impl Inputs {
    fn new(agent: usize, bind: &mut Bind) -> Result<Self, Refusal> {
        Ok(Self {
            position: bind.state(agent, "position")?,
            reference: [
                bind.reference(agent, "position")?,
                bind.reference(agent, "velocity")?,
                bind.reference(agent, "acceleration")?,
            ],
        })
    }

    fn reference(&self, io: &Io) -> VirtualAgent {
        let [position, velocity, acceleration] = self.reference.map(|signal| Vector3::from(io.get(signal)));
        VirtualAgent { position, velocity, acceleration }
    }
}

struct FirstOrder {
    tracking: NeuralTracking<3>,
    inputs: Inputs,
    outputs: BoundOutputs<NeuralTracking<3>>,
}

impl Participant for FirstOrder {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let position = io.get(self.inputs.position).into();
        self.tracking.update(step, &position, &self.inputs.reference(io));
        self.outputs.write(io, &self.tracking);
        Ok(())
    }
}

struct SecondOrder {
    tracking: NeuralTracking<6>,
    inputs: Inputs,
    velocity: In<3>,
    outputs: BoundOutputs<NeuralTracking<6>>,
}

impl Participant for SecondOrder {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let position = io.get(self.inputs.position).into();
        let velocity = io.get(self.velocity).into();
        self.tracking.update(step, &position, &velocity, &self.inputs.reference(io));
        self.outputs.write(io, &self.tracking);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use formation::vehicle::Drive;
    use proptest::prelude::*;

    const DT: f64 = 0.01;

    fn robot(drive: Drive) -> Omni {
        Omni { drive, radius: 0.25, mass: 3.2, inertia: 0.12, friction: 0.0 }
    }

    fn gains(eta1: f64) -> HierarchicalNeural {
        HierarchicalNeural { k: 2.0, lam: 2.0, eta1, eta2: 0.2 }
    }

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        (-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64).prop_map(|(x, y, z)| Vector3::new(x, y, z))
    }

    fn agent() -> impl Strategy<Value = VirtualAgent> {
        (vector(), vector(), vector()).prop_map(|(position, velocity, acceleration)| VirtualAgent {
            position,
            velocity,
            acceleration,
        })
    }

    proptest! {
        /// Without a network the error obeys dδx/dt = -k δx.
        #[test]
        fn order_1_closes_the_loop_as_designed(x in vector(), reference in agent()) {
            let mut tracking = NeuralTracking::<3>::new(gains(0.0), robot(Drive::Speed));
            tracking.update(&Step { index: 7, dt: DT }, &x, &reference);
            let caused = robot(Drive::Speed).matrix(x[2]) * tracking.input;
            let wanted = reference.velocity - 2.0 * (x - reference.position);
            prop_assert!((caused - wanted).norm() < 1e-11);
            prop_assert_eq!(tracking.network, Vector3::zeros());
        }

        /// Without a network the sliding variable obeys ds/dt = -k s - δx.
        #[test]
        fn order_2_closes_the_loop_as_designed(x in vector(), v in vector(), reference in agent()) {
            let mut tracking = NeuralTracking::<6>::new(gains(0.0), robot(Drive::Force));
            tracking.update(&Step { index: 7, dt: DT }, &x, &v, &reference);
            let caused = robot(Drive::Force).matrix(x[2]) * tracking.input;
            let (error, rate) = (x - reference.position, v - reference.velocity);
            let sliding_rate = caused - reference.acceleration + 2.0 * rate;
            prop_assert!((sliding_rate + 2.0 * (rate + 2.0 * error) + error).norm() < 1e-11);
        }
    }

    /// The weights move before they are used, and not at step 0.
    #[test]
    fn weights_see_the_error_of_now() {
        let reference =
            VirtualAgent { position: Vector3::zeros(), velocity: Vector3::zeros(), acceleration: Vector3::zeros() };
        let x = Vector3::new(1.0, 0.0, 0.0);
        let mut tracking = NeuralTracking::<3>::new(gains(15.0), robot(Drive::Speed));
        tracking.update(&Step { index: 0, dt: DT }, &x, &reference);
        assert_eq!(tracking.network, Vector3::zeros());
        tracking.update(&Step { index: 1, dt: DT }, &x, &reference);
        assert!((tracking.network - Vector3::new(0.15, 0.0, 0.0)).norm() < 1e-15);
        tracking.update(&Step { index: 2, dt: DT }, &x, &reference);
        assert!((tracking.network[0] - (0.15 + 0.15 - 0.01 * 0.2 * 0.15)).abs() < 1e-15);
    }
}
