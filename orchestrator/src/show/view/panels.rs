//! Which plots a run has, by the signals that are there.

use lockstep::{Field, Shape};

use super::events::{flags, is_flag, switching};
use super::logged_run::unit_of;
use super::panel::{Curve, Kind, Limit, Panel, View};
use super::space::{clearances, distances};
use super::{Grid, LoggedRun};
use crate::judge::metrics::{norm, norm_between};
use crate::show::traffic::Traffic;

/// All plots of a run, the ones that matter most first.
pub fn panels(run: &LoggedRun, grid: &Grid) -> Vec<Panel> {
    let builder = PanelBuilder { run, grid };
    let made = [
        builder.errors(),
        distances(run, grid),
        clearances(run, grid),
        builder.inputs(),
        builder.estimates(),
        builder.sliding(),
        builder.weights(),
        flags(run, grid),
        switching(run, grid),
        builder.links(),
        builder.rest(),
    ];
    made.into_iter().flatten().filter(|panel| !panel.views.is_empty()).collect()
}

/// The input before it is limited, as controllers call it.
const DEMANDED: [&str; 2] = ["ucom", "demanded"];

/// Words of a field's name, for people.
fn words(name: &str) -> String {
    name.replace('_', " ")
}

fn is_sliding(name: &str) -> bool {
    name.split('_').any(|word| word == "sliding")
}

fn is_error(name: &str) -> bool {
    name.split('_').next_back() == Some("error")
}

fn is_weight(name: &str) -> bool {
    name.ends_with("weight_norm") || name.ends_with("weights_norm")
}

/// The units of a vector, each once: `m, rad`.
fn units(field: &Field) -> String {
    let mut units: Vec<&str> = Vec::new();
    for unit in field.unit.split(',').map(str::trim) {
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    units.join(", ")
}

struct PanelBuilder<'a> {
    run: &'a LoggedRun,
    grid: &'a Grid,
}

