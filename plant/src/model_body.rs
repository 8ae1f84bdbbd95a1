//! A vehicle by equations: integrates its formulas under held inputs, and publishes what they say.

use std::sync::Arc;

use formation::math::{Integrator, Method};
use formation::vehicle::{Model, evaluate};
use formation::wiring::{Bind, BoundOutputs, Outputs, Refusal, Role};
use lockstep::{Io, Slice, Timing};

/// One vehicle, its state and its ports.
pub(crate) struct ModelBody {
    motion: ModelMotion,
    integrator: Integrator,
    /// The input; `None` if there is no controller, or the vehicle has no inputs.
    command: Option<Slice>,
    outputs: BoundOutputs<ModelMotion>,
}

/// A vehicle and its state.
pub(crate) struct ModelMotion {
    model: Arc<Model>,
    states: Vec<f64>,
    /// See [`Model`].
    slots: Vec<f64>,
}

impl ModelBody {
    pub(crate) fn new(agent: usize, model: &Arc<Model>, method: Method, bind: &mut Bind) -> Result<Self, Refusal> {
        let inputs = model.inputs.len();
        let command = match inputs {
            0 => None,
            _ => Some(bind.slice(Role::Controller, agent, "input", inputs, Timing::Delayed)?),
        };
        Ok(Self {
            motion: ModelMotion { model: Arc::clone(model), states: model.initial.clone(), slots: model.start() },
            integrator: Integrator::new(method, model.states.len(), &model.leading),
            command,
            outputs: outputs(model).bind(agent, bind)?,
        })
    }

    /// Advances from `time` by `dt` with the command of the step before held.
    pub(crate) fn advance(&mut self, time: f64, dt: f64, substeps: u32, io: &Io) {
        let Self { motion: ModelMotion { model, states, slots }, integrator, command, .. } = self;
        if let Some(command) = command {
            for ((input, (low, high)), command) in
                model.inputs_mut(slots).iter_mut().zip(&model.limits).zip(io.slice(*command))
            {
                // Unlike `clamp`, this keeps what is not a number, so that it is seen.
                *input = if command < low {
                    *low
                } else if command > high {
                    *high
                } else {
                    *command
                };
            }
        }
        let length = dt / f64::from(substeps);
        for substep in 0..substeps {
            integrator.step(time + f64::from(substep) * length, length, states, |t, x, out| {
                model.set(slots, t, x);
                model.slope(slots, out);
            });
        }
    }

    pub(crate) fn publish(&mut self, time: f64, io: &mut Io) {
        let ModelMotion { model, states, slots } = &mut self.motion;
        model.set(slots, time, states);
        self.outputs.write(io, &self.motion);
    }
}

/// The signals of a model, with their values.
pub(crate) fn outputs(model: &Arc<Model>) -> Outputs<ModelMotion> {
    let mut outputs = Outputs::new();
    for field in model.fields() {
        let source = source(model, &field.name);
        outputs = outputs.any(field, move |motion: &ModelMotion, place| match source {
            Source::State(state) => place[0] = motion.states[state],
            Source::Position => evaluate(&motion.model.position, &motion.slots, place),
            Source::Velocity => evaluate(&motion.model.velocity, &motion.slots, place),
            Source::Output(output) => evaluate(&motion.model.outputs[output].formulas, &motion.slots, place),
        });
    }
    outputs
}

/// Where the value of a signal comes from.
#[derive(Clone, Copy)]
enum Source {
    Position,
    Velocity,
    State(usize),
    Output(usize),
}

fn source(model: &Model, name: &str) -> Source {
    let state = model.states.iter().position(|state| state.name == name);
    let output = model.outputs.iter().position(|output| output.field.name == name);
    match (name, state, output) {
        ("position", ..) => Source::Position,
        ("velocity", ..) => Source::Velocity,
        (_, Some(state), _) => Source::State(state),
        (_, None, output) => Source::Output(output.unwrap_or_default()),
    }
}
