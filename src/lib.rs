//! An environment map as a handful of lights: the kernels of the Python package `envlights`.
//!
//! [`kernels`] is plain Rust over `ndarray` views; read its page for the method.
//! `bindings` opens it to Python (behind the feature `python`), [`error`] holds every refusal,
//! [`interrupt`] stops what nobody waits for any more.

pub mod error;
pub mod interrupt;
pub mod kernels;

#[cfg(feature = "python")]
mod bindings;
