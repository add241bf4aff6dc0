//! Step 4 of Loghin (2021): the pixels in which samples lie.

use ndarray::{Array2, ArrayView2};

use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::check_rows;

/// Shift of all points in pixels. Without it, rounding decides about Hammersley points, which lie on borders of pixels.
const BORDER: f64 = 1e-9;

/// Row and column, (n, 2), of the image coordinates `uv`, (n, 2), in an image of `height` x `width` pixels.
/// Coordinates beyond the image count as its outer pixels.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::NotFinite`].
pub fn uv_to_pixel(uv: ArrayView2<'_, f64>, height: usize, width: usize) -> Result<Array2<i64>> {
    check_rows("uv", uv, 2)?;
    let place =
        |along: f64, size: usize| (along * size as f64 + BORDER).floor().clamp(0.0, size as f64 - 1.0);
    let pixel = |(row, axis): (usize, usize)| {
        interrupt::check();
        match axis {
            0 => place(uv[[row, 1]], height) as i64,
            _ => place(uv[[row, 0]], width) as i64,
        }
    };
    Ok(Array2::from_shape_fn(uv.dim(), pixel))
}
