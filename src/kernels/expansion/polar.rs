//! Harmonics of a map, by integrals over polar angle of its integrals over azimuth.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::{FRAC_PI_4, PI};

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::azimuthal::Azimuthal;
use super::{AssociatedLegendre, DEGREES, Harmonics, Rgb2};
use crate::kernels::cache::Cache;
use crate::kernels::image::Grid;

impl Harmonics {
    /// Expand the cells of a map, from the integrals over their rows.
    pub fn of_cells(azimuthal: &Azimuthal, grid: &Grid) -> Self {
        /// Parts of the rows that are summed in parallel; constant, so that sums do not depend on the number of threads.
        const PARTS: usize = 4;
        static BANDS: Cache<Vec<f64>, Vec<Band>> = Cache::new();
        let bands = BANDS.get(&grid.theta_edges, || Band::all(&grid.theta_edges));
        let part = |bands: &[Band]| Arch::new().dispatch(BandSum { bands, azimuthal });
        let parts: Vec<Self> = bands.par_chunks(bands.len().div_ceil(PARTS)).map(part).collect();
        parts.iter().fold(Self::zero(), |sum, part| sum.scaled_sum(&[1.0; DEGREES], part, &[1.0; DEGREES]))
    }
}

/// Sum of the harmonics of some bands, in the widest vectors. A closure would not use them.
struct BandSum<'a> {
    bands: &'a [Band],
    azimuthal: &'a Azimuthal,
}

impl WithSimd for BandSum<'_> {
    type Output = Harmonics;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Harmonics {
        let mut out = Harmonics::zero();
        for band in self.bands {
            band.add_to(&mut out, self.azimuthal);
        }
        out
    }
}

/// A row of cells between two polar angles, with its mirror image below the horizon if there is one.
struct Band {
    row: usize,
    mirrored: Option<usize>,
    /// Integrals of `P_lm` over theta, order by order, degree by degree.
    integrals: Vec<f64>,
}

impl Band {
    fn all(edges: &[f64]) -> Vec<Self> {
        let rows = edges.len() - 1;
        let is_symmetric = (0..=rows).all(|i| (edges[i] + edges[rows - i] - PI).abs() < 1e-12);
        let band = |row: usize| {
            let mirrored = (is_symmetric && rows - 1 - row != row).then(|| rows - 1 - row);
            Self { row, mirrored, integrals: Self::integrals(edges[row], edges[row + 1]) }
        };
        (0..if is_symmetric { rows.div_ceil(2) } else { rows }).map(band).collect()
    }

    /// Integrals by two Gauss nodes in theta, or more for high rows.
    fn integrals(low: f64, high: f64) -> Vec<f64> {
        const HIGHEST: f64 = FRAC_PI_4 / 16.0;
        let parts = ((high - low) / HIGHEST).ceil().max(1.0);
        let half = 0.5 * (high - low) / parts;
        let mut out = vec![0.0; DEGREES * (DEGREES + 1) / 2];
        for node in 0..2 * parts as usize {
            let middle = low + half * (2 * (node / 2) + 1) as f64;
            let side = if node % 2 == 0 { -half } else { half };
            let (sine, cosine) = (middle + side / 3.0_f64.sqrt()).sin_cos();
            let mut legendre = AssociatedLegendre::new(cosine, sine);
            let mut integrals = out.iter_mut();
            for m in 0..DEGREES {
                let column = legendre.column(m);
                (m..DEGREES).zip(&mut integrals).for_each(|(l, sum)| *sum += half * sine * column[l]);
            }
        }
        out
    }

    /// Add the band to harmonics.
    #[inline(always)]
    fn add_to(&self, out: &mut Harmonics, azimuthal: &Azimuthal) {
        let mut values = out.values.iter_mut().zip(&self.integrals);
        for m in 0..DEGREES {
            // Change the sign of every second degree below the horizon.
            let one = azimuthal.at(self.row, m);
            let other = self.mirrored.map_or(&[0.0; 8], |row| azimuthal.at(row, m));
            let mut sums: [Rgb2; 2] = [[0.0; 8]; 2];
            for i in 0..8 {
                (sums[0][i], sums[1][i]) = (one[i] + other[i], one[i] - other[i]);
            }
            for (l, (value, integral)) in (m..DEGREES).zip(&mut values) {
                let sum = &sums[(l - m) % 2];
                for i in 0..8 {
                    value[i] += integral * sum[i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::Cap;
    use crate::kernels::sphere::{Registration, direction};
    use glam::DVec3;
    use ndarray::Array3;

    fn wave(d: DVec3, channel: usize) -> f64 {
        2.0 + d.x + 0.5 * d.y * d.z - 0.7 * d.x * d.z + (channel as f64) * d.y.powi(3) + 0.3 * d.z.powi(4)
    }

    /// Checks a map that is a polynomial of few degrees.
    #[test]
    fn harmonics_of_a_map_are_the_map() {
        for (registration, columns) in [
            (Registration::CellCentred, 256),
            (Registration::BorderSampled, 257),
            (Registration::CellCentred, 250),
        ] {
            let rows = columns / 2;
            let (thetas, phis) = (registration.thetas(rows), registration.phis(columns));
            let pixel = |(y, x, c)| wave(direction(thetas[y], phis[x]), c) as f32;
            let map = Array3::from_shape_fn((rows, columns, 3), pixel);
            let grid = Grid::of_pixels(rows, columns, registration);
            let harmonics = Harmonics::of_cells(&Azimuthal::new(map.view(), &grid.phi_edges, DEGREES), &grid);
            for at in [direction(0.0, 0.0), direction(1.0, 2.0), direction(2.9, 5.0)] {
                let values = harmonics.values(&[Cap::new(at, 0.0)])[0];
                for (channel, value) in values.into_iter().enumerate() {
                    assert!((value - wave(at, channel)).abs() < 2e-3, "{at} {value} {}", wave(at, channel));
                }
            }
        }
    }
}
