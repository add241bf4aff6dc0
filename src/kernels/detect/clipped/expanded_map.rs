//! Reduction of a map to fewer pixels: means of luminance and of expanded luminance, in one pass over the samples.
//!
//! Each pixel of the map is expanded before blocks are averaged: a lamp smaller than a block counts by the fraction of
//! the block that it covers.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use ndarray::{ArrayView2, ArrayView3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::super::segment::working_image::WorkingImage;
use super::expansion::expand;
use crate::error::Result;
use crate::kernels::image::{BlockLayout, BlockRow, block_fractions, luminance_f32};
use crate::kernels::sphere::Registration;

/// Map reduced to fewer pixels, each the mean of a block.
pub struct ExpandedMap {
    /// Mean luminance of each block.
    pub working: WorkingImage,
    /// Mean expanded luminance of each block; the clip level is expanded to 50.
    pub expanded: WorkingImage,
    /// Largest luminance of a pixel before the reduction.
    pub maximum: f64,
}

impl ExpandedMap {
    /// Reduce `radiance` with the clip level `clip_level` to at most `columns` columns.
    ///
    /// # Errors
    ///
    /// Errors of [`WorkingImage::of`].
    pub fn of(
        radiance: ArrayView3<'_, f32>,
        registration: Registration,
        columns: usize,
        clip_level: f64,
    ) -> Result<Self> {
        // Cut the map into blocks, one for each working pixel.
        let BlockLayout { pixels, grid, block } = BlockLayout::of_map(radiance, registration, columns)?;
        let [_, fractions] = block_fractions(&pixels, block);
        // Average each block.
        let columns = grid.phi_edges.len() - 1;
        let count = columns * (grid.theta_edges.len() - 1);
        let (mut luminance, mut expanded) = (vec![0.0; count], vec![0.0; count]);
        let rows = luminance.par_chunks_mut(columns).zip(expanded.par_chunks_mut(columns)).enumerate();
        let reduce = |(row, (luminance, expanded)): (usize, (&mut [f32], &mut [f32]))| {
            let mut sums = ExpandedSums::new(fractions.len(), (1.0 / clip_level) as f32);
            let pixels = BlockRow::new(radiance, &pixels.theta_edges, block, row);
            pixels.pixels().for_each(|(pixels, weight)| sums.add(pixels, weight));
            across(&mut sums.luminance, &fractions, block, luminance);
            across(&mut sums.expanded, &fractions, block, expanded);
            (sums.largest, sums.bits)
        };
        let (largest, bits) = rows.map(reduce).reduce(Default::default, |a, b| (a.0.max(b.0), a.1 | b.1));
        let working = WorkingImage::of_luminance(grid, block, luminance);
        working.check(radiance, bits >> 31 == 1)?;
        let expanded = working.with_luminance(expanded);
        Ok(Self { working, expanded, maximum: f64::from(f32::from_bits(largest)) })
    }

    /// The map with the `seen` share of each of its pixels.
    #[must_use]
    pub fn with_seen(self, seen: Option<ArrayView2<'_, f32>>, registration: Registration) -> Self {
        let working = self.working.with_seen(seen, registration);
        let expanded = WorkingImage { seen: working.seen.clone(), ..self.expanded };
        Self { working, expanded, ..self }
    }
}

/// Write the mean of each block of some columns; the usual sizes of blocks are compiled without an inner loop.
fn across(columns: &mut [f32], weights: &[f32], block: usize, out: &mut [f32]) {
    columns.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight);
    match block {
        1 => out.copy_from_slice(columns),
        2 if columns.len().is_multiple_of(2) => sum_blocks::<2>(columns, out),
        4 if columns.len().is_multiple_of(4) => sum_blocks::<4>(columns, out),
        _ => out.iter_mut().zip(columns.chunks(block)).for_each(|(out, block)| *out = block.iter().sum()),
    }
}

fn sum_blocks<const BLOCK: usize>(columns: &[f32], out: &mut [f32]) {
    for (out, block) in out.iter_mut().zip(columns.as_chunks::<BLOCK>().0) {
        *out = block.iter().sum();
    }
}

