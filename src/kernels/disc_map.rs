//! Drawing of discs of uniform radiance into an equirectangular map.
//!
//! On the parallel theta, a disc of radius a around (`theta_0`, `phi_0`) covers the azimuths `phi_0 -+ D`, with
//!
//! ```text
//!   cos D = (cos a - cos theta cos theta_0) / (sin theta sin theta_0)
//! ```
//!
//! all of the parallel for `cos D <= -1` and nothing of it for `cos D >= 1`. So the covered fraction of
//! each pixel is exact along a row, and a sum over a few parallels from row to row.
//!
//! The radiance of pixels on the rim is proportional to their covered fraction. That moves the light of the rim to whole
//! pixels, and changes the vector irradiance of the disc, `integral of L(w) w dw`. A small radiance that is linear in the
//! direction corrects it: at every normal with all of the disc in front of it, the map has the irradiance of the light.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use ndarray::{Array3, Axis};
use rayon::prelude::*;

use super::cell_integrals::{ColumnIntegrals, RowIntegrals};
use super::disc::Discs;
use super::sphere::{self, Registration, angles, direction_of};
use crate::error::Result;
use crate::interrupt;

/// Parallels in each row at which the covered fractions are measured.
const PARALLELS: usize = 16;
/// Smallest covered fraction of a pixel that is drawn. Below it, a detector measures noise and misses several per cent of
/// the smallest discs.
const LEAST_FRACTION: f64 = 0.08;

/// Radiance, (height, 2 x height, 3), of `discs` before a black sky.
///
/// Points become discs with a radius of one row: their pixels surround the centre, so that they have its direction.
///
/// # Errors
///
/// [`crate::error::Error::TooFewPixels`], [`crate::error::Error::NoMemory`].
pub fn draw(discs: &Discs, height: usize) -> Result<Array3<f64>> {
    let map = Map::new(height)?;
    let mut radiance = Array3::zeros((height, 2 * height, 3));
    let positions = discs.directions.iter().zip(&discs.radii);
    for ((&direction, &radius), irradiance) in positions.zip(&discs.irradiance) {
        let disc = PixelDisc { direction, radius: radius.max(PI / height as f64) };
        let unit = disc.radiance(&map);
        radiance.outer_iter_mut().into_par_iter().zip(&unit).for_each(|(mut row, unit)| {
            interrupt::check();
            for (mut pixel, fraction) in row.axis_iter_mut(Axis(0)).zip(unit) {
                pixel.iter_mut().zip(irradiance.to_array()).for_each(|(sum, e)| *sum += fraction * e);
            }
        });
    }
    Ok(radiance)
}

/// Rows and columns of a map, twice as wide as high.
struct Map {
    theta_edges: Vec<f64>,
    rows: Vec<RowIntegrals>,
    columns: Vec<ColumnIntegrals>,
    /// Sine and cosine of the azimuth of each column.
    azimuths: Vec<(f64, f64)>,
}

impl Map {
    fn new(height: usize) -> Result<Self> {
        let width = 2 * height;
        sphere::check_size(height, width)?;
        sphere::check_memory(&[height, width, 6])?;
        let theta_edges = Registration::CellCentred.theta_edges(height);
        let rows = RowIntegrals::of_rows(&theta_edges);
        let columns = ColumnIntegrals::of_columns(&Registration::CellCentred.phi_edges(width));
        let azimuths = Registration::CellCentred.phis(width).into_iter().map(f64::sin_cos).collect();
        Ok(Self { theta_edges, rows, columns, azimuths })
    }

    /// The integral of the direction over each pixel of a row, and the direction of its centre.
    fn row(&self, row: usize) -> impl Iterator<Item = (DVec3, DVec3)> {
        let theta = (0.5 * (self.theta_edges[row] + self.theta_edges[row + 1])).sin_cos();
        self.columns
            .iter()
            .zip(&self.azimuths)
            .map(move |(column, &azimuth)| (self.rows[row].direction(column), direction_of(theta, azimuth)))
    }

    /// Width of a column in radians.
    fn column(&self) -> f64 {
        TAU / self.columns.len() as f64
    }
}

struct PixelDisc {
    direction: DVec3,
    radius: f64,
}

