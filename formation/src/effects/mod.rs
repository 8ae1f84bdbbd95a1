//! What changes a signal between its writer and its readers: sensors, links between agents, actuators.
//!
//! All of them are pure: a struct with its parameters and its state, and an `update`. Their random numbers are functions of the seed, the name
//! of the object and the step ([`RandomStream`](crate::math::RandomStream)).

mod actuator;
mod delay;
mod delay_line;
mod limits;
mod link;
mod loss;
mod schedule;
mod sensor;
mod trigger;

pub use actuator::{ActuatorLaw, ActuatorLimits};
pub use delay::Delay;
pub use link::{Instant, LINK_FIELDS, Link, LinkModel, Missing};
pub use loss::Loss;
pub use schedule::Schedule;
pub use sensor::{Sensor, SensorErrors};
pub use trigger::{Trigger, TriggerFields};
