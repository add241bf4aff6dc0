//! The working image: the luminance of a map in fewer pixels, and the maximum of each tile of them.
//!
//! Detection is bound by memory: this pass reads every sample once, later steps read a sixteenth of them and less.

use ndarray::{Array2, ArrayView2, ArrayView3, ArrayViewMut1};
use rayon::prelude::*;
use std::f64::consts::PI;

use super::dot_product::dot;
use crate::error::{Error, Result};
use crate::kernels::image::{
    BlockLayout, BlockRow, Grid, LUMINANCE_F32, SeenPart, check_samples, luminance_f32, samples_of,
};
use crate::kernels::sphere::{Registration, band_heights};

/// Sides of a tile, in pixels of the working image.
pub const TILE: usize = 16;

/// A map in fewer pixels, each the mean of a block of the map's own pixels.
#[derive(Clone, Debug)]
pub struct WorkingImage {
    /// Rows and columns.
    pub size: (usize, usize),
    /// Mean luminance by solid angle, row after row.
    pub luminance: Vec<f32>,
    /// Edges of the pixels on the sphere.
    pub grid: Grid,
    /// `cos theta_top - cos theta_bottom` of each row.
    pub bands: Vec<f64>,
    /// Pixels of the map along each side of a working pixel.
    pub block: usize,
    /// Largest luminance in each tile.
    pub tile_maxima: Array2<f32>,
    /// Integral of the luminance over the sphere.
    pub flux: f64,
    /// Share of each pixel that the map shows; `None` if it shows all.
    pub seen: Option<SeenPart>,
}

impl WorkingImage {
    /// `radiance` as luminance in at most `columns` columns.
    ///
    /// # Errors
    ///
    /// [`Error::NotAMap`]; [`Error::UnusableSamples`], with their counts, for samples that are not radiance;
    /// [`Error::TooBright`].
    pub fn of(radiance: ArrayView3<'_, f32>, registration: Registration, columns: usize) -> Result<Self> {
        // Cut the map into blocks, one for each working pixel.
        let BlockLayout { pixels, grid, block } = BlockLayout::of_map(radiance, registration, columns)?;
        let reduction = Reduction::new(radiance, &pixels, &grid, block);
        let (height, width) = (grid.theta_edges.len() - 1, grid.phi_edges.len() - 1);
        let mut luminance = vec![0.0; height * width];
        let rows = luminance.par_chunks_mut(width).enumerate();
        let has_signs = rows.map(|(row, out)| reduction.fill_row(row, out)).reduce(|| false, |a, b| a | b);
        let working = Self::of_luminance(grid, block, luminance);
        working.check(radiance, has_signs)?;
        Ok(working)
    }

    /// Refuse samples that no light can have: such a sample shows as a minus sign or in the flux.
    ///
    /// # Errors
    ///
    /// [`Error::UnusableSamples`], [`Error::TooBright`].
    pub fn check(&self, radiance: ArrayView3<'_, f32>, has_signs: bool) -> Result<()> {
        if has_signs || !self.flux.is_finite() {
            check_samples(radiance)?;
        }
        if self.flux.is_finite() { Ok(()) } else { Err(Error::TooBright) }
    }

    /// Copy of the pixels with another luminance.
    #[must_use]
    pub fn with_luminance(&self, luminance: Vec<f32>) -> Self {
        Self { seen: self.seen.clone(), ..Self::of_luminance(self.grid.clone(), self.block, luminance) }
    }

    /// The image with the `seen` share of each pixel of the map.
    #[must_use]
    pub fn with_seen(self, seen: Option<ArrayView2<'_, f32>>, registration: Registration) -> Self {
        let seen = seen.map(|seen| SeenPart::of(seen, registration, self.block));
        Self { seen, ..self }
    }

    /// Mean luminance of what is seen.
    pub fn mean(&self) -> f64 {
        self.flux / self.seen.as_ref().map_or(4.0 * PI, SeenPart::solid_angle)
    }

