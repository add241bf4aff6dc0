//! Segmentation of bright pixels into lights, and their measurement; [`super::detect`] has the order of the steps.
//!
//! | step                                               | file                     |
//! |----------------------------------------------------|--------------------------|
//! | reduced luminance of the map                       | `working_image.rs`       |
//! | threshold above which a pixel is bright            | `threshold.rs`           |
//! | pixels above it                                    | `bright_pixels.rs`       |
//! | neighbours on the sphere, runs of pixels in a row  | `adjacency.rs`, `run.rs` |
//! | component tree                                     | `components.rs`          |
//! | - union-find                                       | `forest.rs`              |
//! | joining across narrow gaps                         | `bridging.rs`            |
//! | outlines                                           | `outline.rs`             |
//! | local backgrounds                                  | `background.rs`          |
//! | measurement                                        | `measure.rs`             |
//! | - sums over the pixels of a light                  | `light_moments.rs`       |
//! | - dot products in wide vectors                     | `dot_product.rs`         |
//! | window bars                                        | `bars.rs`                |
//! | merging of neighbours (Ward's linkage)             | `merge.rs`               |

pub mod adjacency;
pub mod background;
pub mod bars;
pub mod bridging;
pub mod bright_pixels;
pub mod components;
pub mod dot_product;
mod forest;
pub mod light_moments;
pub mod measure;
pub mod merge;
pub mod outline;
pub mod run;
#[cfg(test)]
pub(super) mod test_maps;
pub mod threshold;
pub mod working_image;
