//! The lights of a map as they were found.

use ndarray::{ArrayView1, ArrayView2};

use crate::error::{Error, Result};
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
}
