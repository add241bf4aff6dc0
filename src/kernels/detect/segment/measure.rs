//! Measurement of the lights in the map's own pixels.

use std::ops::Range;

use ndarray::ArrayView3;
use rayon::prelude::*;

use super::background::LocalBackground;
use super::components::Segments;
use super::light_moments::{ColumnAngle, LightEdge, LightMoments, RowAngle};
use super::run::{RUNS_OF_A_TASK, Run, runs};
use super::working_image::WorkingImage;
use crate::kernels::detect::clipping::Top;
use crate::kernels::image::luminance_f32;
use crate::kernels::sphere::Registration;

/// Measure each segment against its background.
pub fn measure(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    working: &WorkingImage,
    segments: &Segments,
    backgrounds: &[LocalBackground],
) -> Vec<LightMoments> {
    let radiance = radiance.as_standard_layout();
    let (height, width, _) = radiance.dim();
    let map = SourceMap {
        pixels: radiance.as_slice().map_or(&[][..], |samples| samples.as_chunks::<3>().0),
        block: working.block,
        rows: registration.theta_edges(height).windows(2).map(RowAngle::new).collect(),
        columns: registration.phi_edges(width).windows(2).map(ColumnAngle::new).collect(),
    };
    let lights = segments.pixels.par_iter().zip(backgrounds);
    lights.map(|(pixels, background)| map.measure(&runs(pixels, working.size.1), background)).collect()
}

/// The map's pixels, and their blocks in the working image.
struct SourceMap<'a> {
    pixels: &'a [[f32; 3]],
    block: usize,
    rows: Vec<RowAngle>,
    columns: Vec<ColumnAngle>,
}

impl SourceMap<'_> {
    /// Measure a light part by part: all threads work on a large one, in the same order for any number of threads.
    fn measure(&self, runs: &[Run], local: &LocalBackground) -> LightMoments {
        let parts = runs.par_chunks(RUNS_OF_A_TASK);
        let (peak, largest) = parts
            .clone()
            .map(|part| self.peak(part))
            .reduce(Default::default, |one, other| (one.0.max(other.0), one.1.and(other.1)));
        let edge = LightEdge { peak, background: local.luminance as f32 };
        let sums: Vec<LightMoments> = parts.map(|part| self.sum(part, edge)).collect();
        let mut light = sums.iter().fold(LightMoments::of_peak(peak), |sum, part| sum.and(part));
        light.largest = largest;
        light.subtract(local.radiance);
        light
    }

    /// Luminance of the brightest pixel, and the largest sample.
    fn peak(&self, part: &[Run]) -> (f32, Top) {
        let higher = |a: f32, b: f32| if b > a { b } else { a };
        let rows = part.iter().flat_map(|run| self.rows_of(run));
        rows.fold(<(f32, Top)>::default(), |(peak, top), (_, _, pixels)| {
            (pixels.iter().copied().map(luminance_f32).fold(peak, higher), top.and_of(pixels))
        })
    }

    /// Sums over a part of a light.
    fn sum(&self, part: &[Run], edge: LightEdge) -> LightMoments {
        let mut light = LightMoments::of_peak(edge.peak);
        for (row, columns, pixels) in part.iter().flat_map(|run| self.rows_of(run)) {
            light.add(pixels, &self.columns[columns], self.rows[row], edge);
        }
        light
    }

    /// Rows of the map's pixels inside a run, each with its number and its columns.
    fn rows_of(&self, run: &Run) -> impl Iterator<Item = (usize, Range<usize>, &[[f32; 3]])> {
        let width = self.columns.len();
        let columns = within(run.columns.clone(), self.block, width);
        let rows = within(run.row..run.row + 1, self.block, self.rows.len());
        rows.map(move |row| (row, columns.clone(), &self.pixels[row * width..][columns.clone()]))
    }
}

/// Range of map pixels covered by a range of working pixels.
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