    /// The pixels of a `grid` with this luminance, each the mean of `block` x `block` pixels of a map.
    pub fn of_luminance(grid: Grid, block: usize, luminance: Vec<f32>) -> Self {
        let (bands, widths) = (band_heights(&grid.theta_edges), grid.widths());
        let size @ (height, width) = (bands.len(), widths.len());
        let mut tile_maxima = Array2::zeros((height.div_ceil(TILE), width.div_ceil(TILE)));
        let mut row_sums = vec![0.0; height];
        luminance
            .par_chunks(TILE * width)
            .zip(row_sums.par_chunks_mut(TILE))
            .zip(tile_maxima.outer_iter_mut().into_par_iter())
            .for_each(|((rows, sums), maxima)| measure_tiles(rows, &widths, sums, maxima));
        let flux = row_sums.iter().zip(&bands).map(|(sum, band)| sum * band).sum();
        Self { size, luminance, grid, bands, block, tile_maxima, flux, seen: None }
    }

    /// Number of columns that are as wide as `rows` rows are high: at most half a turn.
    pub fn columns_across(&self, row: usize, rows: usize) -> usize {
        let edges = &self.grid.theta_edges[row..row + 2];
        let columns = (rows as f64 / (0.5 * (edges[0] + edges[1])).sin()) as usize;
        columns.min(self.size.1 / 2)
    }

    /// Height of a row, in radians; the last may be lower.
    pub fn row_height(&self) -> f64 {
        let theta = &self.grid.theta_edges;
        theta[1..].iter().zip(theta).map(|(below, above)| below - above).fold(0.0, f64::max)
    }
}

/// Sum each row of a row of tiles, and find the maximum of each tile.
fn measure_tiles(rows: &[f32], widths: &[f64], sums: &mut [f64], mut maxima: ArrayViewMut1<'_, f32>) {
    let mut largest = vec![0.0; widths.len()];
    for (row, sum) in rows.chunks(widths.len()).zip(sums) {
        *sum = dot(row, widths);
        raise(&mut largest, row);
    }
    for (maximum, columns) in maxima.iter_mut().zip(largest.chunks(TILE)) {
        *maximum = columns.iter().copied().fold(0.0, f32::max);
    }
}

fn raise(largest: &mut [f32], row: &[f32]) {
    for (largest, &value) in largest.iter_mut().zip(row) {
        *largest = if value > *largest { value } else { *largest };
    }
}

/// Reduction of the map's pixels to those of the working image.
struct Reduction<'a> {
    radiance: ArrayView3<'a, f32>,
    block: usize,
    /// Polar angles between the rows of the map.
    theta_edges: &'a [f64],
    /// Widths of the map's first and last pixel, in widths of the others.
    outer_widths: [f32; 2],
    /// One over the width of each column of the working image, in widths of the map's pixels.
    per_width: Vec<f32>,
}

impl<'a> Reduction<'a> {
    fn new(radiance: ArrayView3<'a, f32>, pixels: &'a Grid, grid: &Grid, block: usize) -> Self {
        let width = |edge: &[f64]| ((edge[1] - edge[0]) * pixels.columns_per_radian) as f32;
        let per_width = grid.phi_edges.windows(2).map(|edge| 1.0 / width(edge)).collect();
        let phi = &pixels.phi_edges;
        let outer_widths = [width(&phi[..2]), width(&phi[phi.len() - 2..])];
        Self { radiance, block, theta_edges: &pixels.theta_edges, outer_widths, per_width }
    }

    /// Write the luminance of one row of the working image; true if a sample of it has a minus sign.
    fn fill_row(&self, row: usize, out: &mut [f32]) -> bool {
        if self.block == 1 {
            fill_luminance(&samples_of(self.radiance, row..row + 1), out)
        } else {
            self.reduce(&BlockRow::new(self.radiance, self.theta_edges, self.block, row), out)
        }
    }

