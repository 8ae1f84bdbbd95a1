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

impl DataError {
    /// The same reason in other words.
    pub(crate) fn map(self, words: impl FnOnce(String) -> String) -> Self {
        match self {
            Self::File(what) => Self::File(words(what)),
            Self::Column(what) => Self::Column(words(what)),
        }
    }
}

impl Interpolation {
    /// All of them by their names.
    pub(super) const ALL: [(&'static str, Self); 3] =
        [("hold", Self::Hold), ("linear", Self::Linear), ("cubic", Self::Cubic)];
}

/// The files that calls in this text read, by the text alone: the formula need not be valid.
pub(crate) fn files_named(text: &str) -> impl Iterator<Item = &str> {
    ["table", "trajectory"].into_iter().flat_map(move |function| text.split(function).skip(1)).filter_map(|rest| {
        let (file, _) = rest.trim_start().strip_prefix('(')?.trim_start().strip_prefix('"')?.split_once('"')?;
        Some(file)
    })
}

#[cfg(test)]
mod tests {
    use super::files_named;

    #[test]
    fn finds_the_files_of_a_text() {
        let text = r#"sum(a_ij*(x_j - x)) + table ( "a b.csv", "x", t) - 2*trajectory("w.csv","y",t) + table("#;
        assert_eq!(files_named(text).collect::<Vec<_>>(), ["a b.csv", "w.csv"]);
    }
}
