//! What a sample costs that goes over a link.

use std::error::Error;

use crate::measure::step_of;

/// Robots that all hear each other.
const AGENTS: usize = 12;

const LINKS: &str = "[links]\ncarries = [\"state\"]\ndelay = 0.05\nloss = 0.1\n";

/// Seconds of a sample over a link with delay and loss: what a step takes longer with links, for each of them.
pub(crate) fn sample(steps: u64) -> Result<f64, Box<dyn Error>> {
    let links = (AGENTS * (AGENTS - 1)) as f64;
    Ok((measure(LINKS, steps)? - measure("", steps)?) / links)
}

fn measure(links: &str, steps: u64) -> Result<f64, Box<dyn Error>> {
    let row = |agent: usize| format!("{{ position = [{agent}, 0, 0] }}");
    let agents = (0..AGENTS).map(row).collect::<Vec<_>>().join(", ");
    let text = format!(
        "name = \"links\"\nagents = [{agents}]\ntiming = {{ dt = 0.01, duration = 10 }}\ntopology = {{ graph = \"complete\", b = 1 }}\n\
         vehicle.kind = \"integrator\"\nreference.position = [\"sin(t)\", \"i\", 0]\n\
         controller = {{ kind = \"consensus\", k_x = 1, k_v = 1 }}\n{links}"
    );
    step_of("links.toml", &text, steps)
}
