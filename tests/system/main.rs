//! Tests of the whole program from outside: real processes, real shared memory, real files.

mod assertions;
mod data;
mod descendants;
mod doors;
#[cfg(feature = "long-tests")]
mod endurance;
mod engine;
mod external;
mod faults;
mod figures;
mod hardware;
mod interface;
mod jobs;
mod keys;
mod limits;
mod logs;
mod look;
#[cfg(feature = "long-tests")]
mod matrix;
mod memory;
mod mistakes;
mod moments;
mod overrides;
mod own_programs;
mod printed;
mod program;
mod provenance;
mod readers;
mod realtime;
mod recovery;
mod replay;
mod robot;
mod runs;
mod safety;
mod scaffold;
mod scene;
mod shortage;
mod stopping;
mod swaps;
mod tap;
mod topology;
mod tutorial;
mod validation;
mod vehicles;
mod watch;
mod web;
