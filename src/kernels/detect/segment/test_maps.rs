//! Tiny maps drawn by hand, for tests.

use ndarray::Array3;

use super::adjacency::Adjacency;
use super::bright_pixels::bright_pixels;
use super::components::{self, Segments, TreeRule};
use super::threshold::{Rule, Threshold};
use super::working_image::WorkingImage;
use crate::kernels::sphere::Registration;

/// Pixels of a test map are bright above 0.5, and a light reaches 1.25.
pub const THRESHOLD: Threshold = Threshold { luminance: 0.5, rule: Rule::Background };

/// A map from its drawing: a digit is its luminance, a dot 0.1.
pub fn map_of(rows: &[&str]) -> Array3<f32> {
    let luminance = |c: u8| if c == b'.' { 0.1 } else { f32::from(c - b'0') };
    let (height, width) = (rows.len(), rows[0].len());
    Array3::from_shape_fn((height, width, 3), |(y, x, _)| luminance(rows[y].as_bytes()[x]))
}

/// The working image of a drawing, pixel by pixel.
pub fn working_image_of(rows: &[&str]) -> WorkingImage {
    #[allow(clippy::unwrap_used, reason = "a drawing is a valid map")]
    WorkingImage::of(map_of(rows).view(), Registration::CellCentred, rows[0].len()).unwrap()
}

/// `rows` of a drawing between dark ones: 8 rows of 16 pixels, the first in row `top`.
pub fn rows_from(top: usize, rows: &[&str]) -> WorkingImage {
    let dark = ".".repeat(16);
    let mut all = vec![dark.as_str(); 8];
    all[top..top + rows.len()].copy_from_slice(rows);
    working_image_of(&all)
}

/// The segments of a test map, before gaps are bridged.
pub fn segments(working: &WorkingImage, extent: f64) -> Segments {
    let bright = bright_pixels(working, THRESHOLD.luminance);
    let rule = TreeRule { rise: 2.5, prominence: 4.0, extent };
    components::segments(working, &Adjacency::of(working), &bright.indices, &THRESHOLD, &rule)
}

/// Number of pixels of each light, the smallest first.
pub fn sizes(segments: &Segments) -> Vec<usize> {
    let mut sizes: Vec<usize> = segments.pixels.iter().map(Vec::len).collect();
    sizes.sort_unstable();
    sizes
}
