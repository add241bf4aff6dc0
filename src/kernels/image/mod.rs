//! Preparation of a map: samples, cells, reduction, rotation.
//!
//! | step                                          | file           |
//! |-----------------------------------------------|----------------|
//! | decoding of integer images                    | `codes.rs`     |
//! | conversion of colours to linear Rec.709       | `colour.rs`    |
//! | unusable samples                              | `samples.rs`   |
//! | clip level of a picture of codes              | `white.rs`     |
//! | the cells of an image on the sphere           | `grid.rs`      |
//! | luminance                                     | `luminance.rs` |
//! | a smaller working map, bright cells as points | `reduce.rs`    |
//! | - bright cells in parts                       | `parts.rs`     |
//! | means over blocks of pixels                   | `block_rows.rs` |
//! | a map after a rotation                        | `rotate.rs`    |
//! | - the cell that holds a direction             | `cells.rs`     |

mod block_rows;
mod cells;
mod codes;
mod colour;
mod grid;
mod luminance;
mod parts;
mod reduce;
mod rotate;
mod samples;
mod white;

pub(crate) use block_rows::{BlockRow, block_fractions, samples_of};
pub use codes::{decode, decode_channels};
pub use colour::apply_matrix;
pub use grid::{CellCentres, Grid};
pub use luminance::{LUMINANCE, LUMINANCE_F32, luminance, luminance_f32};
pub use parts::{MOST_PARTS, Part};
pub use reduce::{WorkingMap, reduce};
pub use rotate::rotate;
pub use samples::{Unusable, unusable};
pub(crate) use samples::{check_rgb, check_samples};
pub use white::{CODES, code_histogram, white_of};
