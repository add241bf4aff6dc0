//! The visitor of rows of blocks: every reduction of a map to means over square blocks of pixels.
//!
//! The mean of a block has two steps: down the rows of a row of blocks, here, and then across the columns of each block,
//! where the reductions differ.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::borrow::Cow;
use std::ops::Range;

use ndarray::{ArrayView3, s};
use pulp::{Arch, Simd, WithSimd};

use super::grid::Grid;
use crate::kernels::sphere::band_heights;

/// Pixels of a row in one strip: their means fit in the first-level cache, and memory is read in long runs.
const PIXELS_AT_ONCE: usize = 1024;

/// The rows of a map behind one row of blocks.
pub(crate) struct BlockRow<'a> {
    samples: Cow<'a, [f32]>,
    /// Pixels along each side of a block.
    block: usize,
    /// Fraction of each row of pixels in the height of the row of blocks.
    weights: Vec<f32>,
    /// `cos theta_top - cos theta_bottom` of the row of blocks.
    pub height: f64,
}

impl<'a> BlockRow<'a> {
    /// Row `row` of the blocks of `block` x `block` pixels; `theta_edges` are those of the pixels.
    pub fn new(radiance: ArrayView3<'a, f32>, theta_edges: &[f64], block: usize, row: usize) -> Self {
        let rows = row * block..((row + 1) * block).min(theta_edges.len() - 1);
        Self::with(samples_of(radiance, rows.clone()), &theta_edges[rows.start..=rows.end], block)
    }

    /// Blocks of `block` pixels across some rows, whose samples are given with their own `theta_edges`.
    pub fn of_samples(samples: &'a [f32], theta_edges: &[f64], block: usize) -> Self {
        Self::with(Cow::Borrowed(samples), theta_edges, block)
    }

    fn with(samples: Cow<'a, [f32]>, theta_edges: &[f64], block: usize) -> Self {
        let bands = band_heights(theta_edges);
        let height = bands.iter().sum();
        let weights = bands.iter().map(|band| (band / height) as f32).collect();
        Self { samples, block, weights, height }
    }

    /// The rows of pixels, each with its fraction of the height of the row of blocks.
    pub fn pixels(&self) -> impl Iterator<Item = (&[[f32; 3]], f32)> {
        let pixels = self.samples.as_chunks::<3>().0;
        pixels.chunks_exact(pixels.len() / self.weights.len()).zip(self.weights.iter().copied())
    }

    /// Visit strips of whole blocks; return true if a sample has a minus sign.
    ///
    /// The visitor gets the columns of a strip, and the RGB mean of each pixel column, weighted by the heights of the rows.
    pub fn mean(&self, mut visit: impl FnMut(Range<usize>, &mut [f32])) -> bool {
        let rows: Vec<&[f32]> = self.samples.chunks_exact(self.samples.len() / self.weights.len()).collect();
        let width = rows[0].len() / 3;
        let at_once = (PIXELS_AT_ONCE / self.block).max(1) * self.block;
        let mut mean = vec![0.0; 3 * at_once];
        let (mut signs, widest) = (false, Arch::new());
        for start in (0..width).step_by(at_once) {
            let columns = start..(start + at_once).min(width);
            let mean = &mut mean[..3 * columns.len()];
            let samples = 3 * columns.start..3 * columns.end;
            signs |= widest.dispatch(WeightedMean { rows: &rows, weights: &self.weights, samples, mean });
            visit(columns, mean);
        }
        signs
    }
}

/// Fraction of each row of pixels in the height of its block, and of each column in the width.
pub(crate) fn block_fractions(pixels: &Grid, block: usize) -> [Vec<f32>; 2] {
    let fractions = |sizes: &[f64]| -> Vec<f32> {
        let fractions_of_block = |sizes: &[f64]| {
            let whole: f64 = sizes.iter().sum();
            sizes.iter().map(|size| (size / whole) as f32).collect::<Vec<f32>>()
        };
        sizes.chunks(block).flat_map(fractions_of_block).collect()
    };
    [fractions(&band_heights(&pixels.theta_edges)), fractions(&pixels.widths())]
}

/// The samples of some rows of a map, row after row.
pub(crate) fn samples_of(radiance: ArrayView3<'_, f32>, rows: Range<usize>) -> Cow<'_, [f32]> {
    let part = radiance.slice_move(s![rows, .., ..]);
    part.to_slice().map_or_else(|| Cow::Owned(part.iter().copied().collect()), Cow::Borrowed)
}

/// Write the weighted `mean` of the same `samples` of some rows; true if a sample has a minus sign.
///
/// Four rows at a time, for fewer passes over the sums.
struct WeightedMean<'a> {
    rows: &'a [&'a [f32]],
    weights: &'a [f32],
    samples: Range<usize>,
    mean: &'a mut [f32],
}

impl WithSimd for WeightedMean<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { rows, weights, samples, mean } = self;
        let mut bits = 0;
        let (fours, rest) = rows.as_chunks::<4>();
        for (i, (rows, weights)) in fours.iter().zip(weights.as_chunks::<4>().0).enumerate() {
            let rows = rows.map(|row| &row[samples.clone()]);
            bits |= if i == 0 {
                add_four::<true>(rows, weights, mean)
            } else {
                add_four::<false>(rows, weights, mean)
            };
        }
        if fours.is_empty() {
            mean.fill(0.0);
        }
        for (row, weight) in rest.iter().zip(&weights[4 * fours.len()..]) {
            for (mean, sample) in mean.iter_mut().zip(&row[samples.clone()]) {
                *mean += weight * sample;
                bits |= sample.to_bits();
            }
        }
        bits >> 31 == 1
    }
}

/// Add four weighted rows to `mean`, or set it to their sum if they are the `FIRST`; the bits of all samples.
#[inline(always)]
fn add_four<const FIRST: bool>([a, b, c, d]: [&[f32]; 4], weights: &[f32; 4], mean: &mut [f32]) -> u32 {
    let mut bits = 0;
    for ((((mean, a), b), c), d) in mean.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let before = if FIRST { 0.0 } else { *mean };
        *mean = before + ((weights[0] * a + weights[1] * b) + (weights[2] * c + weights[3] * d));
        bits |= (a.to_bits() | b.to_bits()) | (c.to_bits() | d.to_bits());
    }
    bits
}
