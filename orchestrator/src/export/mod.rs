//! The signals of a log for other programs: tables, NumPy archives, MATLAB files.

mod csv;
mod mat;
mod npz;
mod table;
mod zip;

pub(crate) use csv::{header, write_csv, write_row};
pub(crate) use mat::write_mat;
pub(crate) use npz::write_npz;
pub(crate) use table::{Column, Table};
