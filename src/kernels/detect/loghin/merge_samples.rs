//! Step 8 of Loghin (2021): the samples that a bright line joins.

use ndarray::ArrayView2;

use super::bresenham::{LineRule, is_bright};
use super::image::{Image, points_in_space};
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::{check_lengths, pixels_inside};

/// For each of `pixels`, (n, 2), brightest first, the one that it is merged into.
///
/// This is the brightest one that a bright line joins to it, or itself. Only samples whose `points`, (n, 2) or (n, 3),
/// are at most `rule.farthest` apart are merged.
///
/// Every light tries every sample that is still open, so the work grows with the square of their number. But a line
/// ends at its first dark step, and suppression leaves few samples: 1300 at the defaults.
///
/// # Errors
///
/// [`crate::error::Error::EmptyImage`], [`crate::error::Error::BadPixel`], [`crate::error::Error::WrongColumns`],
/// [`crate::error::Error::OutsideImage`], [`crate::error::Error::LengthMismatch`],
/// [`crate::error::Error::NotFinite`].
pub fn merge(
    luminance: ArrayView2<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    points: ArrayView2<'_, f64>,
    rule: &LineRule,
) -> Result<Vec<usize>> {
    let samples = luminance.as_standard_layout();
    let image = Image::new("luminance", samples.view())?;
    let pixels = pixels_inside(pixels, luminance.dim())?;
    let points = points_in_space(points)?;
    check_lengths("pixels", pixels.len(), [("points", points.len())])?;
    // Take the brightest sample that is still open, and merge all that a bright line joins to it.
    let mut light: Vec<usize> = (0..pixels.len()).collect();
    let mut open = light.clone();
    while let Some(&start) = open.first() {
        open.retain(|&end| {
            interrupt::check();
            let is_near = points[start].distance_squared(points[end]) <= rule.farthest * rule.farthest;
            let joined = end == start || (is_near && is_bright(&image, pixels[start], pixels[end], rule));
            if joined {
                light[end] = start;
            }
            !joined
        });
    }
    Ok(light)
}