impl PixelDisc {
    /// Radiance of each pixel, rows of columns, for an irradiance of 1 at normal incidence.
    fn radiance(&self, map: &Map) -> Vec<Vec<f64>> {
        let uniform = 1.0 / (PI * self.radius.sin().powi(2));
        let mut rows: Vec<Vec<f64>> =
            (0..map.rows.len()).into_par_iter().map(|row| self.covered_fractions(map, row)).collect();
        // Sum the covered pixels, and their products with the linear radiance, in the order of rows.
        let moments: Vec<(DVec3, DMat3)> =
            rows.par_iter().enumerate().map(|(row, fractions)| moments(map, row, fractions)).collect();
        let (vector, products) =
            moments.into_iter().fold((DVec3::ZERO, DMat3::ZERO), |sum, row| (sum.0 + row.0, sum.1 + row.1));
        // Find the linear radiance that corrects the vector irradiance, and add it.
        let gradient = products.inverse() * (self.direction - uniform * vector);
        rows.par_iter_mut().enumerate().for_each(|(row, fractions)| {
            interrupt::check();
            for (fraction, (_, centre)) in fractions.iter_mut().zip(map.row(row)) {
                *fraction *= uniform + gradient.dot(centre);
            }
        });
        rows
    }

    /// Fraction of each pixel of a row that the disc covers; empty for an untouched row.
    fn covered_fractions(&self, map: &Map, row: usize) -> Vec<f64> {
        interrupt::check();
        let (theta, phi) = angles(self.direction);
        let (top, bottom) = (map.theta_edges[row], map.theta_edges[row + 1]);
        if bottom <= theta - self.radius || top >= theta + self.radius {
            return Vec::new();
        }
        let mut fractions = vec![0.0; map.azimuths.len()];
        let parallels: [f64; PARALLELS] =
            std::array::from_fn(|k| top + (bottom - top) * (k as f64 + 0.5) / PARALLELS as f64);
        let whole: f64 = parallels.iter().map(|theta| theta.sin()).sum();
        for parallel in parallels {
            let half = self.half_width(theta, parallel);
            let (left, right) = ((phi - half) / map.column(), (phi + half) / map.column());
            add_interval(&mut fractions, left, right, parallel.sin() / whole);
        }
        fractions
            .iter_mut()
            .filter(|fraction| **fraction < LEAST_FRACTION)
            .for_each(|fraction| *fraction = 0.0);
        fractions
    }

    /// Half the width in azimuth that a disc around `theta` covers on a parallel.
    fn half_width(&self, theta: f64, parallel: f64) -> f64 {
        let above = self.radius.cos() - parallel.cos() * theta.cos();
        let scale = parallel.sin() * theta.sin();
        if above >= scale {
            0.0
        } else if above <= -scale {
            PI
        } else {
            (above / scale).acos()
        }
    }
}

/// Add `weight` times the part of each column between `left` and `right`, in columns, across the seam.
fn add_interval(fractions: &mut [f64], left: f64, right: f64, weight: f64) {
    let width = fractions.len() as i64;
    for column in left.floor() as i64..right.ceil() as i64 {
        let inside = right.min((column + 1) as f64) - left.max(column as f64);
        fractions[column.rem_euclid(width) as usize] += weight * inside;
    }
}

