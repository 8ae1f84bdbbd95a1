//! Tests of the whole program from outside: real processes, real shared memory, real files.

mod endurance;
mod engine;
mod faults;
mod keys;
mod look;
mod matrix;
mod mistakes;
mod program;
mod readers;
mod recovery;
mod replay;
mod runs;
mod scaffold;
mod tap;
