//! An environment map as a handful of lights: the kernels of the Python package `envlights`.
//!
//! [`kernels`] is plain Rust over `ndarray` views; read its page for the method.
//! `bindings` opens it to Python (behind the feature `python`), [`error`] holds every refusal.

pub mod error;
pub mod kernels;

#[cfg(feature = "python")]
mod bindings;
