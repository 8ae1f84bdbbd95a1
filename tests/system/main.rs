//! Tests of the whole program from outside: real processes, real shared memory, real files.

mod assertions;
mod endurance;
mod engine;
mod faults;
mod hardware;
mod keys;
mod limits;
mod look;
mod matrix;
mod mistakes;
mod moments;
mod own_programs;
mod program;
mod readers;
mod recovery;
mod replay;
mod robot;
mod runs;
mod safety;
mod scaffold;
mod scene;
mod shortage;
mod swaps;
mod tap;
mod tutorial;
mod watch;
