//! From a map to harmonics.
//!
//! A map is the sum of its cells, each a patch of one radiance between two parallels and two meridians. So its
//! coefficients come in two steps: integrals over azimuth row by row, then over the height of the rows.

use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::{Complex, DMatrix};
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::harmonics::{Harmonics, Rgb2};
use super::place::Legendre;
use super::zonal::DEGREES;
use crate::kernels::image::Grid;
use crate::kernels::kept::Kept;

impl Harmonics {
    /// Of a map in cells.
    pub fn of_cells(radiance: ArrayView3<'_, f32>, grid: &Grid) -> Self {
        /// Parts of the rows that are summed side by side; always the same, so that the sums are too.
        const PARTS: usize = 4;
        static ROWS: Kept<Vec<f64>, Vec<Row>> = Kept::new();
        let azimuthal = azimuthal(radiance, &grid.phi_edges);
        let rows = ROWS.of(&grid.theta_edges, || Row::all(&grid.theta_edges));
        let part = |rows: &[Row]| {
            let mut out = Self::zero();
            for row in rows {
                row.add_to(&mut out, &azimuthal);
            }
            out
        };
        let parts: Vec<Self> = rows.par_chunks(rows.len().div_ceil(PARTS)).map(part).collect();
        parts.iter().fold(Self::zero(), |sum, part| sum.scaled_sum(&[1.0; DEGREES], part, &[1.0; DEGREES]))
    }
}

/// Integrals over azimuth of each row, by `cos m phi` and `sin m phi`: for each row, each order.
fn azimuthal(radiance: ArrayView3<'_, f32>, edges: &[f64]) -> Vec<Rgb2> {
    let (rows, columns, _) = radiance.dim();
    let samples = radiance.as_standard_layout();
    let samples = samples.as_slice().unwrap_or(&[]).as_chunks::<3>().0; // the standard layout is a slice
    let whole = edges[columns];
    let is_symmetric = columns.is_multiple_of(2)
        && (0..=columns).all(|x| (edges[x] + edges[columns - x] - whole).abs() < 1e-12 * whole);
    // Cosines are even, sines are odd: of symmetric columns one half is enough.
    let used = if is_symmetric { columns / 2 } else { columns };
    let mut cells = [(); 2].map(|()| DMatrix::zeros(used, 3 * rows));
    let [even, odd] = &mut cells;
    for (row, samples) in samples.chunks_exact(columns).enumerate() {
        for x in 0..used {
            for (channel, &one) in samples[x].iter().enumerate() {
                let (place, one) = ((x, 3 * row + channel), f64::from(one));
                let other = f64::from(samples[columns - 1 - x][channel]);
                even[place] = if is_symmetric { one + other } else { one };
                odd[place] = if is_symmetric { one - other } else { one };
            }
        }
    }
    let mut out = vec![[0.0; 8]; rows * DEGREES];
    for ((first, cells), integrals) in [0, 4].into_iter().zip(&cells).zip(integrals(&edges[..=used])) {
        let sums = integrals * cells;
        for row in 0..rows {
            for m in 0..DEGREES {
                (0..3).for_each(|c| out[row * DEGREES + m][first + c] = sums[(m, 3 * row + c)]);
            }
        }
    }
    out
}

/// `integral of cos m phi` and of `sin m phi` over each column, for each order.
fn integrals(edges: &[f64]) -> [DMatrix<f64>; 2] {
    let mut out = [(); 2].map(|()| DMatrix::zeros(DEGREES, edges.len() - 1));
    let mut low = turns(edges[0]);
    for (x, edge) in edges.windows(2).enumerate() {
        let high = turns(edge[1]);
        out[0][(0, x)] = edge[1] - edge[0];
        for m in 1..DEGREES {
            out[0][(m, x)] = (high[m].im - low[m].im) / m as f64;
            out[1][(m, x)] = (low[m].re - high[m].re) / m as f64;
        }
        low = high;
    }
    out
}

/// `exp(i m phi)` for each order m, each from the one before.
fn turns(phi: f64) -> [Complex<f64>; DEGREES] {
    let turn = Complex::from_polar(1.0, phi);
    let mut turns = [Complex::ONE; DEGREES];
    (1..DEGREES).for_each(|m| turns[m] = turns[m - 1] * turn);
    turns
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
    fn add_to(&self, out: &mut Harmonics, azimuthal: &[Rgb2]) {
        let mut values = out.values.iter_mut().zip(&self.integrals);
        for m in 0..DEGREES {
            // On the other side of the horizon, every second degree has the other sign.
            let one = azimuthal[self.index * DEGREES + m];
            let other = self.mirrored.map_or([0.0; 8], |row| azimuthal[row * DEGREES + m]);
            let sums: [Rgb2; 2] =
                [std::array::from_fn(|i| one[i] + other[i]), std::array::from_fn(|i| one[i] - other[i])];
            for (l, (value, integral)) in (m..DEGREES).zip(&mut values) {
                let sum = &sums[(l - m) % 2];
                (0..8).for_each(|i| value[i] += integral * sum[i]);
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
            let harmonics = Harmonics::of_cells(map.view(), &grid);
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