    /// Write the mean luminance of each block of a row; true if a sample of it has a minus sign.
    fn reduce(&self, pixels: &BlockRow<'_>, out: &mut [f32]) -> bool {
        let width = self.radiance.dim().1;
        pixels.mean(|columns, mean| {
            self.narrow_the_outer(mean, columns.start == 0, columns.end == width);
            let blocks = columns.start / self.block..columns.end.div_ceil(self.block);
            let (out, per_width) = (&mut out[blocks.clone()], &self.per_width[blocks]);
            // Sum the whole blocks apart from a shorter last one: a check of each length took a tenth of the time, and a
            // fifth with blocks of two pixels.
            let whole = mean.chunks_exact(3 * self.block);
            if let ([_, ..], Some(out), Some(per_width)) =
                (whole.remainder(), out.last_mut(), per_width.last())
            {
                *out = per_width * luminance_of_sum(whole.remainder());
            }
            for ((out, samples), per_width) in out.iter_mut().zip(whole).zip(per_width) {
                *out = per_width * luminance_of_sum(samples);
            }
        })
    }

    /// Scale the first and the last pixel of a row, which may be narrower than the others.
    fn narrow_the_outer(&self, mean: &mut [f32], is_first: bool, is_last: bool) {
        let last = mean.len() - 3;
        if is_first {
            mean[..3].iter_mut().for_each(|value| *value *= self.outer_widths[0]);
        }
        if is_last {
            mean[last..].iter_mut().for_each(|value| *value *= self.outer_widths[1]);
        }
    }
}

