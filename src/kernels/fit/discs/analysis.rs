//! From a map to harmonics.
//!
//! The coefficients of a map come in two steps: integrals over azimuth row by row (`azimuthal.rs`), then over the height
//! of the rows.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::{FRAC_PI_4, PI};

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::harmonics::Harmonics;
use super::place::Legendre;
use super::zonal::DEGREES;
use crate::kernels::fit::azimuthal::{self, Azimuthal, Rgb2};
use crate::kernels::image::Grid;
use crate::kernels::kept::Kept;

const _: () = assert!(DEGREES <= azimuthal::ORDERS, "rows are integrated for each order");

impl Harmonics {
    /// Of a map in cells, from the integrals over their rows.
    pub fn of_cells(azimuthal: &Azimuthal, grid: &Grid) -> Self {
        /// Parts of the rows that are summed side by side; always the same, so that the sums are too.
        const PARTS: usize = 4;
        static ROWS: Kept<Vec<f64>, Vec<Row>> = Kept::new();
        let rows = ROWS.of(&grid.theta_edges, || Row::all(&grid.theta_edges));
        let part = |rows: &[Row]| Arch::new().dispatch(Rows { rows, azimuthal });
        let parts: Vec<Self> = rows.par_chunks(rows.len().div_ceil(PARTS)).map(part).collect();
        parts.iter().fold(Self::zero(), |sum, part| sum.scaled_sum(&[1.0; DEGREES], part, &[1.0; DEGREES]))
    }
}

/// Some rows of a map.
struct Rows<'a> {
    rows: &'a [Row],
    azimuthal: &'a Azimuthal,
}

impl WithSimd for Rows<'_> {
    type Output = Harmonics;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Harmonics {
        let mut out = Harmonics::zero();
        for row in self.rows {
            row.add_to(&mut out, self.azimuthal);
        }
        out
    }
}

/// A row of cells between two polar angles, and the one at the same angles from the other pole where there is one.
struct Row {
    index: usize,
    mirrored: Option<usize>,
    /// Integrals of `P_lm` over theta, order by order, degree by degree.
    integrals: Vec<f64>,
}

impl Row {
    fn all(edges: &[f64]) -> Vec<Self> {
        let rows = edges.len() - 1;
        let is_symmetric = (0..=rows).all(|i| (edges[i] + edges[rows - i] - PI).abs() < 1e-12);
        let row = |index: usize| {
            let mirrored = (is_symmetric && rows - 1 - index != index).then(|| rows - 1 - index);
            Self { index, mirrored, integrals: Self::integrals(edges[index], edges[index + 1]) }
        };
        (0..if is_symmetric { rows.div_ceil(2) } else { rows }).map(row).collect()
    }

    /// By two Gauss nodes in theta, more where the row is high.
    fn integrals(low: f64, high: f64) -> Vec<f64> {
        const HIGHEST: f64 = FRAC_PI_4 / 16.0;
        let parts = ((high - low) / HIGHEST).ceil().max(1.0);
        let half = 0.5 * (high - low) / parts;
        let mut out = vec![0.0; DEGREES * (DEGREES + 1) / 2];
        for node in 0..2 * parts as usize {
            let middle = low + half * (2 * (node / 2) + 1) as f64;
            let side = if node % 2 == 0 { -half } else { half };
            let (sine, cosine) = (middle + side / 3.0_f64.sqrt()).sin_cos();
            let mut legendre = Legendre::new(cosine, sine);
            let mut integrals = out.iter_mut();
            for m in 0..DEGREES {
                let column = legendre.column(m);
                (m..DEGREES).zip(&mut integrals).for_each(|(l, sum)| *sum += half * sine * column[l]);
            }
        }
        out
    }

    /// Add it to harmonics.
    #[inline(always)]
    fn add_to(&self, out: &mut Harmonics, azimuthal: &Azimuthal) {
        let mut values = out.values.iter_mut().zip(&self.integrals);
        for m in 0..DEGREES {
            // On the other side of the horizon, every second degree has the other sign.
            let one = azimuthal.at(self.index, m);
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
    use crate::kernels::fit::discs::disc::Disc;
    use crate::kernels::sphere::{Registration, direction};
    use glam::DVec3;
    use ndarray::Array3;

    /// A map of waves, which few degrees hold.
    fn waves(registration: Registration, columns: usize) -> (Array3<f32>, Grid) {
        let rows = columns / 2;
        let (thetas, phis) = (registration.thetas(rows), registration.phis(columns));
        let map = Array3::from_shape_fn((rows, columns, 3), |(y, x, c)| {
            wave(direction(thetas[y], phis[x]), c) as f32
        });
        (map, Grid::of_pixels(rows, columns, registration))
    }

    fn wave(d: DVec3, channel: usize) -> f64 {
        2.0 + d.x + 0.5 * d.y * d.z - 0.7 * d.x * d.z + (channel as f64) * d.y.powi(3) + 0.3 * d.z.powi(4)
    }

    /// A disc of radius 0: the map itself.
    #[test]
    fn harmonics_of_a_map_are_the_map() {
        for (registration, columns) in [
            (Registration::CellCentred, 256),
            (Registration::BorderSampled, 257),
            (Registration::CellCentred, 250),
        ] {
            let (map, grid) = waves(registration, columns);
            let harmonics = Harmonics::of_cells(&Azimuthal::new(map.view(), &grid.phi_edges), &grid);
            for place in [direction(0.0, 0.0), direction(1.0, 2.0), direction(2.9, 5.0)] {
                let values = harmonics.values(&[Disc::new(place, 0.0)])[0];
                for (channel, value) in values.into_iter().enumerate() {
                    assert!(
                        (value - wave(place, channel)).abs() < 2e-3,
                        "{place} {value} {}",
                        wave(place, channel)
                    );
                }
            }
        }
    }
}