/// Weighted sums of rows of pixels.
struct ExpandedSums {
    luminance: Vec<f32>,
    expanded: Vec<f32>,
    /// One over the clip level.
    inverse_clip_level: f32,
    /// Bits of the largest luminance: the order of floats that are not negative is the order of their bits.
    largest: u32,
    /// Union of the bits of all samples.
    bits: u32,
}

impl ExpandedSums {
    fn new(width: usize, inverse_clip_level: f32) -> Self {
        Self {
            luminance: vec![0.0; width],
            expanded: vec![0.0; width],
            inverse_clip_level,
            largest: 0,
            bits: 0,
        }
    }

    /// Add a row of pixels, in vectors as wide as this processor has.
    fn add(&mut self, pixels: &[[f32; 3]], weight: f32) {
        Arch::new().dispatch(AddRow { sums: self, pixels, weight });
    }
}

/// Addition of a row of pixels to the sums.
struct AddRow<'a> {
    sums: &'a mut ExpandedSums,
    pixels: &'a [[f32; 3]],
    weight: f32,
}

impl WithSimd for AddRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { sums, pixels, weight } = self;
        let (inverse_clip_level, mut largest, mut bits) = (sums.inverse_clip_level, sums.largest, sums.bits);
        let means = sums.luminance.iter_mut().zip(&mut sums.expanded);
        for ((luminance, expanded), &pixel) in means.zip(pixels) {
            let y = luminance_f32(pixel);
            *luminance += weight * y;
            *expanded += weight * expand(y * inverse_clip_level);
            largest = largest.max((y + 0.0).to_bits()); // minus zero becomes zero
            bits |= pixel[0].to_bits() | pixel[1].to_bits() | pixel[2].to_bits();
        }
        (sums.largest, sums.bits) = (largest, bits);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::Array3;

    use super::*;
    use crate::error::Error;
    use crate::kernels::sphere::band_heights;

    #[test]
    fn a_lamp_in_a_quarter_of_a_block_keeps_a_quarter_of_white() {
        let mut map = Array3::zeros((8, 16, 3));
        map.slice_mut(ndarray::s![4, 6, ..]).fill(2.0);
        let reduced = ExpandedMap::of(map.view(), Registration::CellCentred, 8, 2.0).unwrap();
        // Rows 4 and 5 are not of the same height.
        let bands = band_heights(&Registration::CellCentred.theta_edges(8));
        let share = bands[4] / (bands[4] + bands[5]) / 2.0;
        let pixel = 2 * 8 + 3;
        assert_relative_eq!(f64::from(reduced.expanded.luminance[pixel]), 50.0 * share, max_relative = 1e-4);
        assert_relative_eq!(f64::from(reduced.working.luminance[pixel]), 2.0 * share, max_relative = 1e-6);
        assert_relative_eq!(reduced.maximum, 2.0, max_relative = 1e-6);
    }

    #[test]
    fn luminance_is_that_of_the_working_image() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, columns) in [(30, 60, 60), (30, 60, 16), (37, 74, 10), (150, 300, 1)] {
                let map =
                    Array3::from_shape_fn((height, width, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
                let expected = WorkingImage::of(map.view(), registration, columns).unwrap();
                let result = ExpandedMap::of(map.view(), registration, columns, 11.0).unwrap();
                assert_eq!((result.working.size, result.working.block), (expected.size, expected.block));
                assert_relative_eq!(result.working.flux, expected.flux, max_relative = 1e-6);
                for (result, expected) in result.working.luminance.iter().zip(&expected.luminance) {
                    assert_relative_eq!(result, expected, max_relative = 1e-5);
                }
                assert_relative_eq!(
                    result.maximum,
                    map.rows()
                        .into_iter()
                        .map(|p| f64::from(luminance_f32([p[0], p[1], p[2]])))
                        .fold(0.0, f64::max)
                );
            }
        }
    }

    #[test]
    fn a_sample_that_is_not_radiance_is_refused() {
        for (value, columns) in [(f32::NAN, 16), (-1.0, 16), (f32::INFINITY, 2), (-1.0, 2)] {
            let mut map = Array3::from_elem((8, 16, 3), 0.5_f32);
            map[[3, 5, 1]] = value;
            let refused = ExpandedMap::of(map.view(), Registration::CellCentred, columns, 1.0);
            assert!(matches!(refused, Err(Error::UnusableSamples { row: 3, .. })), "{value} {columns}");
        }
    }
}
