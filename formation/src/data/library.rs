//! The data files of a scenario and the curves through them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lockstep::sha256;

use super::DataSource;
use super::csv::Csv;
use super::source::file_name;
use super::{bag, minimum_jerk, pieces, spline};
use crate::formula::{
    Cursor, Curve, DataCall, DataError, DataFunction, FormulaError, Interpolation, Operands, files_named,
};

/// A data file that formulas use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataFile {
    /// As formulas call it.
    pub path: String,
    /// SHA-256 of its bytes, 64 lower-case hexadecimal digits.
    pub digest: String,
    /// What is in it.
    pub bytes: Arc<[u8]>,
}

impl DataFile {
    /// Its name in the directory of a run.
    pub fn name(&self) -> String {
        file_name(&self.digest)
    }
}

/// Reads data files for the formulas of a scenario, each file and each curve once.
#[derive(Debug, Default)]
pub(crate) struct Library {
    source: DataSource,
    /// The SHA-256 of files as far as the scenario gives it.
    expected: BTreeMap<String, String>,
    files: BTreeMap<String, Result<DataFile, String>>,
    /// By function, file and column.
    curves: BTreeMap<(DataFunction, String, String), Result<Arc<Curve>, DataError>>,
}

impl Library {
    pub(crate) fn new(source: DataSource, expected: BTreeMap<String, String>) -> Self {
        Self { source, expected, ..Self::default() }
    }

    /// All files that were read, by their paths.
    pub(crate) fn files(&self) -> Vec<DataFile> {
        self.files.values().filter_map(|file| file.as_ref().ok()).cloned().collect()
    }

    /// Reads the files that the formulas in these texts name, so that they can be compiled later. An error stays with its file.
    pub(crate) fn prepare<'a>(&mut self, texts: impl IntoIterator<Item = &'a str>) {
        self.prepare_files(texts.into_iter().flat_map(files_named));
    }

    /// Reads these files, so that their columns can be read later.
    pub(crate) fn prepare_files<'a>(&mut self, paths: impl IntoIterator<Item = &'a str>) {
        for path in paths {
            _ = self.file(path);
        }
    }

    /// The numbers in a column of a file.
    fn column(&mut self, path: &str, column: &str) -> Result<Vec<f64>, DataError> {
        let file = self.file(path).map_err(DataError::File)?;
        let named = |what: String| format!("{path}: {what}");
        let read = || {
            if bag::is_mcap(&file.bytes) {
                return bag::series(&file.bytes, column).map(|(_, values)| values);
            }
            let csv = Csv::read(&file.bytes).map_err(DataError::File)?;
            let [numbers] = csv.columns([csv.place(column).map_err(DataError::Column)?]).map_err(DataError::File)?;
            if numbers.is_empty() {
                Err(DataError::File("expected rows of numbers, found none".into()))
            } else {
                Ok(numbers)
            }
        };
        read().map_err(|error| error.map(named))
    }

    fn file(&mut self, path: &str) -> Result<DataFile, String> {
        let Self { source, expected, files, .. } = self;
        files.entry(path.into()).or_insert_with(|| read(source, path, expected.get(path).map(String::as_str))).clone()
    }

    fn make(&mut self, call: &DataCall) -> Result<Curve, DataError> {
        let file = self.file(call.file).map_err(DataError::File)?;
        let named = |what: String| format!("{}: {what}", call.file);
        curve(&file.bytes, call).map_err(|error| error.map(named))
    }
}

impl Operands for Library {
    fn read(&mut self, _: &str, _: usize, _: &mut Cursor) -> Result<Option<usize>, FormulaError> {
        Ok(None)
    }

    fn curve(&mut self, call: &DataCall) -> Result<Arc<Curve>, DataError> {
        let key = (call.function, call.file.to_string(), call.column.to_string());
        if let Some(known) = self.curves.get(&key) {
            return known.clone();
        }
        let made = self.make(call).map(Arc::new);
        match self.curves.entry(key) {
            Entry::Vacant(place) => place.insert(made).clone(),
            Entry::Occupied(known) => known.get().clone(),
        }
    }
}

/// The data files of a scenario, for formulas in the sections of its components.
#[derive(Clone, Debug, Default)]
pub struct DataCurves(Arc<Mutex<Library>>);

impl DataCurves {
    pub(crate) fn new(library: Library) -> Self {
        Self(Arc::new(Mutex::new(library)))
    }

    /// The curve that a call in a formula asks for, [`Operands::curve`].
    ///
    /// # Errors
    /// Says why there is no such curve.
    pub fn curve(&self, call: &DataCall) -> Result<Arc<Curve>, DataError> {
        self.library().curve(call)
    }

    /// The numbers in a column of a data file, at least one.
    ///
    /// # Errors
    /// Says what is wrong with the file or the column.
    pub(crate) fn column(&self, file: &str, column: &str) -> Result<Vec<f64>, DataError> {
        self.library().column(file, column)
    }

    fn library(&self) -> MutexGuard<'_, Library> {
        // A panic in between leaves no half-made curve.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read(source: &DataSource, path: &str, expected: Option<&str>) -> Result<DataFile, String> {
    let bytes = source.read(path, expected)?;
    let digest = sha256(&bytes);
    match expected {
        Some(expected) if expected != digest => {
            let message = "the file is another one than [data] of the scenario says: its SHA-256 is";
            Err(format!("{path}: {message} {digest}, expected {expected}"))
        }
        _ => Ok(DataFile { path: path.into(), digest, bytes }),
    }
}

/// The curve that a call asks for of the file with this content. Errors do not name the file.
fn curve(bytes: &[u8], call: &DataCall) -> Result<Curve, DataError> {
    if bag::is_mcap(bytes) {
        let (x, y) = bag::series(bytes, call.column)?;
        return Ok(through(x, &y, call.function));
    }
    let csv = Csv::read(bytes).map_err(DataError::File)?;
    if call.function == DataFunction::Trajectory && pieces::are_in(&csv) {
        csv.place(&format!("{}^0", call.column)).map_err(DataError::Column)?;
        return pieces::read(&csv, call.column).map_err(DataError::File);
    }
    let place = csv.place(call.column).map_err(DataError::Column)?;
    let (x, y) = points(&csv, place).map_err(DataError::File)?;
    Ok(through(x, &y, call.function))
}

/// The curve through these points, at least two.
fn through(x: Vec<f64>, y: &[f64], function: DataFunction) -> Curve {
    match function {
        DataFunction::Trajectory => minimum_jerk::minimum_jerk(x, y),
        DataFunction::Table(Interpolation::Hold) => spline::hold(x, y),
        DataFunction::Table(Interpolation::Linear) => spline::linear(x, y),
        DataFunction::Table(Interpolation::Cubic) => spline::cubic(x, y),
    }
}

/// The first column, which must increase, and the one at this place.
fn points(csv: &Csv, place: usize) -> Result<(Vec<f64>, Vec<f64>), String> {
    let (x, y) = if place == 0 {
        let [x] = csv.columns([0])?;
        (x.clone(), x)
    } else {
        let [x, y] = csv.columns([0, place])?;
        (x, y)
    };
    if csv.rows() < 2 {
        return Err(format!("expected at least 2 rows of numbers, found {}", csv.rows()));
    }
    match x.windows(2).position(|x| x[1] <= x[0]) {
        None => Ok((x, y)),
        Some(row) => {
            let (line, name) = (csv.line(row + 1), csv.names[0]);
            let [before, found] = [x[row], x[row + 1]];
            Err(format!(
                "line {line}, column `{name}`: expected a number above {before} of the line before, found {found}"
            ))
        }
    }
}
