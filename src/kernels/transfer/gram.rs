//! Inner products of the images, over a subset of their texels.

use ndarray::linalg::general_mat_mul;
use ndarray::parallel::prelude::*;
use ndarray::{Array1, Array2, ArrayView2, ArrayView3, Axis, Zip, s};
use rayon::slice::ParallelSliceMut;

use super::texels;
use crate::error::Result;
use crate::interrupt;

/// Texels whose products are summed in f32 before they are added to the total in f64. The sum is then
/// accurate to 2e-8 of the largest eigenvalue.
const BLOCK: usize = 1024;
/// Rows of products that are computed together. More rows compute more entries beyond the diagonal, which
/// are not needed: 32 was the fastest of 24 to 128 for 384 rows.
const PANEL: usize = 32;

/// Inner products of the rows of `images`, and a mask of the texels that are not black in every image.
///
/// The rows of an image are its channels, times its `scale`:
///
/// ```text
///   G = Y Y^T,    Y[3 i + c, t] = scale[i] images[i, t, c]
/// ```
///
/// # Inputs
///
/// - `images`: (k, texels, 3).
/// - `scale`: (k,).
///
/// # Returns
///
/// (3 k, 3 k), with its lower triangle filled; and (texels,).
///
/// # Errors
///
/// [`crate::error::Error::WrongShape`], [`crate::error::Error::LengthMismatch`].
pub fn gram(images: ArrayView3<'_, f32>, scale: &[f32]) -> Result<(Array2<f64>, Array1<bool>)> {
    texels::check(images, scale)?;
    let width = 3 * scale.len();
    let texels = images.dim().1;
    if images.is_empty() {
        return Ok((Array2::zeros((width, width)), Array1::from_elem(texels, false)));
    }
    // Read a block of texels at a time, as rows of all images.
    let mut products = Array2::zeros((width, width));
    let mut non_black = Vec::with_capacity(texels);
    let mut block = Array2::zeros((BLOCK.min(texels), width));
    for first in (0..texels).step_by(BLOCK) {
        interrupt::check();
        let count = BLOCK.min(texels - first);
        let rows = &mut block.as_slice_mut().unwrap_or_default()[..width * count];
        let step = count.div_ceil(rayon::current_num_threads());
        rows.par_chunks_mut(width * step)
            .enumerate()
            .for_each(|(i, rows)| texels::fill(rows, images, scale, first + i * step));
        // Note which texels are not black, and add the products of the block.
        non_black.extend(rows.chunks_exact(width).map(|row| row.iter().any(|&value| value != 0.0)));
        add_products(&mut products, block.slice(s![..count, ..]));
    }
    Ok((products, non_black.into()))
}

/// Add the inner products of the columns of `block` (texels, width).
fn add_products(products: &mut Array2<f64>, block: ArrayView2<'_, f32>) {
    let width = products.ncols();
    // Start with the longest panels, so that no single thread works alone at the end.
    let panels: Vec<_> = products.axis_chunks_iter_mut(Axis(0), PANEL).enumerate().collect();
    panels.into_par_iter().rev().with_max_len(1).for_each_init(
        || Array2::zeros((PANEL, width)),
        |sums, (i, mut panel)| {
            // Multiply the rows of the panel with all up to the diagonal, in f32.
            let (first, last) = (i * PANEL, i * PANEL + panel.nrows());
            let mut sums = sums.slice_mut(s![..last - first, ..last]);
            let (ours, all) = (block.slice(s![.., first..last]), block.slice(s![.., ..last]));
            general_mat_mul(1.0, &ours.t(), &all, 0.0, &mut sums);
            // Add the products in f64.
            Zip::from(panel.slice_mut(s![.., ..last]))
                .and(&sums)
                .for_each(|total, &sum| *total += f64::from(sum));
        },
    );
}

#[cfg(test)]
mod tests {
    use ndarray::Array3;

    use super::*;

    /// Gram matrix and mask over several blocks and panels, the last ones partial; the second image has scale 0.
    #[test]
    fn products_are_the_sums_over_all_texels() {
        let scale: Vec<f32> = (0..13).map(|k| if k == 1 { 0.0 } else { 1.0 / (k + 1) as f32 }).collect();
        let mut images =
            Array3::from_shape_fn((13, 2 * BLOCK + 7, 3), |(k, t, c)| ((31 * k + 7 * t + 5 * c) % 11) as f32);
        images.slice_mut(s![.., BLOCK + 3, ..]).fill(0.0);
        images.slice_mut(s![.., 5, ..]).fill(0.0);
        images[[1, 5, 2]] = 1.0;
        let (products, non_black) = gram(images.view(), &scale).expect("they fit");
        for (a, b) in (0..39).flat_map(|a| (0..=a).map(move |b| (a, b))) {
            let [one, two] = [a, b].map(|row| (row / 3, row % 3));
            let sum: f64 = (0..images.dim().1)
                .map(|t| f64::from(images[[one.0, t, one.1]]) * f64::from(images[[two.0, t, two.1]]))
                .sum();
            let expected = sum * f64::from(scale[one.0]) * f64::from(scale[two.0]);
            // Rounding of f32 over one block.
            approx::assert_relative_eq!(products[[a, b]], expected, max_relative = 1e-5);
        }
        let black: Vec<usize> = (0..non_black.len()).filter(|&t| !non_black[t]).collect();
        assert_eq!(black, [5, BLOCK + 3]);
    }

    #[test]
    fn wrong_shapes_are_refused_and_no_images_have_no_products() {
        let images = Array3::zeros((2, 5, 3));
        assert!(gram(images.view(), &[1.0; 3]).is_err());
        assert!(gram(images.slice(s![.., .., ..2]), &[1.0; 2]).is_err());
        let (products, non_black) = gram(images.slice(s![..0, .., ..]), &[]).expect("they fit");
        assert_eq!((products.dim(), non_black.to_vec()), ((0, 0), vec![false; 5]));
    }
}
