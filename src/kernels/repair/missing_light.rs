//! Distribution of the light that was cut off over the clipped pixels.
//!
//! A picture contains the positions where light is missing, but not the amounts. With the solid angle W of a part of
//! the plateau and the elevation e of its centre, each part gets the weight
//!
//! ```text
//!   weight = W^(1/2) exp(1.5 sin e)
//! ```
//!
//! and distributes it over its pixels by the square of their depth: a sun is in the middle of its glow. The power of W is chosen on pictures of HDR maps, by the irradiance of a probe.

use std::f64::consts::TAU;

use glam::DVec3;
use ndarray::{Array2, ArrayView3, Axis};
use rayon::prelude::*;

use crate::error::Result;
use crate::interrupt;
use crate::kernels::detect::clipped::depth;
use crate::kernels::detect::clipped::{expand, necks, order, plateau};
use crate::kernels::detect::segment::run::Run;
use crate::kernels::detect::segment::working_image::WorkingImage;
use crate::kernels::image::LEAST_WHITE;
use crate::kernels::image::{CellCentres, samples_of};
use crate::kernels::sphere::{Registration, band_heights};

/// Density, per steradian, of the light that was cut off at `white`, for each pixel of a map, (height, width, 3).
///
/// The integral over the sphere is 1, and only pixels with a clipped channel have any; 0 everywhere if there are none.
/// Parts are separated in at most `columns` columns; gaps of up to `gap` radians do not divide them.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`], [`crate::error::Error::TooBright`].
pub fn shares(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    white: f64,
    columns: usize,
    gap: f64,
) -> Result<Array2<f32>> {
    // Find the parts of the plateau.
    let working = WorkingImage::of(radiance, registration, columns)?;
    let clipped = ClippedPixels { radiance, block: working.block, least: (LEAST_WHITE * white) as f32 };
    let plateau = clipped.plateau(&working, gap);
    let depth = depth::depths(&working, &plateau);
    let parts = necks::parts(&working, &plateau, &depth);
    // Weigh them.
    let bands = band_heights(&registration.theta_edges(radiance.dim().0));
    let per_depth = weights_per_squared_depth(&clipped, &working, &parts, &depth, &bands);
    // Share by the square of the depth.
    let mut share = Array2::zeros((radiance.dim().0, radiance.dim().1));
    share.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(row, mut out)| {
        interrupt::check();
        let first = row / working.block * working.size.1;
        for column in clipped.columns(row) {
            let pixel = first + column / working.block;
            let weight = per_depth[parts[pixel] as usize] * squared_depth(depth[pixel], &working);
            out[column] = weight as f32;
        }
    });
    Ok(share)
}

/// The depth of the plateau of a clipped map in radians, in at most `columns` columns; 0 outside of it.
///
/// # Errors
///
/// Errors of [`shares`].
pub fn clipped_depth(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    white: f64,
    columns: usize,
    gap: f64,
) -> Result<Array2<f32>> {
    let working = WorkingImage::of(radiance, registration, columns)?;
    let clipped = ClippedPixels { radiance, block: working.block, least: (LEAST_WHITE * white) as f32 };
    let depth = depth::depths(&working, &clipped.plateau(&working, gap));
    let (_, width) = working.size;
    Ok(Array2::from_shape_fn(working.size, |(row, column)| depth[row * width + column]))
}

/// A map with a known least clipped sample.
struct ClippedPixels<'a> {
    radiance: ArrayView3<'a, f32>,
    block: usize,
    /// The least clipped sample.
    least: f32,
}

impl ClippedPixels<'_> {
    /// The columns of a row that are clipped.
    fn columns(&self, row: usize) -> Vec<usize> {
        let samples = samples_of(self.radiance, row..row + 1);
        let pixels = samples.as_chunks::<3>().0.iter().enumerate();
        pixels.filter(|(_, rgb)| rgb.iter().any(|&y| y >= self.least)).map(|(column, _)| column).collect()
    }

    /// The plateau: the working pixels that hold a clipped pixel, with gaps filled.
    fn plateau(&self, working: &WorkingImage, gap: f64) -> Vec<Run> {
        let covered = self.working_pixels(working.size);
        let mut luminance = vec![0.0; working.luminance.len()];
        for &pixel in &covered {
            luminance[pixel as usize] = expand(1.0);
        }
        plateau::plateau(&working.with_luminance(luminance), &covered, gap)
    }

    /// Flat indices of the working pixels that hold a clipped pixel, in ascending order.
    fn working_pixels(&self, (height, width): (usize, usize)) -> Vec<u32> {
        let in_row = |row: usize| {
            interrupt::check();
            let mut is_covered = vec![false; width];
            for row in row * self.block..((row + 1) * self.block).min(self.radiance.dim().0) {
                for column in self.columns(row) {
                    is_covered[column / self.block] = true;
                }
            }
            let columns = (0..width).filter(|&column| is_covered[column]);
            columns.map(|column| (row * width + column) as u32).collect()
        };
        (0..height).into_par_iter().map(in_row).collect::<Vec<Vec<u32>>>().concat()
    }
}

/// The square of a depth plus half a pixel: a lamp of one pixel gets light too.
fn squared_depth(depth: f32, working: &WorkingImage) -> f64 {
    (f64::from(depth) + 0.5 * working.row_height()).powi(2)
}