/// Luminance of the sum of RGB pixels, four pixels at a time: three vectors of four lanes.
fn luminance_of_sum(samples: &[f32]) -> f32 {
    let [r, g, b] = LUMINANCE_F32;
    let (fours, rest) = samples.as_chunks::<12>();
    let mut lanes = [0.0_f32; 4];
    for four in fours {
        let weights = [[r, g, b, r], [g, b, r, g], [b, r, g, b]];
        for (samples, weights) in four.as_chunks::<4>().0.iter().zip(weights) {
            for (lane, (sample, weight)) in lanes.iter_mut().zip(samples.iter().zip(weights)) {
                *lane += weight * sample;
            }
        }
    }
    let rest: f32 = rest.as_chunks::<3>().0.iter().copied().map(luminance_f32).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

/// Write the luminance of each pixel; true if a sample has a minus sign. NaN and infinity show in the flux.
fn fill_luminance(samples: &[f32], out: &mut [f32]) -> bool {
    let mut bits = 0;
    for (out, &pixel) in out.iter_mut().zip(samples.as_chunks::<3>().0) {
        // Minus zero becomes zero: floats are compared by their bits.
        *out = luminance_f32(pixel) + 0.0;
        bits |= pixel.iter().fold(0, |bits, sample| bits | sample.to_bits());
    }
    bits >> 31 == 1
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::image::luminance;
    use approx::assert_relative_eq;
    use ndarray::Array3;
    use std::f64::consts::PI;

    fn map(height: usize, width: usize) -> Array3<f32> {
        Array3::from_shape_fn((height, width, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32)
    }

    /// Sum over the map's own pixels, one by one.
    fn flux_of(map: &Array3<f32>, registration: Registration) -> f64 {
        let (height, width, _) = map.dim();
        let solid_angles = crate::kernels::sphere::pixel_solid_angles(height, width, registration).unwrap();
        let pixels = solid_angles.indexed_iter();
        let rgb = |y: usize, x: usize| [0, 1, 2].map(|c| f64::from(map[[y, x, c]]));
        pixels.map(|((y, x), solid_angle)| luminance(rgb(y, x)) * solid_angle).sum()
    }

    #[test]
    fn blocks_of_any_size_keep_the_flux() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, columns) in
                [(30, 60, 60), (30, 60, 16), (37, 74, 10), (9, 18, 1), (150, 300, 1)]
            {
                let map = map(height, width);
                let working = WorkingImage::of(map.view(), registration, columns).unwrap();
                assert!(working.size.1 <= columns);
                assert_relative_eq!(working.flux, flux_of(&map, registration), max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn each_pixel_is_the_mean_of_its_block_by_solid_angle() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, width, block) in [(30, 60, 1), (30, 60, 4), (37, 74, 5), (300, 600, 3)] {
                let map = map(height, width);
                let working = WorkingImage::of(map.view(), registration, width.div_ceil(block)).unwrap();
                assert_eq!(working.block, block);
                let solid_angles =
                    crate::kernels::sphere::pixel_solid_angles(height, width, registration).unwrap();
                let mut sums = vec![(0.0, 0.0); working.luminance.len()];
                for ((y, x), &solid_angle) in solid_angles.indexed_iter() {
                    let sum = &mut sums[y / block * working.size.1 + x / block];
                    let rgb = [0, 1, 2].map(|c| f64::from(map[[y, x, c]]));
                    *sum = (sum.0 + luminance(rgb) * solid_angle, sum.1 + solid_angle);
                }
                for (&mean, (flux, solid_angle)) in working.luminance.iter().zip(sums) {
                    assert_relative_eq!(f64::from(mean), flux / solid_angle, max_relative = 1e-5);
                }
            }
        }
    }

    #[test]
    fn a_constant_map_stays_constant() {
        let map = Array3::from_elem((50, 100, 3), 0.5_f32);
        let working = WorkingImage::of(map.view(), Registration::BorderSampled, 30).unwrap();
        assert!(working.luminance.iter().all(|value| (value - 0.5).abs() < 1e-6));
        assert_relative_eq!(working.flux, 0.5 * 4.0 * PI, max_relative = 1e-6);
    }

    /// One more column would be wider, unless half a turn is narrower.
    #[test]
    fn columns_across_are_as_wide_as_some_rows_are_high() {
        let working = WorkingImage::of(map(50, 100).view(), Registration::CellCentred, 100).unwrap();
        for row in 0..50 {
            let width = (PI * (row as f64 + 0.5) / 50.0).sin();
            let columns = working.columns_across(row, 3);
            assert!(columns as f64 * width <= 3.0, "{row} {columns}");
            assert!(columns == 50 || (columns + 1) as f64 * width > 3.0, "{row} {columns}");
        }
    }

    #[test]
    fn a_tile_holds_the_maximum_of_its_pixels() {
        let working = WorkingImage::of(map(50, 100).view(), Registration::CellCentred, 100).unwrap();
        for ((row, column), &maximum) in working.tile_maxima.indexed_iter() {
            let rows = row * TILE..((row + 1) * TILE).min(50);
            let pixels =
                rows.flat_map(|y| (column * TILE..((column + 1) * TILE).min(100)).map(move |x| y * 100 + x));
            let expected = pixels.map(|i| working.luminance[i]).fold(0.0, f32::max);
            assert_relative_eq!(maximum, expected);
        }
    }

    /// Samples -0 are valid: only one of those with a minus sign is an error.
    #[test]
    fn a_negative_sample_is_refused() {
        let mut map = Array3::from_elem((8, 16, 3), -0.0_f32);
        map[[3, 5, 1]] = -1.0;
        for columns in [16, 2] {
            let refused = WorkingImage::of(map.view(), Registration::CellCentred, columns);
            assert!(
                matches!(refused, Err(Error::UnusableSamples { row: 3, negative: 1, .. })),
                "{refused:?}"
            );
        }
    }

    #[test]
    fn a_sample_that_is_not_finite_is_refused() {
        let mut map = map(8, 16);
        map[[3, 5, 1]] = f32::NAN;
        for columns in [16, 2] {
            let refused = WorkingImage::of(map.view(), Registration::CellCentred, columns);
            assert!(matches!(refused, Err(Error::UnusableSamples { row: 3, nan: 1, .. })), "{refused:?}");
        }
        // Sums of such samples are beyond f32.
        let refused =
            WorkingImage::of(Array3::from_elem((8, 16, 3), f32::MAX).view(), Registration::CellCentred, 2);
        assert!(matches!(refused, Err(Error::TooBright)), "{refused:?}");
    }
}
