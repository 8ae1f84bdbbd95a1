//! The library of vehicles: files with the equations of standard models, and vehicles in files of users.

use std::path::Path;
use std::sync::Arc;

use crate::config::{Node, Problem, Source, Value, did_you_mean, read_text};

/// A vehicle of the library.
#[derive(Clone, Copy, Debug)]
pub struct LibraryVehicle {
    /// Its `kind` in a scenario file.
    pub name: &'static str,
    /// The file: a section `[vehicle]`.
    pub text: &'static str,
}

macro_rules! library {
    ($($name:literal),* $(,)?) => {
        /// The vehicles of the library, in the order of their documentation.
        pub const LIBRARY: &[LibraryVehicle] = &[
            $(LibraryVehicle { name: $name, text: include_str!(concat!("../../../../vehicles/", $name, ".toml")) }),*
        ];
    };
}

library![
    "single_integrator_1d",
    "single_integrator_2d",
    "single_integrator_3d",
    "double_integrator_1d",
    "double_integrator_2d",
    "double_integrator_3d",
    "unicycle",
    "bicycle",
    "dubins_aeroplane",
    "surface_vessel",
    "quadrotor",
    "crazyflie",
    "spacecraft",
    "two_link_arm",
];

impl LibraryVehicle {
    /// The vehicle of this name.
    ///
    /// # Errors
    /// Names all that there are, and the nearest.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let names = || LIBRARY.iter().map(|vehicle| vehicle.name);
        LIBRARY.iter().find(|vehicle| vehicle.name == name).ok_or_else(|| {
            let (list, hint) = (names().collect::<Vec<_>>().join(", "), did_you_mean(name, names()));
            format!("no vehicle is called `{name}`, expected one of {list}{hint}")
        })
    }

    /// Title and source, as its file gives them.
    pub fn words(&self) -> [String; 2] {
        let root = Node::parse(self.source()).ok();
        ["vehicle.title", "vehicle.source"].map(|path| {
            let node = root.as_ref().and_then(|root| root.at(path));
            node.and_then(Node::as_str).unwrap_or_default().to_string()
        })
    }

    /// What is needed to fly it: states without an initial value, inputs, and what its position is.
    pub fn parts(&self) -> VehicleParts {
        let mut root =
            Node::parse(self.source()).unwrap_or_else(|_| Node::from_override(Value::Bool(false), self.name));
        // The library has been read by a test.
        _ = resolve_one(&mut root, "vehicle", "");
        let names = |path: &str| root.at(path).and_then(Node::as_table).into_iter().flat_map(|table| table.iter());
        let length = |path: &str| root.at(path).and_then(Node::as_array).map_or(0, <[Node]>::len);
        VehicleParts {
            title: root.at("vehicle.title").and_then(Node::as_str).unwrap_or_default().to_string(),
            states: names("vehicle.states")
                .filter(|(_, node)| node.at("initial").is_none())
                .map(|(name, _)| name.to_string())
                .collect(),
            inputs: names("vehicle.inputs").map(|(name, _)| name.to_string()).collect(),
            coordinates: length("vehicle.position"),
            is_second_order: length("vehicle.velocity") > 0,
        }
    }

    fn source(&self) -> Arc<Source> {
        Arc::new(Source { name: format!("vehicles/{}.toml", self.name), text: self.text.to_string() })
    }
}

/// See [`LibraryVehicle::parts`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VehicleParts {
    /// What it is, in one line.
    pub title: String,
    /// The states that have no initial value: rows of agents give them.
    pub states: Vec<String>,
    /// The inputs.
    pub inputs: Vec<String>,
    /// Number of coordinates of its position.
    pub coordinates: usize,
    /// Whether it names a velocity.
    pub is_second_order: bool,
}

/// Puts the equations of vehicles of the library, and of vehicles in files, into the tree, below what the scenario says itself.
/// Afterwards the tree needs no other file. `file` is the scenario file, from whose folder paths start.
///
/// # Errors
/// The first file that cannot be read, or is no vehicle.
pub(in crate::scenario) fn resolve(root: &mut Node, file: &str) -> Result<(), Problem> {
    let names = root.at("vehicles").and_then(Node::as_table).into_iter().flat_map(|table| table.iter());
    let named: Vec<String> = names.map(|(name, _)| format!("vehicles.{name}")).collect();
    std::iter::once("vehicle".to_string()).chain(named).try_for_each(|path| {
        assume_equations(root, &path);
        resolve_one(root, &path, file)
    })
}

/// A section without a kind that has what only equations have is one of these.
fn assume_equations(root: &mut Node, path: &str) {
    let Some(table) = root.at_mut(path).and_then(Node::as_table_mut) else { return };
    if table.get("kind").is_none() && ["file", "states", "d"].into_iter().any(|field| table.get(field).is_some()) {
        table.insert("kind", Node::from_override(Value::String("equations".into()), &format!("{path}.kind")));
    }
}

fn resolve_one(root: &mut Node, path: &str, file: &str) -> Result<(), Problem> {
    let Some(kind) = root.at(&format!("{path}.kind")).and_then(Node::as_str) else { return Ok(()) };
    let place = root.at(&format!("{path}.file"));
    let (source, name) = match (LIBRARY.iter().find(|vehicle| vehicle.name == kind), place) {
        (Some(vehicle), None) => (vehicle.source(), vehicle.name.to_string()),
        (None, Some(node)) if kind == "equations" => read_file(node, &format!("{path}.file"), file)?,
        _ => return Ok(()),
    };
    let origin = root.at(path).map(|node| node.origin.clone());
    let mut whole = Node::parse(source.clone())?;
    // It may be one of the library with other numbers. A file of a user may name itself, which is no vehicle.
    if whole.at("vehicle.file").is_some() {
        return Err(Problem::new(origin, path, format!("{} names another file: expected equations", source.name)));
    }
    let is_named = whole.at("vehicle.name").is_some();
    resolve_one(&mut whole, "vehicle", file)?;
    let Some(mut vehicle) = whole.as_table_mut().and_then(|table| table.remove("vehicle")) else {
        let message = format!("{} has no section [vehicle]", source.name);
        return Err(Problem::new(origin, path, message));
    };
    let Some(section) = root.at_mut(path) else { return Ok(()) };
    // The tables would not merge if their kinds differed.
    let kind = Node::from_override(Value::String("equations".into()), &format!("{path}.kind"));
    for table in [&mut vehicle, section].into_iter().filter_map(Node::as_table_mut) {
        table.remove("file");
        table.insert("kind", kind.clone());
    }
    if let Some(table) = vehicle.as_table_mut()
        && !is_named
    {
        table.insert("name", Node::from_override(Value::String(name), &format!("{path}.name")));
    }
    let own = std::mem::replace(section, vehicle);
    section.overlay(own)
}

/// The file that a section names, and what the vehicle in it is called.
fn read_file(node: &Node, path: &str, scenario: &str) -> Result<(Arc<Source>, String), Problem> {
    let problem = |message: String| Problem::new(Some(node.origin.clone()), path, message);
    let Some(name) = node.as_str() else {
        return Err(problem(format!("expected the path of a file, found {}", node.describe())));
    };
    let place = Path::new(scenario).parent().unwrap_or(Path::new("")).join(name);
    let text = read_text(&place).map_err(|error| problem(format!("{}: {error}", place.display())))?;
    let stem = place.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok((Arc::new(Source { name: place.display().to_string(), text }), stem))
}
