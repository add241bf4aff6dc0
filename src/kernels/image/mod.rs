//! The map before anything is fitted to it: its samples, its cells, and fewer of them.
//!
//! | step                                          | file           |
//! |-----------------------------------------------|----------------|
//! | samples that no light can have                | `samples.rs`   |
//! | the cells of an image on the sphere           | `grid.rs`      |
//! | luminance                                     | `luminance.rs` |
//! | a smaller working map, bright cells as points | `reduce.rs`    |
//! | - rows as one                                 | `means.rs`     |

mod grid;
mod luminance;
mod means;
mod reduce;
mod samples;

pub use grid::Grid;
pub use luminance::{LUMINANCE, luminance};
pub(crate) use means::weighted_mean;
pub use reduce::{WorkingMap, reduce};
pub use samples::{Unusable, unusable};
pub(crate) use samples::{check_rgb, check_samples};
