//! The rows of the table `agents`.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use super::coordinates::Coordinates;
use super::elsewhere::Elsewhere;
use super::model::{Surroundings, VehicleOf, Vehicles};
use super::program_parameters;
use super::standard_vehicle::{VehicleKind, VehicleSection};
use crate::config::{Node, Problems, read};
use crate::vehicle::{Drive, Model, Omni, Quadcopter, Vehicle, evaluate};

/// An agent: its vehicle as it is, as the controllers know it, and where it starts.
#[derive(Clone, Debug)]
pub struct Agent {
    /// Number from 1, its place in the table.
    pub number: u32,
    /// The `i` of formulas: the number, unless the scenario says otherwise.
    pub id: u32,
    /// Its vehicle among `[vehicles]`; empty if it has that of `[vehicle]`.
    pub vehicle_name: String,
    /// The vehicle that the plant integrates.
    pub vehicle: Vehicle,
    /// The vehicle as observers and controllers know it.
    pub nominal: Vehicle,
    /// Which coordinates of the position are angles, whose errors are taken on the circle: none, unless the scenario says so.
    pub angles: Vec<bool>,
    /// Initial coordinates.
    pub position: Vec<f64>,
    /// Initial velocities; zeros for vehicles of order 1.
    pub velocity: Vec<f64>,
    /// Initial estimate of the coordinates.
    pub estimate: Vec<f64>,
    /// Initial estimate of the velocities.
    pub estimate_velocity: Vec<f64>,
}

/// An agent.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    /// The i of formulas; by default the number of the agent.
    id: Option<u32>,
    /// Its vehicle, one of `[vehicles]`; by default that of `[vehicle]`.
    #[schemars(with = "Option<String>")]
    #[allow(dead_code, reason = "it decides how the row is read")]
    vehicle: Option<Elsewhere>,
    /// Coordinates at t = 0, m and rad; a quadcopter may leave out its angles.
    position: Coordinates,
    /// Velocities at t = 0, m/s and rad/s; by default 0.
    velocity: Option<Coordinates>,
    /// Initial estimate of the coordinates, for an observer; by default the coordinates.
    estimate: Option<Coordinates>,
    /// Initial estimate of the velocities, for an observer; by default 0.
    estimate_velocity: Option<Coordinates>,
    /// 1: the inputs are wheel speeds, 2: wheel forces.
    order: Option<u32>,
    /// Mass, kg.
    m: Option<f64>,
    /// Radius of a robot, or arm of a quadcopter, m.
    #[serde(rename = "R")]
    radius: Option<f64>,
    /// The radius as the controllers know it, m; by default the true one.
    #[serde(rename = "R_hat")]
    radius_known: Option<f64>,
    /// Moment of inertia of a robot, kg m².
    #[serde(rename = "I")]
    inertia: Option<f64>,
    /// A coefficient of friction, for formulas.
    fric: Option<f64>,
    /// Moment of inertia of a quadcopter about its x-axis, kg m².
    #[serde(rename = "Jx")]
    inertia_x: Option<f64>,
    /// About its y-axis, kg m².
    #[serde(rename = "Jy")]
    inertia_y: Option<f64>,
    /// About its z-axis, kg m².
    #[serde(rename = "Jz")]
    inertia_z: Option<f64>,
    /// Drag of a quadcopter, N s/m.
    #[serde(rename = "K")]
    drag: Option<f64>,
    /// Ratio of torque to thrust of a rotor, m.
    upsilon: Option<f64>,
    /// Parameters for programs that play participants of this agent; they override those of `[controller.with]` and so on.
    #[serde(default)]
    #[schemars(schema_with = "program_parameters::schema")]
    #[allow(dead_code, reason = "programs look it up in the tree; here it is a known field")]
    with: Option<Elsewhere>,
}

/// The fields of a row.
pub(super) const AGENT_FIELDS: &[&str] = &[
    "id",
    "vehicle",
    "position",
    "velocity",
    "estimate",
    "estimate_velocity",
    "order",
    "m",
    "R",
    "R_hat",
    "I",
    "fric",
    "Jx",
    "Jy",
    "Jz",
    "K",
    "upsilon",
    program_parameters::WITH,
];

