//! The lights of a map as they were found.

use ndarray::{ArrayView1, ArrayView2, ArrayView3, s};

use super::glow::Bright;
use crate::error::{Error, Result};
use crate::kernels::image::{check_rgb, luminance_f32};
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
    /// Luminance at which the map was cut off.
    pub end: Option<f64>,
    /// Luminance of the working image, row after row, where it is known.
    pub luminance: Option<&'a [f32]>,
}

impl Found<'_> {
    /// What counts as bright.
    pub fn bright(&self) -> Bright {
        Bright { threshold: self.threshold as f32, end: self.end.map(|end| end as f32) }
    }

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
    ///
    /// # Errors
    ///
    /// [`Error::NotAMap`], [`Error::OutsideImage`], [`Error::LengthMismatch`].
    pub fn peaks(&self, radiance: ArrayView3<'_, f32>) -> Result<Vec<f32>> {
        check_rgb(radiance)?;
        let (height, width, _) = radiance.dim();
        let block = self.block.max(1);
        let columns = width.div_ceil(block);
        let mut peaks = vec![0.0_f32; self.directions.nrows()];
        for (pixel, light) in self.members((height.div_ceil(block), columns))? {
            let Some(peak) = peaks.get_mut(light) else { continue };
            let (row, column) = (pixel / columns * block, pixel % columns * block);
            let rows = row..(row + block).min(height);
            let pixels = radiance.slice(s![rows, column..(column + block).min(width), ..]);
            let luminances = pixels.rows().into_iter().map(|rgb| luminance_f32([rgb[0], rgb[1], rgb[2]]));
            *peak = luminances.fold(*peak, f32::max);
        }
        Ok(peaks)
    }
}
