//! The lights of a map as they were found.

use ndarray::{ArrayView1, ArrayView2};

use crate::error::{Error, Result};
use crate::kernels::image::luminance_f32;
use crate::kernels::sphere;

/// The lights that are to be taken, as they were found in a map.
pub struct Found<'a> {
    /// Row and column, (k, 2), of each light's pixels in the working image.
    pub pixels: ArrayView2<'a, i64>,
    /// The light of each of them, (k,). Those from the number of `directions` on stay in the map.
    pub light_of_pixel: ArrayView1<'a, i64>,
    /// A unit vector towards each light that is taken, (n, 3).
    pub directions: ArrayView2<'a, f64>,
    /// Pixels of the map along each side of a pixel of the working image.
    pub block: usize,
    /// Luminance above which a place is bright.
    pub threshold: f64,
}

impl Found<'_> {
    /// Flat indices of the pixels of lights in a working image of this size, each with its light.
    ///
    /// # Errors
    ///
    /// [`Error::OutsideImage`], [`Error::LengthMismatch`].
    pub fn members(&self, (height, width): (usize, usize)) -> Result<Vec<(usize, usize)>> {
        let lengths = [("light_of_pixel", self.light_of_pixel.len())];
        sphere::check_lengths("pixels", self.pixels.nrows(), lengths)?;
        let mut members = Vec::with_capacity(self.pixels.nrows());
        for (index, (place, &light)) in self.pixels.rows().into_iter().zip(self.light_of_pixel).enumerate() {
            let (row, column) = (place[0], place[1]);
            if !(0..height as i64).contains(&row) || !(0..width as i64).contains(&column) || light < 0 {
                return Err(Error::OutsideImage { index, row, column, height, width });
            }
            members.push((row as usize * width + column as usize, light as usize));
        }
        Ok(members)
    }

    /// Largest luminance of the map's own pixels behind those of each light that is taken, 0 for a light without pixels:
    /// that of its peak, if it was found in this map.
    pub fn peaks(
        &self,
        map: &[[f32; 3]],
        (height, width): (usize, usize),
        members: &[(usize, usize)],
    ) -> Vec<f32> {
        let block = self.block.max(1);
        let columns = width.div_ceil(block);
        let mut peaks = vec![0.0_f32; self.directions.nrows()];
        for &(pixel, light) in members {
            let Some(peak) = peaks.get_mut(light) else { continue };
            let (first, column) = (pixel / columns * block, pixel % columns * block);
            for row in first..(first + block).min(height) {
                let pixels = &map[row * width + column..row * width + (column + block).min(width)];
                *peak = pixels.iter().copied().map(luminance_f32).fold(*peak, f32::max);
            }
        }
        peaks
    }
}