/// Reads the rows; what is wrong goes to `problems`.
pub(super) fn read_agents(around: Surroundings, vehicles: &Vehicles, problems: &mut Problems) -> Vec<Agent> {
    let root = around.root;
    let Some(rows) = root.at("agents").and_then(Node::as_array) else {
        problems.at(root, "agents", "expected a list of tables, one per agent");
        return Vec::new();
    };
    if rows.is_empty() {
        problems.at(root, "agents", "expected at least one agent");
    }
    if let Some(section) = vehicles.standard()
        && let Some(message) = section.order.and_then(|order| section.wrong_order(order))
    {
        problems.at(root, "vehicle.order", message);
    }
    let mut agents = Vec::with_capacity(rows.len());
    // The equations are the same for all: what is wrong with them is said once.
    let mut is_reported = false;
    for (index, node) in rows.iter().enumerate() {
        let path = format!("agents.{}", index + 1);
        let (vehicle, name) = match vehicles.of(root, &path, problems) {
            Some((vehicle, name)) => (Some(vehicle), name),
            None => (None, ""),
        };
        let number = index as u32 + 1;
        let mut agent = match vehicle {
            Some(VehicleOf::Standard(section)) => {
                // A row that cannot be read still counts, so that what depends on the number of agents can be checked.
                let read_row = read::<Row>(node, &path, problems);
                let silent = read_row.is_none();
                let row = read_row.unwrap_or_default();
                RowReader { row: &row, section, problems, root, path, silent }.agent(number)
            }
            Some(VehicleOf::Equations(_)) if is_reported => Agent::of_model(number, number, Model::default()),
            Some(VehicleOf::Equations(equations)) => {
                let id = read_id(node, &path, problems).unwrap_or(number);
                let model = equations.model(around, index, rows.len(), id, problems);
                is_reported = model.is_none();
                Agent::of_model(number, id, model.unwrap_or_default())
            }
            None => Agent::of_model(number, number, Model::default()),
        };
        agent.vehicle_name = name.to_string();
        agents.push(agent);
    }
    agents
}

/// The `id` of a row that is not read as a [`Row`].
fn read_id(row: &Node, path: &str, problems: &mut Problems) -> Option<u32> {
    row.at("id").and_then(|node| read::<u32>(node, &format!("{path}.id"), problems))
}

impl Agent {
    /// An agent whose vehicle is given by equations.
    fn of_model(number: u32, id: u32, model: Model) -> Self {
        let slots = model.start();
        let values = |formulas: &[crate::formula::Formula]| {
            let mut values = vec![0.0; formulas.len()];
            evaluate(formulas, &slots, &mut values);
            values
        };
        let (position, velocity) = (values(&model.position), values(&model.velocity));
        let angles = model.position_angles.clone();
        let vehicle = Vehicle::Model(Arc::new(model));
        Self {
            angles,
            number,
            id,
            vehicle_name: String::new(),
            nominal: vehicle.clone(),
            vehicle,
            estimate: position.clone(),
            estimate_velocity: vec![0.0; position.len()],
            position,
            velocity,
        }
    }
}

struct RowReader<'a> {
    row: &'a Row,
    section: &'a VehicleSection,
    problems: &'a mut Problems,
    root: &'a Node,
    path: String,
    /// The row could not be read, which has been reported.
    silent: bool,
}