impl PanelBuilder<'_> {
    /// A curve for every agent for which `make` gives one.
    fn each(&self, mut make: impl FnMut(usize) -> Option<Vec<f64>>) -> Vec<Curve> {
        let curve = |(agent, values)| Curve { label: String::new(), agent: Some(agent), second: false, values };
        (0..self.run.agents.len()).filter_map(|place| Some((place, make(place)?))).map(curve).collect()
    }

    /// The norm of the difference of two signals over the coordinates that both have.
    fn between(&self, place: usize, [a, b]: [(&str, &str); 2]) -> Option<Vec<f64>> {
        let [a, b] = [self.run.signal(place, a.0, a.1)?, self.run.signal(place, b.0, b.1)?];
        Some(self.grid.curve(|sample| norm_between(a.row(sample), b.row(sample))))
    }

    /// The norm of a vector, or a scalar as it is.
    fn norm(&self, place: usize, role: &str, field: &str) -> Option<Vec<f64>> {
        let series = self.run.signal(place, role, field)?;
        Some(match series.width() {
            1 => self.grid.curve(|sample| series.row(sample)[0]),
            _ => self.grid.curve(|sample| norm(series.row(sample))),
        })
    }

    fn norm_view(&self, role: &str, field: &Field) -> View {
        let vector = field.shape != Shape::Scalar;
        View {
            name: format!("{role} {}", words(&field.name)),
            axis: if vector { "norm".into() } else { words(&field.name) },
            unit: self.units(field),
            logarithmic: vector,
            curves: self.each(|place| self.norm(place, role, &field.name)),
            limits: Vec::new(),
        }
    }

    /// One view for every field that `take` wants.
    fn norm_views(&self, take: impl Fn(&str, &Field) -> bool) -> Vec<View> {
        let roles = self.run.roles();
        // The controller's variables say most about a scheme.
        let ordered = roles.iter().rev();
        ordered
            .flat_map(|role| self.run.fields(role).into_iter().map(move |field| (role, field)))
            .filter(|(role, field)| take(role, field))
            .map(|(role, field)| self.norm_view(role, &field))
            .collect()
    }

    fn errors(&self) -> Option<Panel> {
        let unit = self.run.field("state", "position").map(|field| units(&field)).unwrap_or_default();
        let spatial = !self.run.is_planar();
        let view = |name: &str, pair: [(&str, &str); 2]| View {
            name: name.into(),
            axis: "error norm".into(),
            // A reference in space has no angles.
            unit: if spatial { "m".into() } else { unit.clone() },
            logarithmic: true,
            curves: self.each(|place| self.between(place, pair)),
            limits: Vec::new(),
        };
        let (state, tracked) = (("state", "position"), ("reference", "position"));
        let desired = ("reference", "desired_position");
        let mut views = match self.run.field(desired.0, desired.1) {
            Some(_) => vec![
                view("agent to its place in the formation", [state, desired]),
                view("agent to what it tracks", [state, tracked]),
                view("what it tracks to its place", [tracked, desired]),
            ],
            None => vec![view("agent to its place in the formation", [state, tracked])],
        };
        views.extend(self.norm_views(|role, field| role != "state" && is_error(&field.name)));
        views.retain(|view| !view.curves.is_empty());
        Some(Panel { id: "tracking-errors", title: "Tracking errors", kind: Kind::Lines, views })
    }

    /// Age and losses of what each link delivers.
    fn links(&self) -> Option<Panel> {
        let view = |name: &str, field: &str, unit: &str| {
            let curve = |link: &Traffic| {
                let series = self.run.log.signal(&link.asked.topic, field)?;
                let ([from, to], signal) = (link.asked.agents, link.asked.topic.rsplit('/').next()?);
                let label = format!("{from} → {to} {signal}");
                let values = self.grid.curve(|sample| series.row(sample)[0]);
                Some(Curve { label, agent: Some(to - 1), second: false, values })
            };
            let curves = self.run.traffic.iter().filter_map(curve).collect();
            View { name: name.into(), axis: name.into(), unit: unit.into(), curves, ..View::default() }
        };
        let views = vec![
            view("age", "link_age", "s"),
            view("messages sent", "link_sent", ""),
            view("messages lost", "link_lost", ""),
        ];
        let views = views.into_iter().filter(|view| !view.curves.is_empty()).collect();
        Some(Panel { id: "links", title: "Links", kind: Kind::Lines, views })
    }

    fn sliding(&self) -> Option<Panel> {
        let views = self.norm_views(|_, field| is_sliding(&field.name));
        Some(Panel { id: "sliding-variables", title: "Sliding variables", kind: Kind::Lines, views })
    }

    fn weights(&self) -> Option<Panel> {
        let views = self.norm_views(|_, field| is_weight(&field.name));
        Some(Panel { id: "network-weights", title: "Network weights", kind: Kind::Lines, views })
    }

    fn inputs(&self) -> Option<Panel> {
        let field = self.run.field("command", "input")?;
        let context = self.run.scenario.as_ref().map(|scenario| &scenario.context);
        let limit = context.and_then(|context| context.input_limit);
        let limits: Vec<Limit> = limit
            .into_iter()
            .flat_map(|limit| [("limit", limit), ("-limit", -limit)])
            .map(|(label, value)| Limit { label: label.into(), value })
            .collect();
        let quadcopters =
            context.is_some_and(|context| context.agents.iter().all(|a| a.vehicle.quadcopter().is_some()));
        let views = (0..field.shape.words()).map(|component| View {
            name: self.named_input(component).unwrap_or_else(|| input_name(quadcopters, component)),
            axis: "input".into(),
            unit: unit_of(&field, component),
            curves: self.input_curves(component),
            limits: limits.clone(),
            logarithmic: false,
        });
        Some(Panel { id: "inputs", title: "Inputs", kind: Kind::Lines, views: views.collect() })
    }

    /// What the equations of the vehicles call an input, if all call it alike.
    fn named_input(&self, component: usize) -> Option<String> {
        let agents = &self.run.scenario.as_ref()?.context.agents;
        let mut names = agents.iter().map(|agent| Some(agent.vehicle.model()?.inputs.get(component)?.name.as_str()));
        let first = names.next()??;
        names.all(|name| name == Some(first)).then(|| first.to_string())
    }

    /// What acts, and beside it what the law had asked for, where that was logged.
    fn input_curves(&self, component: usize) -> Vec<Curve> {
        let of = |field: &str| {
            self.each(|place| {
                let series = self.run.signal(place, "command", field)?;
                (component < series.width()).then(|| self.grid.curve(|sample| series.row(sample)[component]))
            })
        };
        let mut curves = of("input");
        let demanded: Vec<Curve> = DEMANDED.into_iter().flat_map(of).collect();
        if !demanded.is_empty() {
            curves.iter_mut().for_each(|curve| curve.label = "applied".into());
        }
        curves.extend(demanded.into_iter().map(|curve| Curve { label: "asked for".into(), second: true, ..curve }));
        curves
    }

    /// Fields that an observer or a controller estimates and a plant knows.
    fn estimated(&self) -> Vec<(String, Field)> {
        let truth = self.run.fields("state");
        let roles = self.run.roles().into_iter().filter(|role| role != "state" && role != "reference");
        let mut estimated: Vec<(String, Field)> = roles
            .flat_map(|role| self.run.fields(&role).into_iter().map(move |field| (role.clone(), field)))
            .filter(|(_, field)| truth.iter().any(|known| known.name == field.name))
            .collect();
        // What cannot be measured comes first.
        estimated.sort_by_key(|(_, field)| match field.name.as_str() {
            "disturbance" => 0,
            "mismatched" => 1,
            "velocity" => 3,
            "position" => 4,
            _ => 2,
        });
        estimated
    }

    fn estimates(&self) -> Option<Panel> {
        let estimated = self.estimated();
        let views = estimated.iter().flat_map(|(role, field)| {
            let twice = estimated.iter().filter(|(_, other)| other.name == field.name).count() > 1;
            let name = if twice { format!("{} ({role})", words(&field.name)) } else { words(&field.name) };
            [self.estimate_norms(role, field, &name), self.estimate_error(role, field, &name)]
        });
        Some(Panel { id: "estimates", title: "Estimates and truth", kind: Kind::Lines, views: views.collect() })
    }

    fn estimate_norms(&self, role: &str, field: &Field, name: &str) -> View {
        let of = |role: &str, label: &str, second: bool| {
            let curves = self.each(|place| self.norm(place, role, &field.name)).into_iter();
            curves.map(|curve| Curve { label: label.into(), second, ..curve }).collect::<Vec<_>>()
        };
        let mut curves = of("state", "truth", false);
        curves.extend(of(role, "estimate", true));
        View { name: name.into(), axis: "norm".into(), unit: self.unit_of_truth(field), curves, ..View::default() }
    }

    fn estimate_error(&self, role: &str, field: &Field, name: &str) -> View {
        let pair = [("state", field.name.as_str()), (role, field.name.as_str())];
        View {
            name: format!("error of {name}"),
            axis: "error norm".into(),
            unit: self.unit_of_truth(field),
            logarithmic: true,
            curves: self.each(|place| self.between(place, pair)),
            limits: Vec::new(),
        }
    }

    /// The units of a field; where it declares none, those of the field of the vehicle that it is about, `position` for
    /// `desired_position`.
    fn units(&self, field: &Field) -> String {
        let about = field.name.trim_start_matches("desired_");
        match self.run.field("state", about).filter(|_| field.unit.is_empty()) {
            Some(truth) => {
                let each: Vec<String> = (0..field.shape.words()).map(|component| unit_of(&truth, component)).collect();
                units(&Field { unit: each.join(","), ..field.clone() })
            }
            None => units(field),
        }
    }

    fn unit_of_truth(&self, field: &Field) -> String {
        self.run.field("state", &field.name).map(|field| units(&field)).unwrap_or_default()
    }

    /// Whatever no other panel shows.
    fn rest(&self) -> Option<Panel> {
        let estimated = self.estimated();
        let compared = |role: &str, name: &str| {
            estimated.iter().any(|(by, field)| field.name == name && (role == by || role == "state"))
        };
        let shown = |role: &str, field: &Field| {
            let name = field.name.as_str();
            let special = is_sliding(name) || is_weight(name) || is_flag(name) || name == "adjacency";
            let error = role != "state" && is_error(name);
            let input = role == "command" && (name == "input" || DEMANDED.contains(&name));
            special || error || input || compared(role, name)
        };
        let views = self.norm_views(|role, field| !shown(role, field));
        Some(Panel { id: "other-signals", title: "Other signals", kind: Kind::Lines, views })
    }
}

fn input_name(quadcopter: bool, component: usize) -> String {
    const QUADCOPTER: [&str; 4] = ["thrust", "roll torque", "pitch torque", "yaw torque"];
    match QUADCOPTER.get(component).filter(|_| quadcopter) {
        Some(name) => (*name).into(),
        None => format!("input {}", component + 1),
    }
}
