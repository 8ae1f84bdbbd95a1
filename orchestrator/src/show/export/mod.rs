//! The signals of a log for other programs: tables, Parquet, NumPy archives, MATLAB files.

mod csv;
mod mat;
mod npz;
mod parquet;
mod table;
mod thrift;
mod zip;

use csv::names;
pub(crate) use csv::{header, write_csv, write_row};
pub(crate) use mat::write_mat;
pub(crate) use npz::write_npz;
pub(crate) use parquet::write_parquet;
pub(crate) use table::{Column, Table};
