//! Components of different schemes in one scenario: what fits by its signals works, what does not is refused with the reason.

use formation::scenario::Selection;
use formation::wiring::Assembly;
use golden::Bench;
use schemes::{ROLES, SCENARIOS};

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
    let selection = Selection { overrides: overrides.iter().flatten().cloned().collect(), ..Selection::default() };
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

/// Observers with the gains of their own scenarios, or some that suit many.
const FINITE_TIME: (&str, &str) = ("finite_time_disturbance", "alpha1=3 alpha2=6 alpha3=3 beta_w=10");
const DUAL: (&str, &str) =
    ("dual_disturbance", "alpha1=4 alpha2=8 alpha3=4 alpha4=6 alpha5=12 alpha6=6 beta_d=0.7 beta_w=5");
const FROM_POSITIONS: (&str, &str) =
    ("ofto", "beta1=2/3 alpha1=8 alpha2=8 alpha3=6 diff_alpha=[6,8,8,6] diff_beta=0.1");
const THREE_LAYER: (&str, &str) = ("three_layer_neural", "eta=[15,0.1,0.1,0.06] gamma=[12,12,18] beta=0.9 n_hidden=5");
const ADAPTIVE: (&str, &str) = ("adaptive", "eta5=64 eta6=0.5 ktilde=16");
const LINEAR_SURFACE: (&str, &str) = ("neural_linear_surface", "lt1=2 ct1=4 eta1=10 eta2=1 What0=0 published=input");
const TERMINAL_SURFACE: (&str, &str) =
    ("neural_terminal_surface", "lt1=1.5 lt2=0.5 p1=3 p2=5 h=1 ct1=3 ct2=3 eta1=10 eta2=1 What0=0 published=input");
const SLIDING: (&str, &str) = ("sliding_neural", "lam_obs=2 c_obs=4 k_obs=4 eta1=20 eta2=0.5");

