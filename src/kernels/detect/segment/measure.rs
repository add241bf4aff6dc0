//! The measurement of each light, in the pixels of the map itself.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use ndarray::ArrayView3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::background::LocalBackground;
use super::components::Segments;
use super::coverage::{ColumnAngles, CoveredPixels};
use super::light_moments::LightMoments;
use super::run::{Run, runs};
use super::working_image::WorkingImage;
use crate::kernels::detect::clipping::Top;
use crate::kernels::image::luminance_f32;
use crate::kernels::sphere::{Registration, band_heights};

/// Runs that one task sums. Another number would add in another order.
const RUNS_OF_A_PART: usize = 64;

/// Measure each segment against its background.
pub fn measure(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    working: &WorkingImage,
    segments: &Segments,
    backgrounds: &[LocalBackground],
) -> Vec<LightMoments> {
    let radiance = radiance.as_standard_layout();
    let pixels = radiance.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0);
    let runs: Vec<Vec<Run>> = segments.pixels.iter().map(|segment| runs(segment, working.size.1)).collect();
    let map = SourceMap::new(pixels, radiance.dim(), registration, working.block, &runs);
    let lights = runs.par_iter().zip(backgrounds);
    lights.map(|(runs, background)| map.measure(runs, background)).collect()
}

/// The map's pixels behind the working image's.
struct SourceMap<'a> {
    pixels: &'a [[f32; 3]],
    width: usize,
    block: usize,
    /// Sine and cosine of the polar angle, and `cos theta_top - cos theta_bottom`, of each row.
    rows: Vec<[f64; 3]>,
    columns: ColumnAngles<Vec<f64>>,
    /// The widest vectors of this processor.
    widest: Arch,
}

impl<'a> SourceMap<'a> {
    /// Sines and cosines are computed only where `runs` lie, for most of a map is dark.
    fn new(
        pixels: &'a [[f32; 3]],
        (height, width, _): (usize, usize, usize),
        registration: Registration,
        block: usize,
        runs: &[Vec<Run>],
    ) -> Self {
        // Mark the rows and columns in which lights lie.
        let (mut is_row_covered, mut is_column_covered) = (vec![false; height], vec![false; width]);
        for run in runs.iter().flatten() {
            is_row_covered[within(run.row..run.row + 1, block, height)].fill(true);
            is_column_covered[within(run.columns.clone(), block, width)].fill(true);
        }
        // Compute their sines, cosines and sizes.
        let row = |(edges, is_covered): (&[f64], &bool)| {
            if *is_covered {
                let (sin, cos) = (0.5 * (edges[0] + edges[1])).sin_cos();
                [sin, cos, band_heights(edges)[0]]
            } else {
                [0.0; 3]
            }
        };
        let rows = registration.theta_edges(height).windows(2).zip(&is_row_covered).map(row).collect();
        let mut columns = ColumnAngles::default();
        for (edges, is_covered) in registration.phi_edges(width).windows(2).zip(is_column_covered) {
            columns.push(edges, is_covered);
        }
        Self { pixels, width, block, rows, columns, widest: Arch::new() }
    }

    /// Measure a light part by part: a large one keeps all threads busy, and any number of threads adds in
    /// the same order.
    fn measure(&self, runs: &[Run], local: &LocalBackground) -> LightMoments {
        let parts = runs.par_chunks(RUNS_OF_A_PART);
        let peak = parts.clone().map(|part| self.peak(part)).reduce(|| 0.0, f32::max);
        let largest = parts.clone().map(|part| self.top(part)).reduce(Top::default, Top::and);
        let background = local.luminance as f32;
        let sum = |part| self.widest.dispatch(SumOfLight { map: self, part, peak, background });
        let lights: Vec<LightMoments> = parts.map(sum).collect();
        let mut light = lights.iter().fold(LightMoments::of_peak(peak), |sum, part| sum.and(part));
        light.largest = largest;
        light.subtract(local.radiance);
        light
    }

    /// Luminance of the brightest pixel.
    fn peak(&self, part: &[Run]) -> f32 {
        self.widest.dispatch(PeakOfLight { map: self, part })
    }

    /// The largest sample.
    fn top(&self, part: &[Run]) -> Top {
        self.rows_of_all(part).fold(Top::default(), Top::and_of)
    }

    /// Rows of the map's pixels behind a part.
    fn rows_of_all(&self, part: &[Run]) -> impl Iterator<Item = &[[f32; 3]]> {
        part.iter().flat_map(|run| self.rows_of(run)).map(|(_, _, pixels)| pixels)
    }

    /// Rows of the map's pixels behind a run, each with its number and its columns.
    fn rows_of(&self, run: &Run) -> impl Iterator<Item = (usize, Range<usize>, &[[f32; 3]])> {
        let columns = within(run.columns.clone(), self.block, self.width);
        let rows = within(run.row..run.row + 1, self.block, self.rows.len());
        rows.map(move |row| (row, columns.clone(), &self.pixels[row * self.width..][columns.clone()]))
    }
}

/// Luminance of the brightest pixel of `part`.
struct PeakOfLight<'a> {
    map: &'a SourceMap<'a>,
    part: &'a [Run],
}

impl WithSimd for PeakOfLight<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        let higher = |a: f32, b: f32| if b > a { b } else { a };
        let mut lanes = [0.0_f32; 8];
        for pixels in self.map.rows_of_all(self.part) {
            let (most, rest) = pixels.as_chunks::<8>();
            for pixels in most {
                lanes
                    .iter_mut()
                    .zip(pixels)
                    .for_each(|(lane, &pixel)| *lane = higher(*lane, luminance_f32(pixel)));
            }
            for &pixel in rest {
                lanes[0] = higher(lanes[0], luminance_f32(pixel));
            }
        }
        lanes.into_iter().fold(0.0, higher)
    }
}

/// The sums over `part` of a light.
struct SumOfLight<'a> {
    map: &'a SourceMap<'a>,
    part: &'a [Run],
    peak: f32,
    background: f32,
}

impl WithSimd for SumOfLight<'_> {
    type Output = LightMoments;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> LightMoments {
        let Self { map, part, peak, background } = self;
        let mut light = LightMoments::of_peak(peak);
        let mut covered = CoveredPixels::default();
        for (row, columns, pixels) in part.iter().flat_map(|run| map.rows_of(run)) {
            let [sin, cos, band] = map.rows[row];
            let columns = map.columns.at(columns);
            covered.refill(pixels, columns.width, band, peak, background);
            light.add(&mut covered, &columns, [sin, cos]);
        }
        light
    }
}

/// Pixels of a map of this `size` behind `working` pixels.
fn within(working: Range<usize>, block: usize, size: usize) -> Range<usize> {
    working.start * block..(working.end * block).min(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_working_pixel_may_hold_fewer_pixels_of_the_map() {
        assert_eq!(within(2..4, 4, 100), 8..16);
        assert_eq!(within(24..25, 4, 98), 96..98);
    }
}
