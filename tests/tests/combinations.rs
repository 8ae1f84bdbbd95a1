//! Components of different schemes in one scenario: what fits by its signals works, what does not is refused with the reason.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use orchestrator::catalog::{ROLES, SCENARIOS};
use tests::Bench;

/// The overrides that put a component with these parameters (`NAME=VALUE`, separated by spaces) into a section.
fn component(section: &str, kind: &str, parameters: &str) -> Vec<String> {
    let kind = format!("{section}.kind={kind}");
    std::iter::once(kind).chain(parameters.split_whitespace().map(|p| format!("{section}.{p}"))).collect()
}

/// A shipped scenario with other components.
fn bench(name: &str, overrides: &[Vec<String>]) -> Bench {
    let overrides: Vec<&str> = overrides.iter().flatten().map(String::as_str).collect();
    Bench::new(name, &overrides)
}

/// All problems of a shipped scenario with other components, as text.
fn refusal(name: &str, overrides: &[Vec<String>]) -> String {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == name).expect("a shipped scenario");
    let selection = Selection { variant: None, overrides: overrides.iter().flatten().cloned().collect() };
    match Assembly::load(shipped.file, shipped.text, &selection, &ROLES) {
        Ok(_) => panic!("{name} with {overrides:?} is not refused"),
        Err(problems) => problems.iter().map(|problem| problem.to_string()).collect::<Vec<_>>().join("\n"),
    }
}

/// Largest norm, over all agents, of the difference between two signals; of their first three values.
fn distance(bench: &Bench, agents: usize, a: (&str, &str), b: (&str, &str)) -> f64 {
    let signal =
        |agent: usize, (channel, field): (&str, &str)| bench.signal(&format!("/agent_{agent}/{channel}"), field);
    let of = |agent| {
        let squares = signal(agent, a).into_iter().zip(signal(agent, b)).take(3).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f64>().sqrt()
    };
    (1..=agents).map(of).fold(0.0, |largest, value| if value > largest || value.is_nan() { value } else { largest })
}

const STATE: (&str, &str) = ("state", "position");
const REFERENCE: (&str, &str) = ("reference", "position");
const DESIRED: (&str, &str) = ("reference", "desired_position");

/// All robots of `mixed` driven by forces.
fn second_order() -> Vec<String> {
    ["order=2", "m=[3, 3.1, 3.2, 3.5]", "I=[0.11, 0.12, 0.12, 0.15]"].map(String::from).into()
}

fn drone_observer() -> Vec<String> {
    component("observer", "sliding_neural", "lam_obs=2 c_obs=4 k_obs=4 eta1=20 eta2=0.5")
}

/// Without virtual agents every robot follows the reference itself.
#[test]
fn mixed_robots_track_the_plain_reference() {
    let mut bench = bench("mixed", &[component("planner", "reference", "")]);
    bench.run_to(40.0);
    let error = distance(&bench, 4, STATE, REFERENCE);
    assert!(error < 1e-2, "{error}");
}

/// The virtual agents of the drones lead robots: bounded, hence slower than those that belong to them.
#[test]
fn mixed_robots_follow_the_virtual_agents_of_the_drones() {
    let parameters = "UM=0.2 tau_e=0.5 psi_e=0.05 c_bar=1 lam_bar=2 k_bar=1.5 tau_u=0.19 psi_u=0.01";
    let mut bench = bench("mixed", &[component("planner", "saturated_virtual_agents", parameters)]);
    bench.run_to(3.0);
    assert!(distance(&bench, 4, DESIRED, REFERENCE) > 0.5, "bounded agents cannot be there after 3 s");
    bench.run_to(50.0);
    let (planned, error) = (distance(&bench, 4, DESIRED, REFERENCE), distance(&bench, 4, STATE, REFERENCE));
    assert!(planned < 1e-2 && error < 1e-2, "{planned}, {error}");
}

/// The virtual agents of the robots lead drones, if these start near their places: nothing bounds what is asked of them.
#[test]
fn drones_follow_the_virtual_agents_of_the_robots() {
    let planner = component("planner", "virtual_agents", "c_bar=0.5 lam_bar=0.5 feedforward=1");
    let places = "x0=[[3, 0, 0], [1.5, 2.6, 0], [-1.5, 2.6, 0], [-3, 0, 0], [-1.5, -2.6, 0], [1.5, -2.6, 0]]";
    let mut near = bench("uav", &[planner, vec![places.into()]]);
    near.run_to(40.0);
    let error = distance(&near, 6, STATE, DESIRED);
    assert!(error < 2e-3, "{error}");
}

/// The observer of the drones also estimates what disturbs a robot with three coordinates.
#[test]
fn the_observer_of_the_drones_serves_robots_of_order_2() {
    let mut bench = bench("mixed", &[second_order(), drone_observer()]);
    bench.run_to(30.0);
    let error = distance(&bench, 4, ("state", "disturbance"), ("estimate", "disturbance"));
    assert!(error < 2e-2, "{error}");
}

/// A controller that knows of no network, under virtual agents: nothing cancels the disturbance, which its gain holds against.
#[test]
fn virtual_agents_lead_robots_with_a_plain_controller() {
    let mut bench = bench("mixed", &[second_order(), component("controller", "consensus", "k_x=8 k_v=6")]);
    bench.run_to(30.0);
    let (planned, error) = (distance(&bench, 4, DESIRED, REFERENCE), distance(&bench, 4, STATE, REFERENCE));
    assert!(planned < 1e-4 && error < 0.5, "{planned}, {error}");
}

#[test]
fn an_observer_that_measures_velocities_is_refused_by_robots_without() {
    let message = refusal("mixed", &[drone_observer()]);
    let expected = "the observer `sliding_neural` needs the signal `velocity` (3 values) from the plant of agent 1, \
                    which offers only position (3), disturbance (3)";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn controllers_of_other_vehicles_are_refused() {
    let message = refusal("uav", &[component("controller", "hierarchical_neural", "k=2 lam=2 eta1=15 eta2=0.2")]);
    assert!(message.contains("`hierarchical_neural` drives planar robots with three coordinates"), "{message}");
    let parameters = "lam_p=2 c_p=2 k_p=2 lam_a=2 c_a=4 k_a=4 xi1_max=0.2 xi2_max=0.1 intro=none gamma1=4 gamma2=2 \
                      diff=slope n_diff=10";
    let message = refusal("mixed", &[component("controller", "hierarchical_uav", parameters)]);
    assert!(message.contains("`hierarchical_uav` flies quadcopters"), "{message}");
}
