//! Trajectories as Crazyswarm writes them: a polynomial of degree seven for each piece and coordinate.

use super::csv::Csv;
use crate::formula::Curve;

/// Coefficients of a piece.
const WIDTH: usize = 8;

/// Whether the columns are those of such a file: `duration,x^0,...,x^7,y^0,...`.
pub(super) fn are_in(csv: &Csv) -> bool {
    csv.names[0] == "duration" && csv.names.iter().any(|name| name.ends_with("^0"))
}

/// The polynomials of the coordinate, from time 0 on. After the last one the curve keeps its end.
///
/// # Errors
/// Names the coordinate that there is none of, the line with a duration that is not positive, or what is no number.
pub(super) fn read(csv: &Csv, coordinate: &str) -> Result<Curve, String> {
    let mut places = [0; WIDTH + 1];
    for (power, place) in places.iter_mut().skip(1).enumerate() {
        *place = csv.place(&format!("{coordinate}^{power}"))?;
    }
    if !places.is_sorted() {
        return Err(format!("expected the columns {coordinate}^0 to {coordinate}^7 in this order"));
    }
    let [durations, columns @ ..] = csv.columns::<{ WIDTH + 1 }>(places)?;
    let mut knots = vec![0.0];
    for (row, duration) in durations.iter().enumerate() {
        if *duration <= 0.0 {
            return Err(format!("line {}: expected a duration > 0, found {duration}", csv.line(row)));
        }
        knots.push(knots[row] + duration);
    }
    let coefficients: Vec<f64> =
        (0..durations.len()).flat_map(|row| columns.each_ref().map(|column| column[row])).collect();
    let last = coefficients.rchunks(WIDTH).next().ok_or("expected at least 1 row, found none")?;
    let length = durations[durations.len() - 1];
    let end = last.iter().rev().fold(0.0, |sum, coefficient| sum * length + coefficient);
    Ok(Curve::new(knots, WIDTH, coefficients, end))
}
