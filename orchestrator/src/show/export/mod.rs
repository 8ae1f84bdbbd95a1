//! The signals of a log for other programs: tables, Parquet, NumPy archives, MATLAB files.

mod aligned;
mod csv;
mod mat;
mod npz;
mod parquet;
mod table;
mod thrift;

pub(crate) use aligned::write_aligned;
use clap::ValueEnum;
use csv::names;
pub(crate) use csv::{write_csv, write_rows};
pub(crate) use mat::write_mat;
pub(crate) use npz::write_npz;
pub(crate) use parquet::write_parquet;
pub(crate) use table::{Column, Table};

/// How exported signals are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportFormat {
    /// A folder with one table per topic: t, step, then a column per number
    Csv,
    /// A folder with one file per topic and the same columns: pandas.read_parquet(FILE); also for DuckDB, Polars, Spark
    Parquet,
    /// For NumPy: np.load(FILE)["agent_1_state_position"] has a row per step
    Npz,
    /// For MATLAB and Octave: load FILE, then agent_1_state_position has a row per step
    Mat,
}
