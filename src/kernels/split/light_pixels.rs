//! Pixels of the lights that were detected in a map.

use ndarray::{ArrayView1, ArrayView2};

/// Number of no light: lights are counted from 1.
pub const NO_LIGHT: u32 = 0;

/// Pixels of detected lights in the image in which they were detected, a map averaged over square blocks.
pub struct LightPixels<'a> {
    /// Row and column of each pixel, (k, 2).
    pub pixels: ArrayView2<'a, i64>,
    /// Index of the light of each pixel, (k,). Lights without a direction stay in the map.
    pub light_of_pixel: ArrayView1<'a, i64>,
    /// A unit vector towards each light to remove, (n, 3).
    pub directions: ArrayView2<'a, f64>,
    /// Pixels of the map along each side of a block.
    pub block: usize,
    /// Luminance above which detection regards a pixel as bright.
    pub threshold: f64,
    /// Mean luminance of each block, row after row.
    pub luminance: &'a [f32],
}
