//! The separate steps of Loghin (2021), on a luminance image, plane or equirectangular.
//! `envlights.detect_article` applies them to a map.
//!
//! | step                                          | file            |
//! |-----------------------------------------------|-----------------|
//! | 1: a smaller image                            | `resize.rs`     |
//! | 2: its luminance                              | `map_luminance.rs` |
//! | 2: optionally, a blur                         | `blur.rs`       |
//! | 4: the pixels in which samples lie            | `uv_pixels.rs`  |
//! | 5: the brightest pixel around a sample        | `neighbours.rs` |
//! | 7: samples near a brighter one                | `suppress.rs`   |
//! | 8: the line between two samples               | `bresenham.rs`  |
//! | 8: the samples that a bright line joins       | `merge_samples.rs` |
//! | 9: the weighted mean of each light            | `means.rs`      |
//! | - the lights that a camera has clipped        | `window_clipping.rs` |
//! | - the maximum of a window along a line        | `running.rs`    |
//! | - the windows around samples                  | `windows.rs`    |
//! | - the arguments of all steps                  | `image.rs`      |
//!
//! Step 3 is `kernels::sampling`, step 6 a sort.

pub mod blur;
pub mod bresenham;
pub mod map_luminance;
pub mod means;
pub mod merge_samples;
pub mod neighbours;
pub mod resize;
pub mod suppress;
pub mod uv_pixels;
pub mod window_clipping;

mod image;
mod running;
mod windows;
