//! Harmonic fill of the unseen part of a map.
//!
//! The radiance `L` of a pixel is multiplied by its share `s` already. The filled map has the radiance `L + (1 - s) H`,
//! where `H` solves Laplace's equation between the seen pixels. It is solved on means over blocks of pixels, because it
//! is smooth, and interpolated between them.

use glam::{DVec3, Vec3A};
use ndarray::{ArrayView2, ArrayView3, ArrayViewMut3, Axis};
use rayon::prelude::*;

use super::level::{Level, Upsampling};
use super::multigrid;
use crate::error::Result;
use crate::interrupt;
use crate::kernels::image::{Grid, block_fractions, check_rgb, luminance_f32};
use crate::kernels::sphere::{Registration, check_lengths};

/// Least share of a known pixel, over the largest share. In pixels of less, rounding and resampling decide the radiance.
pub const LEAST_SHARE: f32 = 0.1;

/// A map, and the share of each pixel that it shows.
#[derive(Clone, Copy)]
struct PartialMap<'a> {
    radiance: ArrayView3<'a, f32>,
    seen: ArrayView2<'a, f32>,
}

/// Write the map with its unseen part filled to `filled`, in C order.
///
/// `seen` is the share of each pixel, by which its radiance is multiplied already. The fill is solved in at most `columns`
/// columns. It continues radiance up to the luminance `most`; brighter pixels are dimmed for it.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::LengthMismatch`].
pub fn fill_unseen(
    radiance: ArrayView3<'_, f32>,
    seen: ArrayView2<'_, f32>,
    registration: Registration,
    columns: usize,
    most: f32,
    mut filled: ArrayViewMut3<'_, f32>,
) -> Result<()> {
    check_rgb(radiance)?;
    let (height, width, _) = radiance.dim();
    check_lengths("pixels", height * width, [("seen", seen.len())])?;
    check_lengths("rows", height, [("seen", seen.nrows())])?;
    let map = PartialMap { radiance, seen };
    let pixels = Grid::of_pixels(height, width, registration);
    let block = width.div_ceil(columns.max(1));
    let solved = map.solve(&pixels, block, most);
    // Add the fill to the unseen share of each pixel.
    let fill = Upsampling::new(&solved, block, (height, width));
    filled.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(row, mut out)| {
        interrupt::check();
        let fill = fill.row(row);
        for (column, mut out) in out.outer_iter_mut().enumerate() {
            let share = map.seen[[row, column]];
            let value = map.pixel(row, column) + (1.0 - share) * fill.at(column);
            out.iter_mut().zip(value.to_array()).for_each(|(out, value)| *out = value);
        }
    });
    Ok(())
}

impl PartialMap<'_> {
    /// Radiance of a pixel, multiplied by its share.
    fn pixel(&self, row: usize, column: usize) -> Vec3A {
        Vec3A::from_array([0, 1, 2].map(|channel| self.radiance[[row, column, channel]]))
    }

    /// Harmonic image in blocks of pixels; known blocks have the mean radiance of what is seen of them.
    fn solve(&self, pixels: &Grid, block: usize, most: f32) -> Level {
        let (means, shares) = self.means(pixels, block, most);
        let least = LEAST_SHARE * shares.iter().copied().fold(0.0, f32::max);
        let is_hole: Vec<bool> = shares.iter().map(|&share| share < least).collect();
        // Start the holes from the mean of what is known.
        let known = || means.iter().zip(&shares).zip(&is_hole).filter(|(_, is_hole)| !**is_hole);
        let count = known().count().max(1) as f64;
        let start = known().map(|((&mean, &share), _)| (mean / share).as_dvec3()).sum::<DVec3>() / count;
        let start = start.as_vec3a();
        let value = |((&mean, &share), &is_hole)| if is_hole { start } else { mean / share };
        let grid = pixels.in_blocks(block);
        let mut solved = Level::new(grid.clone(), Vec::new());
        solved.values = means.iter().zip(&shares).zip(&is_hole).map(value).collect();
        multigrid::solve(grid, is_hole, &mut solved.values);
        solved
    }

    /// Means over blocks by solid angle: of the radiance up to the luminance `most`, multiplied by the share, and of the share.
    fn means(&self, pixels: &Grid, block: usize, most: f32) -> (Vec<Vec3A>, Vec<f32>) {
        let (height, width) = self.seen.dim();
        let [of_rows, of_columns] = block_fractions(pixels, block);
        let blocks = width.div_ceil(block);
        let count = height.div_ceil(block) * blocks;
        let (mut means, mut shares) = (vec![Vec3A::ZERO; count], vec![0.0; count]);
        let rows = means.par_chunks_mut(blocks).zip(shares.par_chunks_mut(blocks)).enumerate();
        rows.for_each(|(row, (means, shares))| {
            interrupt::check();
            let rows = row * block..((row + 1) * block).min(height);
            for (row, of_row) in rows.clone().zip(&of_rows[rows]) {
                for (column, of_column) in of_columns.iter().enumerate() {
                    let (share, fraction) = (self.seen[[row, column]], of_row * of_column);
                    means[column / block] += fraction * dim(self.pixel(row, column), most * share);
                    shares[column / block] += fraction * share;
                }
            }
        });
        (means, shares)
    }
}

