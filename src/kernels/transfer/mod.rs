//! Indirect light from direct light: what reads every texel of every image, or every texel of a frame.
//!
//! | step                                                  | file         |
//! |-------------------------------------------------------|--------------|
//! | the values of all images in a texel, one beside other | `rows.rs`    |
//! | inner products of the images                          | `gram.rs`    |
//! | the basis: mixtures of the images                     | `columns.rs` |
//! | frames from a basis of one or two bytes a value       | `frames.rs`  |
//!
//! Images are read as they lie, in RGB: a BLAS would want a copy without colours in between.

mod columns;
mod frames;
mod gram;
mod rows;

pub use columns::columns;
pub use frames::{Kept, frames};
pub use gram::gram;