/// For each part of the plateau, its weight over the integral of the squared depth of its clipped pixels.
fn weights_per_squared_depth(
    clipped: &ClippedPixels<'_>,
    working: &WorkingImage,
    parts: &[u32],
    depth: &[f32],
    bands: &[f64],
) -> Vec<f64> {
    // Sum solid angle, squared depth and direction over each part.
    let sphere = CellCentres::new(&working.grid);
    let count = parts.iter().copied().max().unwrap_or(0) as usize + 1;
    let (mut solid_angle, mut squares) = (vec![0.0; count], vec![0.0; count]);
    let mut towards = vec![DVec3::ZERO; count];
    let per_column = TAU / clipped.radiance.dim().1 as f64;
    for (row, band) in bands.iter().enumerate() {
        let first = row / working.block * working.size.1;
        for column in clipped.columns(row) {
            let pixel = first + column / working.block;
            let part = parts[pixel] as usize;
            let square = band * per_column * squared_depth(depth[pixel], working);
            solid_angle[part] += band * per_column;
            squares[part] += square;
            towards[part] += square * sphere.direction(pixel);
        }
    }
    // Weigh each part; floors only if there is nothing else.
    let mut weights: Vec<f64> = (0..count)
        .map(|part| solid_angle[part].sqrt() * order::from_above(solid_angle[part], unit(towards[part]).y))
        .collect();
    if weights.iter().sum::<f64>() == 0.0 {
        weights = solid_angle;
    }
    let sum: f64 = weights.iter().sum();
    let density = |(weight, square): (&f64, f64)| if square > 0.0 { weight / sum / square } else { 0.0 };
    weights.iter().zip(squares).map(density).collect()
}

fn unit(vector: DVec3) -> DVec3 {
    vector.normalize_or(DVec3::Y)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use approx::assert_relative_eq;
    use ndarray::Array3;

    use super::*;
    use crate::kernels::sphere::{pixel_solid_angles, row_directions};

    /// A dark map with caps at white: a direction and a radius in radians each.
    fn caps(height: usize, caps: &[(DVec3, f64)]) -> Array3<f32> {
        let directions = row_directions(height, 2 * height, Registration::CellCentred, 0..height).unwrap();
        Array3::from_shape_fn((height, 2 * height, 3), |(row, column, _)| {
            let at = DVec3::from_array([0, 1, 2].map(|axis| directions[[row, column, axis]]));
            let is_white = caps.iter().any(|(centre, radius)| at.angle_between(centre.normalize()) < *radius);
            if is_white { 1.0 } else { 0.1 }
        })
    }

    fn shares_of(map: &Array3<f32>, columns: usize) -> (Array2<f32>, Array2<f64>) {
        let (height, width, _) = map.dim();
        let share = shares(map.view(), Registration::CellCentred, 1.0, columns, 0.014).unwrap();
        (share, pixel_solid_angles(height, width, Registration::CellCentred).unwrap())
    }

    #[test]
    fn all_light_is_distributed_over_the_clipped_pixels() {
        for columns in [32, 128, 1000] {
            let map = caps(64, &[(DVec3::new(0.1, 0.3, -1.0), 0.3), (DVec3::Y, 0.2)]);
            let (share, solid_angles) = shares_of(&map, columns);
            let sum: f64 = share.iter().zip(&solid_angles).map(|(&share, dw)| f64::from(share) * dw).sum();
            assert_relative_eq!(sum, 1.0, max_relative = 1e-5);
            for ((row, column), &share) in share.indexed_iter() {
                assert_eq!(share > 0.0, map[[row, column, 0]] > 0.5, "{row} {column}: {share}");
            }
        }
    }

    /// The weights in closed form: `(W1 / W2)^(1/2) exp(1.5 (sin e1 - sin e2))`.
    #[test]
    fn parts_share_by_solid_angle_and_elevation() {
        let (high, low) = (DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, 0.0, 0.2));
        let (share, solid_angles) = shares_of(&caps(256, &[(high, 0.1), (low, 0.2)]), 512);
        let left: f64 = share
            .indexed_iter()
            .filter(|((_, column), _)| *column < 256) // +x is in the left half
            .map(|((row, column), &share)| f64::from(share) * solid_angles[[row, column]])
            .sum();
        let cap = |radius: f64| 1.0 - radius.cos();
        let ratio = (cap(0.1) / cap(0.2)).sqrt() * (1.5 * 0.5_f64.sqrt()).exp();
        assert_relative_eq!(left / (1.0 - left), ratio, max_relative = 0.02);
    }

    #[test]
    fn the_plateau_of_a_cap_is_as_deep_as_its_radius() {
        let map = caps(128, &[(DVec3::new(0.3, 0.4, 1.0), 0.3)]);
        let depth = clipped_depth(map.view(), Registration::CellCentred, 1.0, 256, 0.0).unwrap();
        assert_eq!(depth.dim(), (128, 256));
        let deepest = depth.iter().copied().fold(0.0, f32::max);
        assert_relative_eq!(f64::from(deepest), 0.3, epsilon = 0.025);
        assert_eq!(
            depth.iter().filter(|&&depth| depth > 0.0).count(),
            map.iter().filter(|&&y| y > 0.5).count() / 3
        );
    }

    #[test]
    fn an_unclipped_map_gets_no_light() {
        let (share, _) = shares_of(&Array3::from_elem((16, 32, 3), 0.5), 32);
        assert!(share.iter().all(|&share| share == 0.0));
    }

    #[test]
    fn a_white_sphere_and_a_white_floor_get_light_too() {
        for map in [Array3::from_elem((32, 64, 3), 1.0), caps(32, &[(-DVec3::Y, 0.8)])] {
            let (share, solid_angles) = shares_of(&map, 64);
            let sum: f64 = share.iter().zip(&solid_angles).map(|(&share, dw)| f64::from(share) * dw).sum();
            assert_relative_eq!(sum, 1.0, max_relative = 1e-5);
        }
    }
}
