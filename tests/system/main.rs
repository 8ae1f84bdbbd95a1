//! Tests of the whole program from outside: real processes, real shared memory, real files.

mod engine;
mod faults;
mod look;
mod mistakes;
mod own_programs;
mod program;
mod readers;
mod runs;
