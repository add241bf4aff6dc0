//! The values of all images in a texel, one beside the other: red, green and blue of the first image,
//! then of the next. Nothing is sorted by channel.

use std::array::from_fn;

use ndarray::{ArrayView3, s};

use crate::error::{Error, Result};

/// Images whose values move together, twelve floats at a time. Of 1, 2, 4 and 8, 4 is fastest.
const IMAGES: usize = 4;

/// Refuse images of another shape than (k, texels, 3), or another number of scales than of images.
pub fn check(images: ArrayView3<'_, f32>, scale: &[f32]) -> Result<()> {
    let (wanted, _, channels) = images.dim();
    if channels != 3 {
        let shape = images.shape().to_vec();
        return Err(Error::WrongShape { what: "images", wanted: "(k, texels, 3)", shape });
    }
    if scale.len() != wanted {
        return Err(Error::LengthMismatch { what: "scale", other: "images", wanted, seen: scale.len() });
    }
    Ok(())
}

/// Fill `rows` (texels, 3 k), scaled, from the texels of `images` (k, texels, 3) that begin at `first`.
pub fn fill(rows: &mut [f32], images: ArrayView3<'_, f32>, scale: &[f32], first: usize) {
    let (fours, others) = scale.as_chunks::<IMAGES>();
    for (i, &scale) in fours.iter().enumerate() {
        fill_from(rows, images, IMAGES * i, scale, first);
    }
    for (i, &scale) in others.iter().enumerate() {
        fill_from(rows, images, IMAGES * fours.len() + i, [scale], first);
    }
}

/// Fill what comes from `N` images, `image` and those behind it.
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
    // Copy what does not lie in RGB, as where alpha was dropped.
    let parts: [_; N] = from_fn(|i| parts[i].as_standard_layout());
    let parts: [&[[f32; 3]]; N] = from_fn(|i| parts[i].as_slice().unwrap_or_default().as_chunks().0);
    // Write the values of all images for one texel next to each other.
    for (t, row) in rows.chunks_exact_mut(width).enumerate() {
        let values: [[f32; 3]; N] = from_fn(|i| parts[i][t].map(|value| value * scale[i]));
        row[3 * image..3 * (image + N)].copy_from_slice(values.as_flattened());
    }
}
