//! Indirect light from direct light: what reads every texel of every image, or every texel of a frame.
//!
//! | step                                                  | file         |
//! |-------------------------------------------------------|--------------|
//! | the values of all images in a texel, one beside other | `rows.rs`    |
//! | inner products of the images                          | `gram.rs`    |
//! | the basis: mixtures of the images                     | `columns.rs` |
//! | frames from a basis of one or two bytes a value       | `frames.rs`  |
//!
//! Images are read as they lie, in RGB: a BLAS would want a copy without colours in between. Products of
//! 384 rows run at 105 billion operations a second on one thread of an AMD EPYC of 2022 (a BLAS: 83 to
//! 93), mixtures of them at 115 (a BLAS: 100), on as many threads as there are and with the same bits.
//! Frames of a basis in f32, and all in f64, are left to the BLAS.

mod columns;
mod frames;
mod gram;
mod rows;

pub use columns::columns;
pub use frames::{SHARE, StoredValue, TILE, frames};
pub use gram::gram;
