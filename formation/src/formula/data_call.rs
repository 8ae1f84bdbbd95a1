//! Calls that read data files.

/// A call such as `table("wind.csv", "vx", t)`, without the place at which it reads the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataCall<'a> {
    /// What is made of the numbers.
    pub function: DataFunction,
    /// The file, as the formula calls it.
    pub file: &'a str,
    /// The column, or the coordinate.
    pub column: &'a str,
}

/// A function that makes a curve of the numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DataFunction {
    /// A column over the first one.
    Table(Interpolation),
    /// A smooth curve through waypoints, or the polynomials of a trajectory.
    Trajectory,
}

/// What lies between the points of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interpolation {
    /// The value of the point before.
    Hold,
    /// A straight line.
    #[default]
    Linear,
    /// A cubic spline.
    Cubic,
}

/// Why there is no such curve, for the person who wrote the formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataError {
    /// The file is wrong, or cannot be read.
    File(String),
    /// It has no such column.
    Column(String),
}

impl Interpolation {
    /// All of them by their names.
    pub(super) const ALL: [(&'static str, Self); 3] =
        [("hold", Self::Hold), ("linear", Self::Linear), ("cubic", Self::Cubic)];
}
