//! Data files of formulas: `table("wind.csv", "vx", t)`, `trajectory("way.csv", "x", t)`, `table("flight.mcap", "/cmd_vel.linear.x", t)`.
//!
//! A file is a table of numbers as text, with the names of its columns in the first line, and `,`, `;` or tabs between them. The
//! first column must increase. Or it is an MCAP file, and a column is a field of a topic in it.
//!
//! | call | curve |
//! |---|---|
//! | `table(FILE, COLUMN, x)` | straight lines from point to point |
//! | `table(FILE, COLUMN, x, "hold")` | the value of the point before |
//! | `table(FILE, COLUMN, x, "cubic")` | the cubic spline with "not a knot" ends, as in MATLAB and SciPy |
//! | `trajectory(FILE, COLUMN, t)` | the curve of minimum jerk through the points, at rest at both ends; four continuous derivatives between them, two there |
//! | the same of a file with the columns `duration,x^0,...,x^7,y^0,...` | the polynomials of the file, one behind the other from 0 on (Crazyswarm) |
//!
//! Beyond its ends, a curve has the value that it has there, and derivatives 0.
//!
//! [`DataSource`] says where their bytes come from: beside a scenario file, in a run directory, or in a log. `Library` reads each
//! file and makes each curve once for all formulas of a scenario, and knows which files were read.

mod bag;
mod csv;
mod library;
mod minimum_jerk;
mod pieces;
mod source;
mod spline;

#[cfg(test)]
mod tests;

pub(crate) use library::Library;
pub use library::{DataCurves, DataFile};
pub use source::DataSource;
