//! Tiny maps drawn by hand, for tests.

use ndarray::Array3;

use super::Options;
use super::components::{self, Regions};
use super::summary::{Summary, summarise};
use super::threshold::{Reason, Threshold};
use super::touch::Sheet;
use crate::kernels::sphere::Registration;

/// What is bright in a drawing: more than 0.5, and a light reaches 1.25.
pub const THRESHOLD: Threshold = Threshold { luminance: 0.5, reason: Reason::Background };

/// A digit is its luminance, a dot 0.1.
pub fn drawn(rows: &[&str]) -> Summary {
    let luminance = |c: u8| if c == b'.' { 0.1 } else { f32::from(c - b'0') };
    let (height, width) = (rows.len(), rows[0].len());
    let map = Array3::from_shape_fn((height, width, 3), |(y, x, _)| luminance(rows[y].as_bytes()[x]));
    #[allow(clippy::unwrap_used, reason = "a drawing is a map")]
    summarise(map.view(), Registration::CellCentred, width).unwrap()
}

/// `rows` of a drawing between dark ones: 8 rows of 16 pixels, the first in row `top`.
pub fn drawn_from(top: usize, rows: &[&str]) -> Summary {
    let dark = ".".repeat(16);
    let mut all = vec![dark.as_str(); 8];
    all[top..top + rows.len()].copy_from_slice(rows);
    drawn(&all)
}

/// The lights of a drawing, before gaps are bridged.
pub fn regions(summary: &Summary, extent: f64) -> Regions {
    let options = Options {
        working_columns: 1024,
        prominence: 4.0,
        extent,
        gap: 0.0,
        min_flux_share: 0.0,
        max_lights: usize::MAX,
    };
    let bright = components::bright_pixels(summary, THRESHOLD.luminance);
    components::regions(summary, &Sheet::of(summary), &bright, &THRESHOLD, &options)
}

/// How many pixels each light has, the smallest first.
pub fn sizes(regions: &Regions) -> Vec<usize> {
    let mut sizes: Vec<usize> = regions.pixels.iter().map(Vec::len).collect();
    sizes.sort_unstable();
    sizes
}
