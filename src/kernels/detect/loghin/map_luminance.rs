//! Step 2 of Loghin (2021): the luminance of a map.

use ndarray::{Array2, ArrayView3};
use rayon::prelude::*;

use super::image::Image;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::image::{check_rgb, luminance_f32};

/// Rec.709 luminance, (height, width), of linear RGB, (height, width, 3).
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`]; [`crate::error::Error::BadPixel`] for a luminance that is not finite.
pub fn luminance(radiance: ArrayView3<'_, f32>) -> Result<Array2<f32>> {
    check_rgb(radiance)?;
    let mut out = Array2::zeros((radiance.dim().0, radiance.dim().1));
    out.outer_iter_mut().into_par_iter().zip(radiance.outer_iter().into_par_iter()).for_each(
        |(mut out, row)| {
            interrupt::check();
            let row = row.as_standard_layout();
            let pixels = row.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0);
            for (out, &pixel) in out.iter_mut().zip(pixels) {
                *out = luminance_f32(pixel);
            }
        },
    );
    Image::new("the luminance of radiance", out.view())?;
    Ok(out)
}
