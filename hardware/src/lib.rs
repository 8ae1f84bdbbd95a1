//! From a simulated robot to a real one: the frames on the wire, the bridge that stands for the robot in a run, and the
//! emulator that stands for the robot and its cameras at the other end of the wire.

mod bridge;
mod contact;
mod emulator;
pub mod frame;
pub mod health;
pub mod link;
pub mod message;
pub mod settings;
pub mod tracker;

pub use bridge::participants;
pub use emulator::{Options, serve};
