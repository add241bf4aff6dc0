//! The images, pixels and points that the steps of Loghin (2021) work on.

use glam::DVec3;
use ndarray::{ArrayView1, ArrayView2};

use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::{Pixel, check_rows};

/// A gray image whose pixels are finite, row after row.
pub struct Image<'a> {
    pub height: usize,
    pub width: usize,
    samples: &'a [f32],
}

impl<'a> Image<'a> {
    /// The image that the argument `what` holds, in standard layout.
    pub fn new(what: &'static str, image: ArrayView2<'a, f32>) -> Result<Self> {
        let (height, width) = image.dim();
        if height == 0 || width == 0 {
            return Err(Error::EmptyImage { height, width });
        }
        let samples = image.to_slice().unwrap_or(&[]);
        for (row, samples) in samples.chunks(width).enumerate() {
            interrupt::check();
            // Test all of a row: without an early exit, the loop tests eight pixels at a time.
            if !samples.iter().fold(true, |all, value| all & value.is_finite()) {
                let column = samples.iter().position(|value| !value.is_finite()).unwrap_or(0);
                return Err(Error::BadPixel { what, row, column, value: samples[column] });
            }
        }
        Ok(Self { height, width, samples })
    }

    pub fn row(&self, row: usize) -> &'a [f32] {
        &self.samples[row * self.width..][..self.width]
    }

    pub fn at(&self, [row, column]: Pixel) -> f32 {
        self.samples[row * self.width + column]
    }
}

/// `points`, (n, 2) or (n, 3), in space; those of a plane at height 0.
pub fn points_in_space(points: ArrayView2<'_, f64>) -> Result<Vec<DVec3>> {
    let columns = if points.ncols() == 3 { 3 } else { 2 };
    check_rows("points", points, columns)?;
    let height = |row: ArrayView1<'_, f64>| if columns == 3 { row[2] } else { 0.0 };
    Ok(points.rows().into_iter().map(|row| DVec3::new(row[0], row[1], height(row))).collect())
}