impl RowReader<'_> {
    /// The agent of this row; with dummies where something is wrong, which is reported.
    fn agent(&mut self, number: u32) -> Agent {
        let vehicle = self.vehicle();
        let nominal = self.nominal(&vehicle);
        let length = vehicle.coordinates();
        let position = self.values("position", Some(&self.row.position), length);
        let velocity = self.values("velocity", self.row.velocity.as_ref(), length);
        let estimate = match &self.row.estimate {
            Some(values) => self.values("estimate", Some(values), length),
            None => position.clone(),
        };
        let estimate_velocity = self.values("estimate_velocity", self.row.estimate_velocity.as_ref(), length);
        let id = self.row.id.unwrap_or(number);
        let vehicle_name = String::new();
        let names = vehicle.coordinate_names();
        let angles = names.iter().map(|name| self.section.angles.iter().any(|angle| angle == name)).collect();
        Agent { number, id, vehicle_name, angles, vehicle, nominal, position, velocity, estimate, estimate_velocity }
    }

    fn vehicle(&mut self) -> Vehicle {
        if let Some(message) = self.row.order.and_then(|order| self.section.wrong_order(order)) {
            self.report("order", message);
        }
        match self.section.kind {
            VehicleKind::Quadcopter => {
                let quadcopter = Quadcopter {
                    mass: self.positive("m", self.row.m),
                    arm: self.positive("R", self.row.radius),
                    inertia: [
                        self.positive("Jx", self.row.inertia_x),
                        self.positive("Jy", self.row.inertia_y),
                        self.positive("Jz", self.row.inertia_z),
                    ],
                    drag: self.coefficient("K", self.row.drag),
                    torque_factor: self.positive("upsilon", self.row.upsilon),
                };
                Vehicle::Quadcopter(quadcopter)
            }
            VehicleKind::Integrator => Vehicle::Omni(Omni {
                drive: Drive::Acceleration,
                radius: self.positive_or_one("R", self.row.radius),
                mass: self.positive_or_one("m", self.row.m),
                inertia: self.positive_or_one("I", self.row.inertia),
                friction: self.coefficient("fric", self.row.fric),
            }),
            VehicleKind::Omni => self.omni(),
        }
    }

    fn omni(&mut self) -> Vehicle {
        let drive = match self.row.order.or(self.section.order) {
            Some(1) => Drive::Speed,
            Some(2) => Drive::Force,
            // Reported where it stands. What forces need besides is not asked for, as they may not be meant.
            Some(_) => Drive::Speed,
            None => {
                self.report("order", "missing: 1 (wheel speeds) or 2 (wheel forces), here or in `[vehicle]`".into());
                Drive::Force
            }
        };
        let radius = self.positive("R", self.row.radius);
        let (mass, inertia) = match drive {
            Drive::Force => (self.positive("m", self.row.m), self.positive("I", self.row.inertia)),
            _ => (self.positive_or_one("m", self.row.m), self.positive_or_one("I", self.row.inertia)),
        };
        Vehicle::Omni(Omni { drive, radius, mass, inertia, friction: self.coefficient("fric", self.row.fric) })
    }

    fn nominal(&mut self, vehicle: &Vehicle) -> Vehicle {
        match (vehicle, self.row.radius_known) {
            (Vehicle::Omni(omni), Some(known)) => {
                let radius = self.positive("R_hat", Some(known));
                Vehicle::Omni(Omni { radius, ..omni.clone() })
            }
            _ => vehicle.clone(),
        }
    }

    /// A parameter > 0; a dummy if it is missing or not admissible, which is reported.
    fn positive(&mut self, field: &str, value: Option<f64>) -> f64 {
        match value {
            Some(value) if value.is_finite() && value > 0.0 => return value,
            Some(value) => self.report(field, format!("expected a number > 0, found {value}")),
            None => self.report(field, format!("missing field `{field}`, which this vehicle needs")),
        }
        1.0
    }

    /// A parameter > 0 that may be left out, and is 1 then.
    fn positive_or_one(&mut self, field: &str, value: Option<f64>) -> f64 {
        value.map_or(1.0, |value| self.positive(field, Some(value)))
    }

    /// A finite coefficient that may be left out, and is 0 then.
    fn coefficient(&mut self, field: &str, value: Option<f64>) -> f64 {
        match value {
            Some(value) if !value.is_finite() => {
                self.report(field, format!("expected a finite number, found {value}"));
                0.0
            }
            value => value.unwrap_or(0.0),
        }
    }

    /// Values of all coordinates. Fewer than there are mean that the rest (a quadcopter's angles) is 0.
    fn values(&mut self, field: &str, values: Option<&Coordinates>, length: usize) -> Vec<f64> {
        let mut values = values.map(|values| values.values(length)).unwrap_or_default();
        let accepted =
            values.is_empty() && field != "position" || values.len() == length || length == 6 && values.len() == 3;
        if !accepted {
            let expected = if length == 6 { "3 or 6".to_string() } else { length.to_string() };
            self.report(field, format!("expected {expected} values, found {}", values.len()));
            return vec![0.0; length];
        }
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            self.report(field, format!("expected finite numbers, found {value}"));
            return vec![0.0; length];
        }
        values.resize(length, 0.0);
        values
    }

    fn report(&mut self, field: &str, message: String) {
        if self.silent {
            return;
        }
        self.problems.at(self.root, &format!("{}.{field}", self.path), message);
    }
}
