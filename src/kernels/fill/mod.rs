//! Smooth radiance for pixels without any: behind removed lights, and outside of the seen part of a map.
//!
//! | step                                          | file               |
//! |-----------------------------------------------|--------------------|
//! | one image of the multigrid                    | `level.rs`         |
//! | radiance that solves Laplace's equation       | `harmonic_fill.rs` |
//! | - the same in wide holes                      | `multigrid.rs`     |
//! |   - relaxation of rows                        | `row_relaxation.rs` |
//! | the unseen part of a map                      | `unseen_part.rs`   |

mod harmonic_fill;
mod level;
mod multigrid;
mod row_relaxation;
mod unseen_part;

pub(crate) use harmonic_fill::harmonic_fill;
pub(crate) use level::{Level, Upsampling};
pub(crate) use unseen_part::LEAST_SHARE;
pub use unseen_part::fill_unseen;
