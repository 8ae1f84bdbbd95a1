//! Tests of the whole program from outside: real processes, real shared memory, real files.

mod assertions;
mod engine;
mod faults;
mod limits;
mod look;
mod matrix;
mod mistakes;
mod program;
mod readers;
mod recovery;
mod runs;
