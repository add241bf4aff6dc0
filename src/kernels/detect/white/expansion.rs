//! Expanded luminance: what is close to white stands for much more.
//!
//! The curve of Schlick (1994), backwards, with y the share of the end of the picture:
//!
//! ```text
//!   y' = y / (1 + e - y)        e = 0.02:  y' = 50 at white, y in the dark
//!   y  = (1 + e) y' / (1 + y')
//! ```

use ndarray::ArrayView3;
use rayon::prelude::*;

use super::super::tree::working_image::WorkingImage;
use crate::kernels::image::{luminance_f32, samples_of};
use crate::kernels::sphere::{Registration, band_heights};

/// White becomes one over this.
const DISTANCE: f32 = 0.02;
/// The threshold is at most the expansion of this share of the end.
const HIGHEST_THRESHOLD: f32 = 0.97;
/// A sphere with more than this share at white has no light that stands out.
const MOSTLY_WHITE: f64 = 0.5;

/// The working image in expanded luminance; `end` becomes 50.
///
/// Each pixel of the map is expanded before blocks are averaged: a lamp that is smaller than a block stays as
/// bright as its share of the block.
pub fn expanded(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    working: &WorkingImage,
    end: f64,
) -> WorkingImage {
    let (height, width, _) = radiance.dim();
    let block = working.block;
    let bands = band_heights(&registration.theta_edges(height));
    let per_end = (1.0 / end) as f32;
    let mut luminance = vec![0.0; working.luminance.len()];
    luminance.par_chunks_mut(working.size.1).enumerate().for_each(|(row, out)| {
        let rows = row * block..((row + 1) * block).min(height);
        let height: f64 = bands[rows.clone()].iter().sum();
        let samples = samples_of(radiance, rows.clone());
        // Average down the columns, then across each block.
        let mut mean = vec![0.0; width];
        for (samples, band) in samples.chunks_exact(3 * width).zip(&bands[rows]) {
            add_expanded(&mut mean, samples.as_chunks::<3>().0, (band / height) as f32, per_end);
        }
        for (out, mean) in out.iter_mut().zip(mean.chunks(block)) {
            *out = mean.iter().sum::<f32>() / mean.len() as f32;
        }
    });
    working.with_luminance(luminance)
}

/// Add the expanded luminance of a row of pixels, times `weight`.
fn add_expanded(mean: &mut [f32], pixels: &[[f32; 3]], weight: f32, per_end: f32) {
    for (mean, &pixel) in mean.iter_mut().zip(pixels) {
        *mean += weight * expand(luminance_f32(pixel) * per_end);
    }
}

/// The expansion of a share of the end.
#[inline]
pub fn expand(share: f32) -> f32 {
    let share = if share < 1.0 { share } else { 1.0 };
    share / (1.0 + DISTANCE - share)
}

/// The threshold, but below white where most of the sphere is: a light at white must be able to exceed it.
pub fn below_white(threshold: f64, share_at_white: f64) -> f64 {
    let highest = f64::from(expand(HIGHEST_THRESHOLD));
    if share_at_white < MOSTLY_WHITE { threshold.min(highest) } else { threshold }
}

/// The luminance that became `expanded`.
pub fn compressed(expanded: f64, end: f64) -> f64 {
    end * (1.0 + f64::from(DISTANCE)) * expanded / (1.0 + expanded)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::Array3;

    use super::*;

    #[test]
    fn white_becomes_fifty_and_compression_undoes_expansion() {
        assert_relative_eq!(expand(1.0), 50.0, max_relative = 1e-4);
        assert_relative_eq!(expand(7.0), 50.0, max_relative = 1e-4);
        for share in [0.0_f32, 0.01, 0.3, 0.9, 0.99, 1.0] {
            let back = compressed(f64::from(expand(share)), 3.0);
            assert_relative_eq!(back, 3.0 * f64::from(share), max_relative = 1e-4, epsilon = 1e-9);
        }
    }

    #[test]
    fn a_lamp_in_a_quarter_of_a_block_keeps_a_quarter_of_white() {
        let mut map = Array3::zeros((8, 16, 3));
        map.slice_mut(ndarray::s![4, 6, ..]).fill(2.0);
        let working = WorkingImage::of(map.view(), Registration::CellCentred, 8).unwrap();
        let image = expanded(map.view(), Registration::CellCentred, &working, 2.0);
        // Rows 4 and 5 are not of the same height.
        let bands = band_heights(&Registration::CellCentred.theta_edges(8));
        let wanted = 50.0 * bands[4] / (bands[4] + bands[5]) / 2.0;
        assert_relative_eq!(f64::from(image.luminance[2 * 8 + 3]), wanted, max_relative = 1e-4);
    }

    #[test]
    fn the_threshold_stays_below_white_but_on_an_even_sphere() {
        assert!(below_white(100.0, 0.3) < f64::from(expand(1.0)));
        assert_relative_eq!(below_white(100.0, 0.8), 100.0);
        assert_relative_eq!(below_white(2.0, 0.3), 2.0);
    }
}
