//! The actuators of one vehicle: clip its inputs, and add hysteresis where the scenario asks for it.

use formation::math::{BoucWen, clip};
use formation::scenario::Context;
use formation::vehicle::MAX_INPUTS;

/// Turns commands into inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuators {
    limit: Option<f64>,
    hysteresis: Option<BoucWen>,
    /// The command in force, clipped.
    command: [f64; MAX_INPUTS],
    /// ζ, zero for ideal actuators.
    pub memory: [f64; MAX_INPUTS],
    /// h, the input of the vehicle.
    pub output: [f64; MAX_INPUTS],
}

impl Actuators {
    /// Actuators at rest.
    pub fn new(context: &Context) -> Self {
        let hysteresis = context.actuator.filter(|actuator| actuator.hysteresis).map(|actuator| actuator.bouc_wen);
        Self::of(context.input_limit, hysteresis)
    }

    fn of(limit: Option<f64>, hysteresis: Option<BoucWen>) -> Self {
        let zeros = [0.0; MAX_INPUTS];
        Self { limit, hysteresis, command: zeros, memory: zeros, output: zeros }
    }

    /// Takes in the command that is held from now on. With hysteresis, the jump from the one before moves the memory.
    pub fn apply(&mut self, command: &[f64]) {
        for (j, command) in command.iter().enumerate() {
            let command = self.limit.map_or(*command, |limit| clip(*command, limit));
            if let Some(model) = &self.hysteresis {
                self.memory[j] = model.forward(self.memory[j], command - self.command[j]); // (2.3)
                self.output[j] = model.output(command, self.memory[j]); // (2.2)
            } else {
                self.output[j] = command;
            }
            self.command[j] = command;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: BoucWen =
        BoucWen { direct: 1.5, hysteretic: 3.0, width: 1.0, slant: 0.5, smoothness: 2.0, substep: 0.01 };

    #[test]
    fn ideal_actuators_only_clip() {
        let mut actuators = Actuators::of(Some(2.0), None);
        actuators.apply(&[1.0, -3.0]);
        assert_eq!(actuators.output, [1.0, -2.0, 0.0, 0.0]);
        assert_eq!(actuators.memory, [0.0; MAX_INPUTS]);
    }

    #[test]
    fn the_memory_moves_with_jumps_only_and_differs_on_the_way_back() {
        let mut actuators = Actuators::of(None, Some(MODEL));
        actuators.apply(&[0.5]);
        let up = actuators.clone();
        assert_eq!(up.memory[0], MODEL.forward(0.0, 0.5));
        actuators.apply(&[0.5]);
        assert_eq!(actuators, up);
        actuators.apply(&[1.0]);
        actuators.apply(&[0.5]);
        assert!(actuators.output[0] < up.output[0] - 0.1);
    }

    #[test]
    fn clipped_parts_of_a_jump_do_not_move_the_memory() {
        let mut limited = Actuators::of(Some(0.3), Some(MODEL));
        limited.apply(&[5.0]);
        assert_eq!(limited.memory[0], MODEL.forward(0.0, 0.3));
    }
}
