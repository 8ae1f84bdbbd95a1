//! The controller of the scenario `uav` as a program of its own: position loop, guidance law, attitude loop (section 7.2).
//!
//!     cargo build --release -p phalanx --example controller-rust
//!     phalanx run uav --swap controller.3=target/release/examples/controller-rust
//!
//! The log is, byte for byte, that of the built-in controller `hierarchical_uav`, of which this is the variant `TSC`.

use formation::wiring::{Refusal, Role, participant};
use lockstep::{Fault, In, Io, Out, Participant, Step};
use processes::serve;

type Vector = [f64; 3];

const GRAVITY: f64 = 9.81;

/// A slope over `hold` steps, held that long and limited. Algorithm 4, corrected.
struct HeldSlope {
    hold: u64,
    limit: f64,
    /// Steps (after the first) without a slope yet.
    delay: u64,
    before: Vector,
    slope: Vector,
    taken: u64,
}

impl HeldSlope {
    fn new(hold: u64, limit: f64, delay: u64) -> Self {
        Self { hold, limit, delay, before: [0.0; 3], slope: [0.0; 3], taken: 0 }
    }

    fn update(&mut self, step: &Step, input: Vector) -> Vector {
        if step.index <= self.delay {
            (self.slope, self.before) = ([0.0; 3], input);
        } else if step.index >= self.taken * self.hold {
            let held = self.hold as f64 * step.dt;
            self.slope = std::array::from_fn(|j| (input[j] - self.before[j]) / held);
            self.before = input;
            self.taken += 1;
        }
        self.slope.map(|slope| slope.clamp(-self.limit, self.limit))
    }
}

struct Controller {
    mass: f64,
    /// Angular acceleration per unit of torque input.
    effect: Vector,
    lam_p: f64,
    c_p: f64,
    k_p: f64,
    lam_a: f64,
    c_a: f64,
    k_a: f64,
    gamma1: f64,
    gamma2: f64,
    yaw: f64,
    first: HeldSlope,
    second: HeldSlope,
    coordinates: In<6>,
    velocities: In<6>,
    reference: [In<3>; 3],
    disturbance: In<6>,
    input: Out<4>,
    /// Attitude reference, its two derivatives, and the two sliding variables.
    others: [Out<3>; 5],
}

impl Participant for Controller {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let (x, v) = (io.get(self.coordinates), io.get(self.velocities));
        let [position, velocity, acceleration] = self.reference.map(|signal| io.get(signal));
        let introduction = 1.0 / (1.0 + libm::exp(-self.gamma1 * (step.time() - self.gamma2)));
        let disturbance = io.get(self.disturbance).map(|value| introduction * value);

        // Position loop: the acceleration to ask for. (7.41)
        let mut push = [0.0; 3];
        let mut sliding_position = [0.0; 3];
        for j in 0..3 {
            let (error, rate) = (x[j] - position[j], v[j] - velocity[j]);
            sliding_position[j] = rate + self.lam_p * error;
            push[j] = acceleration[j]
                - disturbance[j]
                - self.lam_p * rate
                - self.k_p * error
                - self.c_p * sliding_position[j];
        }
        push[2] += GRAVITY;

        // Guidance: roll and pitch that point the thrust along it. (7.31)
        let (sin_yaw, cos_yaw) = (libm::sin(self.yaw), libm::cos(self.yaw));
        let length = (push[0] * push[0] + push[1] * push[1] + push[2] * push[2]).sqrt();
        let roll = libm::asin((push[0] * sin_yaw - push[1] * cos_yaw) / length);
        let pitch = libm::atan((push[0] * cos_yaw + push[1] * sin_yaw) / push[2]);
        let attitude = [roll, pitch, self.yaw];
        let xi1 = self.first.update(step, attitude);
        let xi2 = self.second.update(step, xi1);

        // Attitude loop: the angular acceleration to ask for. (7.42)
        let mut turn = [0.0; 3];
        let mut sliding_attitude = [0.0; 3];
        for j in 0..3 {
            let (error, rate) = (x[3 + j] - attitude[j], v[3 + j] - xi1[j]);
            sliding_attitude[j] = rate + self.lam_a * error;
            turn[j] =
                xi2[j] - disturbance[3 + j] - self.lam_a * rate - self.k_a * error - self.c_a * sliding_attitude[j];
        }

        let thrust = self.mass * push[2] / (libm::cos(x[3]) * libm::cos(x[4])); // (7.43)
        let torque = |j: usize| turn[j] / self.effect[j];
        io.set(self.input, [thrust, torque(0), torque(1), torque(2)]);
        let values = [attitude, xi1, xi2, sliding_position, sliding_attitude];
        self.others.into_iter().zip(values).for_each(|(signal, value)| io.set(signal, value));
        Ok(())
    }
}

fn main() -> std::process::ExitCode {
    serve(participant(Role::Controller, |me| {
        let gain = |name: &str| me.number(&format!("controller.{name}"));
        let vehicle = me.context().agents[me.agent()?.index()].nominal.quadcopter();
        let vehicle = vehicle.ok_or_else(|| Refusal("this controller flies quadcopters".into()))?;
        let hold = gain("n_diff")? as u64;
        Ok(Controller {
            mass: vehicle.mass,
            effect: vehicle.torque_effect(),
            lam_p: gain("lam_p")?,
            c_p: gain("c_p")?,
            k_p: gain("k_p")?,
            lam_a: gain("lam_a")?,
            c_a: gain("c_a")?,
            k_a: gain("k_a")?,
            gamma1: gain("gamma1")?,
            gamma2: gain("gamma2")?,
            yaw: gain("psi_d")?,
            first: HeldSlope::new(hold, gain("xi1_max")?, 1),
            second: HeldSlope::new(hold, gain("xi2_max")?, 2),
            coordinates: me.state("position")?,
            velocities: me.state("velocity")?,
            reference: [me.reference("position")?, me.reference("velocity")?, me.reference("acceleration")?],
            disturbance: me.estimate("disturbance")?,
            input: me.out("input")?,
            others: [
                me.out("attitude_reference")?,
                me.out("xi1")?,
                me.out("xi2")?,
                me.out("sliding_position")?,
                me.out("sliding_attitude")?,
            ],
        })
    }))
}
