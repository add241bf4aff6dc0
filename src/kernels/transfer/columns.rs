//! The basis: linear combinations of the images, over a subset of their texels.

use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayView3, Axis, s};
use rayon::prelude::*;

use super::texels;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::sphere::check_lengths;

/// Texels in one task: for a few hundred images their rows fit in the second-level cache.
const SPAN: usize = 512;

/// Linear combinations of the rows of `images` in the texels that are `non_black`:
///
/// ```text
///   B[t, r] = sum over i and c of  scale[i] images[i, t, c] weights[3 i + c, r]
/// ```
///
/// # Inputs
///
/// - `images`: (k, texels, 3).
/// - `scale`: (k,).
/// - `non_black`: (texels,).
/// - `weights`: (3 k, rank).
///
/// # Returns
///
/// (texels that are not black, rank).
///
/// # Errors
///
/// [`crate::error::Error::WrongShape`], [`crate::error::Error::LengthMismatch`].
pub fn columns(
    images: ArrayView3<'_, f32>,
    scale: &[f32],
    non_black: &[bool],
    weights: ArrayView2<'_, f32>,
) -> Result<Array2<f32>> {
    texels::check(images, scale)?;
    let (width, rank) = weights.dim();
    check_lengths("images have texels", images.dim().1, [("non_black", non_black.len())])?;
    check_lengths("images have channels in all", 3 * scale.len(), [("weights", width)])?;
    // Assign to each task the rows of the basis that its texels fill.
    let counts =
        non_black.chunks(SPAN).map(|non_black| non_black.iter().filter(|&&non_black| non_black).count());
    let mut out = Array2::zeros((counts.clone().sum(), rank));
    let mut parts = Vec::new();
    let mut rest = out.view_mut();
    for count in counts {
        let (part, others) = rest.split_at(Axis(0), count);
        parts.push(part);
        rest = others;
    }
    // Combine the texels of each task that are not black.
    parts.into_par_iter().zip(non_black.par_chunks(SPAN)).enumerate().for_each_init(
        || Array2::zeros((SPAN, width)),
        |block, (span, (mut out, non_black))| {
            interrupt::check();
            let rows = &mut block.as_slice_mut().unwrap_or_default()[..width * non_black.len()];
            texels::fill(rows, images, scale, SPAN * span);
            compact(rows, width, non_black);
            general_mat_mul(1.0, &block.slice(s![..out.nrows(), ..]), &weights, 0.0, &mut out);
        },
    );
    Ok(out)
}

/// Move the rows that are not black to the front.
fn compact(block: &mut [f32], width: usize, non_black: &[bool]) {
    for (to, from) in (0..non_black.len()).filter(|&from| non_black[from]).enumerate() {
        if to < from {
            block.copy_within(width * from..width * (from + 1), width * to);
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::{Array3, arr2};

    use super::*;

    /// A weight of 1 selects one row; black texels are left out.
    #[test]
    fn a_weight_of_1_selects_a_row() {
        let whole = Array3::from_shape_fn((5, 2 * SPAN + 6, 4), |(k, t, c)| (100 * t + 10 * k + c) as f32);
        let images = whole.slice(s![.., ..;2, ..3]);
        let non_black: Vec<bool> = (0..SPAN + 3).map(|t| t % 3 != 1).collect();
        let scale = [1.0, 2.0, 1.0, 1.0, 0.5];
        let mut weights = Array2::zeros((15, 2));
        weights[[3 + 2, 0]] = 1.0;
        weights[[12, 1]] = 1.0;
        let result = columns(images, &scale, &non_black, weights.view()).expect("they fit");
        let expected = (0..non_black.len()).filter(|&t| non_black[t]);
        assert_eq!(result.nrows(), expected.clone().count());
        for (row, t) in result.outer_iter().zip(expected) {
            assert_eq!(row, arr2(&[[2.0 * images[[1, t, 2]], 0.5 * images[[4, t, 0]]]]).row(0));
        }
    }

    #[test]
    fn wrong_lengths_are_refused() {
        let images = Array3::zeros((1, 2, 3));
        let weights = Array2::zeros((3, 1));
        assert!(columns(images.view(), &[1.0], &[true; 2], weights.view()).is_ok());
        let refusal = |scale: &[f32], non_black: &[bool], width| {
            let weights = Array2::zeros((width, 1));
            columns(images.view(), scale, non_black, weights.view()).map_err(|error| error.to_string())
        };
        let expected = "non_black must have as many rows as images have texels (2); got 3";
        assert_eq!(refusal(&[1.0], &[true; 3], 3), Err(expected.to_owned()));
        let expected = "weights must have as many rows as images have channels in all (3); got 2";
        assert_eq!(refusal(&[1.0], &[true; 2], 2), Err(expected.to_owned()));
        let expected = "scale must have as many rows as images (1); got 2";
        assert_eq!(refusal(&[1.0; 2], &[true; 2], 3), Err(expected.to_owned()));
    }
}
