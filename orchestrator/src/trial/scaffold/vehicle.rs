//! A scenario file with the equations of a vehicle, to be changed into one's own.

use std::path::Path;

use formation::scenario::{LibraryVehicle, VehicleParts};

use crate::failure::Failure;
use crate::terminal::program;

/// Writes `NAME.toml`, which runs as it is, and returns what to do next, in words. The equations are those of `from`, a vehicle of the
/// library.
///
/// # Errors
/// [`Failure::Usage`] if the name is invalid, the file exists, or there is no such vehicle; [`Failure::System`] if it cannot be written.
pub fn create_vehicle(name: &str, from: &str) -> Result<String, Failure> {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || !name.chars().all(is_letter) {
        return Err(Failure::Usage(format!("{name}: a name consists of letters, digits, _ and -")));
    }
    let vehicle = LibraryVehicle::named(from).map_err(|reason| Failure::Usage(format!("--from: {reason}")))?;
    let file = format!("{name}.toml");
    if Path::new(&file).exists() {
        return Err(Failure::Usage(format!("{file} exists already; choose another name")));
    }
    std::fs::write(&file, scenario(name, vehicle)).map_err(Failure::system(format!("write {file}")))?;
    let program = program();
    Ok(format!(
        "{file} is there: the equations of `{from}`, a law and three agents. Next:\n    {program} run {file}\n    {program} report \
         runs/{name}.mcap\nThen change equations, parameters and law, and ask `{program} validate {file}`; docs/own-system.md explains all fields."
    ))
}

fn scenario(name: &str, vehicle: &LibraryVehicle) -> String {
    let parts = vehicle.parts();
    let rows = (0..3).map(|agent| {
        // Apart from each other in the first state, and at 0 in the others.
        let value = |(place, state): (usize, &String)| format!("{state} = {}", if place == 0 { agent } else { 0 });
        let states = parts.states.iter().enumerate().map(value).collect::<Vec<_>>().join(", ");
        format!("    {{ {states} }},\n")
    });
    let (define, law) = law(&parts);
    let law = parts.inputs.iter().zip(&law).map(|(input, law)| format!("law.{input} = \"{law}\"\n"));
    format!(
        "name = \"{name}\"\ntitle = \"{title}\"\nagents = [\n{rows}]\n\n[timing]\ndt = 0.01\nduration = 20\n\n# Who hears whom; b: who \
         knows the reference.\n[topology]\nA = \"two_way_ring\"\nb = 1\n\n# Where each agent has to be: a turning triangle.\n[reference]\n\
         define.angle = \"0.2*t + 2*pi*i/N\"\nposition = [{reference}]\n\n[controller]\nkind = \"formulas\"\n{define}{law}\n{vehicle}",
        title = parts.title,
        rows = rows.collect::<String>(),
        reference = ["\"3*cos(angle)\"", "\"3*sin(angle)\"", "\"2\""][..parts.coordinates.clamp(1, 3)].join(", "),
        law = law.collect::<String>(),
        vehicle = vehicle.text,
    )
}

/// Definitions, and the law of every input: one that follows the reference and keeps the formation where that is short, else 0.
fn law(parts: &VehicleParts) -> (String, Vec<String>) {
    let error = |axis: &str, place: usize| {
        let own = format!("{axis} - reference.position[{place}]");
        format!("define.e{axis} = \"b_i*({own}) + sum(a_ij*({own} - ({axis}_j - reference_j.position[{place}])))\"\n")
    };
    let VehicleParts { inputs, coordinates, is_second_order, .. } = parts;
    let axes = ["x", "y", "z"].into_iter().take(*coordinates).enumerate();
    if axes.clone().map(|(_, axis)| format!("u{axis}")).eq(inputs.iter().cloned()) {
        let define = axes.clone().map(|(place, axis)| error(axis, place)).collect();
        let law = axes.map(|(place, axis)| match is_second_order {
            true => format!("reference.acceleration[{place}] - 2*(v{axis} - reference.velocity[{place}]) - e{axis}"),
            false => format!("reference.velocity[{place}] - e{axis}"),
        });
        return (define, law.collect());
    }
    if inputs == &["v", "omega"] {
        let law = ["-cos(theta)*ex - sin(theta)*ey", "2*(sin(theta)*ex - cos(theta)*ey)"];
        return (error("x", 0) + &error("y", 1), law.map(String::from).to_vec());
    }
    let define =
        "# The law is yours to write: a formula for each input, of t, the states, the reference and the neighbours.\n";
    (define.into(), vec!["0".into(); inputs.len()])
}
