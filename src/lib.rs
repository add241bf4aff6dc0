//! An environment map as a handful of lights: the kernels of the Python package `envlights`.
//!
//! [`kernels`] is plain Rust over `ndarray` views; read its page for the method.
//! [`formats`] reads image files. `bindings` exposes both to Python (behind the feature `python`), [`error`] holds
//! every refusal, [`interrupt`] stops running kernels.

pub mod error;
pub mod formats;
pub mod interrupt;
pub mod kernels;

#[cfg(feature = "python")]
mod bindings;