/// Scale radiance to a luminance of at most `most`.
fn dim(radiance: Vec3A, most: f32) -> Vec3A {
    let luminance = luminance_f32(radiance.to_array());
    if luminance > most { radiance * (most / luminance) } else { radiance }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use ndarray::{Array2, Array3, Axis};
    use std::f64::consts::{PI, TAU};

    const SIZE: (usize, usize) = (64, 128);

    /// A map of this radiance and share `seen`, after its unseen part is filled in `columns` columns.
    fn fill(
        radiance: impl Fn(usize, usize) -> f32,
        seen: impl Fn(usize, usize) -> f32,
        columns: usize,
        most: f32,
    ) -> Array2<f32> {
        let seen = Array2::from_shape_fn(SIZE, |(y, x)| seen(y, x));
        let map = Array3::from_shape_fn((SIZE.0, SIZE.1, 3), |(y, x, _)| radiance(y, x) * seen[[y, x]]);
        let mut filled = map.clone();
        fill_unseen(map.view(), seen.view(), Registration::CellCentred, columns, most, filled.view_mut())
            .unwrap();
        filled.index_axis(Axis(2), 1).to_owned()
    }

    fn wild_share(row: usize, column: usize) -> f32 {
        if row < 7 || (20..40).contains(&row) && column % 50 < 31 {
            0.0
        } else {
            ((row * 31 + column * 17) % 7) as f32 / 6.0
        }
    }

    #[test]
    fn a_constant_map_is_filled_with_its_constant() {
        for columns in [128, 32, 10] {
            for value in fill(|_, _| 0.3, wild_share, columns, f32::INFINITY) {
                assert_relative_eq!(value, 0.3, max_relative = 1e-5);
            }
        }
    }

    /// The wave `tan(theta / 2) cos phi` solves Laplace's equation on the sphere.
    #[test]
    fn a_harmonic_wave_is_continued_to_the_pole() {
        let wave = |row: usize, column: usize| {
            let theta = PI * (row as f64 + 0.5) / SIZE.0 as f64;
            let phi = TAU * (column as f64 + 0.5) / SIZE.1 as f64;
            ((0.5 * theta).tan().min(1.0) * phi.cos()) as f32 + 1.0
        };
        let seen = |row, _| if row < 24 { 0.0 } else { 1.0 };
        let filled = fill(wave, seen, 128, f32::INFINITY);
        for ((row, column), &value) in filled.indexed_iter() {
            assert!((value - wave(row, column)).abs() < 2e-3, "{row} {column} {value}");
        }
    }

    #[test]
    fn seen_pixels_keep_their_bits_and_a_lamp_is_dimmed_for_the_fill() {
        let lamp = |row, column| if row == 30 && column < 64 { 100.0 } else { 1.0 };
        let seen = |row, _| if row > 30 { 0.0 } else { 1.0 };
        for (most, largest) in [(f32::INFINITY, 100.0), (8.0, 8.0)] {
            let filled = fill(lamp, seen, 128, most);
            for ((row, column), &value) in filled.indexed_iter() {
                if row <= 30 {
                    assert_eq!(value.to_bits(), lamp(row, column).to_bits());
                } else {
                    assert!((1.0..=largest).contains(&value));
                }
            }
            assert!(filled[[31, 32]] > 0.8 * largest);
        }
    }
}
