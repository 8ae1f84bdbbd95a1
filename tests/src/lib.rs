//! Tests of the whole program, from outside, and what they share.

pub mod hostile;

/// The programs in the documentation compile.
#[cfg(doctest)]
#[doc = include_str!("../../docs/adding-a-controller.md")]
mod adding_a_controller {}
