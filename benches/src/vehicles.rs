//! The same robot as code and by equations.

use std::error::Error;

use crate::measure::step_of;

/// Steps of the integrator in a step of the run: nearly all time goes into the equations.
const SUBSTEPS: u64 = 100;

const CODE: &str = r#"
agents = [{ position = [0, 0, 0.3], m = 3, R = 0.25, I = 0.1 }]
vehicle = { kind = "omni", order = 2 }
controller.law = { u1 = "0.3", u2 = "-0.1", u3 = "0.2" }
"#;

const EQUATIONS: &str = r#"
agents = [{ theta = 0.3 }]
controller.law = { f1 = "0.3", f2 = "-0.1", f3 = "0.2" }

[vehicle]
kind = "equations"
inputs = { f1 = "N", f2 = "N", f3 = "N" }
parameters = { m = 3, R = 0.25, I = 0.1 }
position = ["x", "y"]
velocity = ["vx", "vy"]
d.x = "vx"
d.y = "vy"
d.theta = "omega"
d.vx = "(-sin(theta)*f1 - sin(pi/3 - theta)*f2 + sin(pi/3 + theta)*f3)/m"
d.vy = "(cos(theta)*f1 - cos(pi/3 - theta)*f2 - cos(pi/3 + theta)*f3)/m"
d.omega = "R/I*(f1 + f2 + f3)"

[vehicle.states]
x = { unit = "m", initial = 0 }
y = { unit = "m", initial = 0 }
theta = "rad"
vx = { unit = "m/s", initial = 0 }
vy = { unit = "m/s", initial = 0 }
omega = { unit = "rad/s", initial = 0 }
"#;

/// Seconds of a step of the integrator (classical Runge-Kutta), as code.
pub(crate) fn code(steps: u64) -> Result<f64, Box<dyn Error>> {
    measure(CODE, steps)
}

/// The same by equations.
pub(crate) fn equations(steps: u64) -> Result<f64, Box<dyn Error>> {
    measure(EQUATIONS, steps)
}

fn measure(vehicle: &str, steps: u64) -> Result<f64, Box<dyn Error>> {
    let steps = (steps / SUBSTEPS).max(10);
    let text = format!(
        "name = \"robot\"\ntiming = {{ dt = 0.1, duration = 10 }}\ntopology.b = 1\ncontroller.kind = \"formulas\"\n\
         plant = {{ kind = \"vehicles\", substeps = {SUBSTEPS} }}\nreference.position = [0, 0, 0]\n{vehicle}"
    );
    Ok(step_of("robot.toml", &text, steps)? / SUBSTEPS as f64)
}
