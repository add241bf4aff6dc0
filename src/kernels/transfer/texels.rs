//! Values of all images in one texel, interleaved: red, green and blue of the first image, then of the next.

use std::array::from_fn;

use ndarray::{ArrayView3, s};

use crate::error::{Error, Result};
use crate::kernels::sphere::check_lengths;

/// Images that are copied together, twelve floats at a time: the fastest of 1, 2, 4 and 8.
const IMAGES: usize = 4;

/// Refuse images whose shape is not (k, texels, 3), or whose number differs from the number of scales.
pub fn check(images: ArrayView3<'_, f32>, scale: &[f32]) -> Result<()> {
    let (wanted, _, channels) = images.dim();
    if channels != 3 {
        let shape = images.shape().to_vec();
        return Err(Error::WrongShape { what: "images", wanted: "(k, texels, 3)", shape });
    }
    check_lengths("images", wanted, [("scale", scale.len())])
}

/// Fill `rows`, (texels, 3 k), with scaled values of `images`, (k, texels, 3), starting at texel `first`.
pub fn fill(rows: &mut [f32], images: ArrayView3<'_, f32>, scale: &[f32], first: usize) {
    let (fours, others) = scale.as_chunks::<IMAGES>();
    for (i, &scale) in fours.iter().enumerate() {
        fill_from(rows, images, IMAGES * i, scale, first);
    }
    for (i, &scale) in others.iter().enumerate() {
        fill_from(rows, images, IMAGES * fours.len() + i, [scale], first);
    }
}

/// Fill the values of `N` consecutive images, starting with number `image`.
fn fill_from<const N: usize>(
    rows: &mut [f32],
    images: ArrayView3<'_, f32>,
    image: usize,
    scale: [f32; N],
    first: usize,
) {
    let width = 3 * images.dim().0;
    let texels = first..first + rows.len() / width;
    let parts: [_; N] = from_fn(|i| images.slice_move(s![image + i, texels.clone(), ..]));
    // Copy images whose layout is not interleaved RGB, such as views without alpha.
    let parts: [_; N] = from_fn(|i| parts[i].as_standard_layout());
    let parts: [&[[f32; 3]]; N] = from_fn(|i| parts[i].as_slice().unwrap_or_default().as_chunks().0);
    // Write the values of the images in each texel.
    for (t, row) in rows.chunks_exact_mut(width).enumerate() {
        let values: [[f32; 3]; N] = from_fn(|i| parts[i][t].map(|value| value * scale[i]));
        row[3 * image..3 * (image + N)].copy_from_slice(values.as_flattened());
    }
}
