//! Runs in many processes: the same bits as in one, and an end in order whatever happens.

#[path = "../../examples/chain14/chain.rs"]
mod chain;
mod mishaps;
mod replacements;
mod results;
mod support;
mod waking;
mod worker;
