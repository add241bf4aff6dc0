//! The windows around samples, plane or on the sphere.

use std::ops::Range;

use crate::kernels::sphere::Pixel;

/// The windows around the pixels of an image.
pub struct Windows {
    height: usize,
    width: usize,
    /// Rows on either side of the centre.
    pub reach: usize,
    /// For each row, the columns on either side of the centre.
    pub reach_in_row: Vec<usize>,
    pub sphere: bool,
}

impl Windows {
    /// Windows of `reach` rows on either side, and as many columns; on a `sphere`, of an angle that is the same
    /// everywhere.
    pub fn new((height, width): (usize, usize), reach: usize, sphere: bool) -> Self {
        let sine = |row: usize| ((row as f64 + 0.5) / height as f64 * std::f64::consts::PI).sin();
        let columns = |row: usize| if sphere { (reach as f64 / sine(row)) as usize } else { reach };
        let reach_in_row = (0..height).map(|row| columns(row).min(width)).collect();
        Self { height, width, reach: reach.min(height), reach_in_row, sphere }
    }

    /// Approximate number of pixels of a window in the middle of the image.
    pub fn area(&self) -> usize {
        let side = |reach: usize, size: usize| (2 * reach + 1).min(size);
        side(self.reach, self.height) * side(self.reach_in_row[self.height / 2], self.width)
    }

    /// The rows of the window around a pixel.
    pub fn rows(&self, [row, _]: Pixel) -> Range<usize> {
        row.saturating_sub(self.reach)..(row + self.reach + 1).min(self.height)
    }

    /// The columns in `row` of the window around a pixel: one range, or two across the seam of a sphere.
    pub fn columns(&self, row: usize, [_, column]: Pixel) -> [Range<usize>; 2] {
        let (reach, width) = (self.reach_in_row[row], self.width);
        let (left, right) = (column.saturating_sub(reach), (column + reach + 1).min(width));
        if !self.sphere {
            return [left..right, 0..0];
        }
        if 2 * reach >= width {
            return [0..width, 0..0];
        }
        if column < reach {
            return [column + width - reach..width, 0..right];
        }
        [left..right, 0..(column + reach + 1).saturating_sub(width)]
    }
}