/// All robots of `mixed` driven by forces.
fn second_order() -> Vec<String> {
    ["order=2", "m=[3, 3.1, 3.2, 3.5]", "I=[0.11, 0.12, 0.12, 0.15]"].map(String::from).into()
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
    let mut bench = bench("mixed", &[second_order(), component("observer", SLIDING.0, SLIDING.1)]);
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

/// Runs a scenario with another observer; what the agents are off their references then, and the observer off the disturbance.
fn swap(name: &str, agents: usize, observer: (&str, &str), time: f64) -> (f64, f64) {
    let mut bench = bench(name, &[component("observer", observer.0, observer.1)]);
    bench.run_to(time);
    let estimate = distance(&bench, agents, ("state", "disturbance"), ("estimate", "disturbance"));
    (distance(&bench, agents, STATE, REFERENCE), estimate)
}

/// Observers of chapters 2 to 7 under the controller of chapter 6. The one that knows positions only is the coarsest.
#[test]
fn observers_of_all_chapters_serve_the_compensated_controller() {
    for observer in [FINITE_TIME, DUAL, ADAPTIVE, LINEAR_SURFACE, SLIDING] {
        let (error, estimate) = swap("lp-regulation", 6, observer, 30.0);
        assert!(error < 1e-3 && estimate < 5e-3, "{}: {error}, {estimate}", observer.0);
    }
    let (error, estimate) = swap("lp-regulation", 6, FROM_POSITIONS, 30.0);
    assert!(error < 0.03 && estimate < 0.3, "{error}, {estimate}");
}

/// They also do on six coordinates: the thrust of a drone is known, its whole disturbance is not.
#[test]
fn observers_of_robots_serve_drones() {
    for observer in [TERMINAL_SURFACE, LINEAR_SURFACE, ADAPTIVE] {
        let (error, estimate) = swap("uav", 6, observer, 40.0);
        assert!(error < 2e-3 && estimate < 5e-3, "{}: {error}, {estimate}", observer.0);
    }
    // These two switch, which an attitude loop sees.
    for observer in [FINITE_TIME, DUAL] {
        let (error, estimate) = swap("uav", 6, observer, 40.0);
        assert!(error < 0.03 && estimate < 0.4, "{}: {error}, {estimate}", observer.0);
    }
}

#[test]
fn observers_of_wheel_speeds_change_places() {
    let (error, estimate) = swap("cida", 6, ADAPTIVE, 40.0);
    assert!(error < 1e-3 && estimate < 0.02, "{error}, {estimate}");
    let (error, estimate) = swap("compensated", 3, THREE_LAYER, 60.0);
    assert!(error < 0.3 && estimate < 0.3, "{error}, {estimate}");
}

/// An observer that also estimates a rate serves the controller that wants one, here with nothing mismatched to see.
#[test]
fn the_dual_observer_serves_dynamic_sliding_mode() {
    let (error, estimate) = swap("dsm-ftdo", 4, DUAL, 20.0);
    assert!(error < 5e-3 && estimate < 5e-3, "{error}, {estimate}");
}

/// Robots of five schemes under both layers of virtual agents, each with its own controller and observer.
#[test]
fn virtual_agents_lead_the_robots_of_other_chapters() {
    let schemes = [
        ("lp-regulation", 6, 1e-3),
        ("compensated", 3, 1e-2),
        ("cida", 6, 1e-2),
        ("rca", 5, 1e-2),
        ("limited-information", 6, 2e-2),
    ];
    let saturated = "UM=0.2 tau_e=0.5 psi_e=0.05 c_bar=1 lam_bar=2 k_bar=1.5 tau_u=0.19 psi_u=0.01";
    let layers = [("virtual_agents", "c_bar=2 lam_bar=2 feedforward=1"), ("saturated_virtual_agents", saturated)];
    for (name, agents, tolerance) in schemes {
        for (layer, parameters) in layers {
            let mut bench = bench(name, &[component("planner", layer, parameters)]);
            bench.run_to(40.0);
            let (error, total) = (distance(&bench, agents, STATE, REFERENCE), distance(&bench, agents, STATE, DESIRED));
            assert!(error < tolerance && total < tolerance, "{name} under {layer}: {error}, {total}");
        }
    }
}

#[test]
fn what_a_controller_needs_and_nobody_offers_is_named() {
    let message = refusal("dsm-ftdo", &[component("planner", "virtual_agents", "c_bar=2 lam_bar=2 feedforward=1")]);
    assert!(
        message.contains("`dynamic_sliding_observer` needs the signal `jerk` (3 values) from the planner of agent 1")
    );
    let message = refusal("dsm-ftdo", &[component("observer", SLIDING.0, SLIDING.1)]);
    assert!(
        message.contains("needs the signal `disturbance_rate` (3 values) from the observer of agent 1"),
        "{message}"
    );
    let message = refusal("rca", &[component("observer", FINITE_TIME.0, FINITE_TIME.1)]);
    assert!(message.contains("needs the signal `mismatched` (3 values) from the observer of agent 1"), "{message}");
    let message = refusal("limited-information", &[component("observer", ADAPTIVE.0, ADAPTIVE.1)]);
    assert!(message.contains("needs the signal `reference_velocity` (3 values) from the observer"), "{message}");
    let message = refusal("uav", &[vec!["observer.kind=none".into()]]);
    assert!(
        message.contains("needs the signal `disturbance` (6 values) from the observer of agent 1, but"),
        "{message}"
    );
}

/// Observers of three coordinates do not fly, and those of one order do not serve the other.
#[test]
fn observers_of_other_vehicles_are_refused() {
    let message = refusal("uav", &[component("observer", FROM_POSITIONS.0, FROM_POSITIONS.1)]);
    assert!(message.contains("`ofto` estimates the velocity of a planar robot"), "{message}");
    for name in ["uav", "lp-regulation"] {
        let message = refusal(name, &[component("observer", THREE_LAYER.0, THREE_LAYER.1)]);
        assert!(message.contains("this observer is made for vehicles of order 1 (wheel speeds)"), "{message}");
    }
    for observer in [FINITE_TIME, DUAL, TERMINAL_SURFACE] {
        let message = refusal("cida", &[component("observer", observer.0, observer.1)]);
        assert!(message.contains("needs the signal `velocity` (3 values) from the plant of agent 1"), "{message}");
    }
}

#[test]
fn an_observer_that_measures_velocities_is_refused_by_robots_without() {
    let message = refusal("mixed", &[component("observer", SLIDING.0, SLIDING.1)]);
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