/// Integral of the direction over the covered part of a row, and of its product with the centres of pixels.
fn moments(map: &Map, row: usize, fractions: &[f64]) -> (DVec3, DMat3) {
    interrupt::check();
    let mut sums = (DVec3::ZERO, DMat3::ZERO);
    for (&fraction, (integral, centre)) in fractions.iter().zip(map.row(row)) {
        let integral = fraction * integral;
        sums.0 += integral;
        sums.1 += DMat3::from_cols(integral * centre.x, integral * centre.y, integral * centre.z);
    }
    sums
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{Array1, Array2};
    use proptest::prelude::*;

    use super::*;

    fn one(direction: DVec3, radius: f64) -> Discs {
        Discs {
            directions: vec![direction],
            irradiance: vec![DVec3::new(1.0, 2.0, 4.0)],
            radii: vec![radius],
        }
    }

    /// Sum of radiance times direction over a map, in red, and the sum of its radiance.
    fn flux(radiance: &Array3<f64>) -> (DVec3, f64) {
        let map = Map::new(radiance.dim().0).unwrap();
        let mut sums = (DVec3::ZERO, 0.0);
        for (row, pixels) in radiance.outer_iter().enumerate() {
            for (pixel, (integral, _)) in pixels.outer_iter().zip(map.row(row)) {
                sums.0 += pixel[0] * integral;
                sums.1 += pixel[0] * map.rows[row].band * map.column();
            }
        }
        sums
    }

    #[test]
    fn pixels_add_up_to_the_sphere_and_its_second_moment() {
        let map = Map::new(64).unwrap();
        let fractions = vec![1.0; 128];
        let sums = (0..64)
            .map(|row| moments(&map, row, &fractions))
            .fold((DVec3::ZERO, DMat3::ZERO), |sum, row| (sum.0 + row.0, sum.1 + row.1));
        assert!(sums.0.length() < 1e-12);
        let third = DMat3::from_diagonal(DVec3::splat(4.0 * PI / 3.0));
        assert!(sums.1.abs_diff_eq(third, 2e-3), "{}", sums.1);
    }

    proptest! {
        #[test]
        fn a_disc_keeps_irradiance_direction_and_flux(
            y in -1.0..=1.0_f64, azimuth in 0.0..TAU, radius in 0.0..=1.5_f64, narrow in proptest::bool::ANY,
            height in 16_usize..80,
        ) {
            let across = (1.0 - y * y).sqrt();
            let direction = DVec3::new(across * azimuth.sin(), y, -across * azimuth.cos());
            let radius = if narrow { radius.powi(6) / 100.0 } else { radius };
            let radiance = draw(&one(direction, radius), height).unwrap();
            let (vector, whole) = flux(&radiance);
            prop_assert!(vector.distance(direction) < 1e-10, "{vector}");
            prop_assert!(radiance.iter().all(|&value| value >= 0.0));
            // The flux follows, as the vector of a disc is the mean cosine times it.
            let radius = radius.max(PI / height as f64);
            let expected = 2.0 / (1.0 + radius.cos());
            prop_assert!((whole / expected - 1.0).abs() < 0.2 / height as f64, "{whole} {expected}");
        }

        /// Pixels inside are uniform up to the small linear part; those outside are black.
        #[test]
        fn a_disc_is_uniform(y in -1.0..=1.0_f64, azimuth in 0.0..TAU, radius in 0.2..=1.5_f64) {
            let across = (1.0 - y * y).sqrt();
            let direction = DVec3::new(across * azimuth.sin(), y, -across * azimuth.cos());
            let radiance = draw(&one(direction, radius), 64).unwrap();
            let map = Map::new(64).unwrap();
            let expected = 1.0 / (PI * radius.sin().powi(2));
            for (row, pixels) in radiance.outer_iter().enumerate() {
                for (pixel, (_, centre)) in pixels.outer_iter().zip(map.row(row)) {
                    let away = centre.dot(direction).clamp(-1.0, 1.0).acos();
                    if away > radius + 0.04 {
                        prop_assert!(pixel.iter().all(|value| *value <= 0.0));
                    } else if away < radius - 0.04 {
                        for (value, colour) in pixel.iter().zip([1.0, 2.0, 4.0]) {
                            let ratio = value / (expected * colour);
                            // 60 000 random discs pass; of as many, some exceed 4e-3.
                            prop_assert!((ratio - 1.0).abs() < 6e-3 / radius, "{ratio}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn discs_add_up_across_poles_and_seam() {
        let directions = Array2::from(vec![[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]]);
        let irradiance = Array2::from_elem((3, 3), 1.0);
        let radii = Array1::from(vec![0.3, 0.2, 0.0]);
        let discs = Discs::new(directions.view(), irradiance.view(), radii.view()).unwrap();
        let radiance = draw(&discs, 32).unwrap();
        assert!(flux(&radiance).0.distance(DVec3::new(0.0, 0.0, -1.0)) < 1e-12);
        for (row, column) in [(0, 5), (0, 40), (16, 0), (16, 63), (31, 7)] {
            assert!(radiance[[row, column, 0]] > 0.0, "{row} {column}");
        }
    }
}
