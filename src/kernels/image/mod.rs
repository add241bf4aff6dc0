//! Preparation of a map: samples, reduction, resampling.
//!
//! | step                                          | file           |
//! |-----------------------------------------------|----------------|
//! | decoding of integers and half floats          | `codes.rs`     |
//! | conversion of colours to linear Rec.709       | `colour.rs`    |
//! | unusable samples                              | `samples.rs`   |
//! | - replaced by those of their neighbours       | `clean.rs`     |
//! | clip level of a picture of codes              | `white.rs`     |
//! | the cells of an image on the sphere           | `grid.rs`      |
//! | luminance                                     | `luminance.rs` |
//! | a smaller working map, bright cells as points | `reduce.rs`    |
//! | - integrals over its cells                    | `cell_flux.rs` |
//! | - bright cells in parts                       | `parts.rs`     |
//! | - from rows that arrive in order              | `row_reducer/`   |
//! | - buffers of decoded rows                     | `buffers.rs`   |
//! | - samples in the type of a file               | `sample_types.rs` |
//! | - pixels of the largest codes                 | `top_codes.rs` |
//! | - means over blocks, for a glance at a picture | `overview.rs` |
//! | means over blocks of pixels                   | `block_rows.rs`, `block_layout.rs` |
//! | - share of each block that a map shows        | `seen_part.rs` |
//! | means of a plane image over equal areas       | `area_means.rs` |
//! | a picture in another layout, or rotated       | `resample.rs`  |
//! | - bright pixels, each with its flux           | `splat.rs`     |

mod area_means;
mod block_layout;
mod block_rows;
mod buffers;
mod cell_flux;
mod clean;
mod codes;
mod colour;
mod grid;
mod luminance;
mod overview;
mod parts;
mod reduce;
mod resample;
mod row_reducer;
mod sample_types;
mod samples;
mod seen_part;
mod splat;
mod top_codes;
mod white;

pub use area_means::area_means;
pub(crate) use block_layout::BlockLayout;
pub(crate) use block_rows::{BlockRow, block_fractions, samples_of};
pub use clean::Cleaning;
pub use codes::{decode, widen};
pub use colour::apply_matrix;
pub use grid::{CellCentres, Grid};
pub use luminance::{LUMINANCE, LUMINANCE_F32, luminance, luminance_f32};
pub use overview::overview;
pub use parts::{MOST_PARTS, Part};
pub use reduce::{WorkingMap, reduce};
pub use resample::{SourcePicture, resample};
pub use row_reducer::{ReducedRows, ReductionOptions, RowReducer, RowReduction};
pub use sample_types::Sample;
pub use samples::{Unusable, unusable};
pub(crate) use samples::{check_rgb, check_samples};
pub use seen_part::SeenPart;
pub use white::{CODES, LEAST_WHITE, code_histogram, white_of};
