//! Integrals of a map over azimuth, row by row: what both analyses of a map in harmonics start from.
//!
//! A map is the sum of its cells, each a patch of one radiance between two parallels and two meridians. So its
//! coefficients come in two steps: integrals over azimuth by `cos m phi` and `sin m phi`, which are these, and then
//! integrals over the height of the rows: `sphere/harmonics.rs`, and `discs/analysis.rs` for more degrees.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix};
use ndarray::ArrayView3;
use rayon::prelude::*;

use crate::kernels::image::WorkingMap;
use crate::kernels::kept::Kept;

/// Orders m from 0 on.
pub const ORDERS: usize = 41;

/// Three channels of a cosine, a place left free, and three of the sine.
pub type Rgb2 = [f64; 8];

/// Rows that one task sums.
const ROWS_OF_A_TASK: usize = 16;

/// Integrals over azimuth: for each row, each order.
#[derive(Clone, Debug)]
pub struct Azimuthal {
    values: Vec<Rgb2>,
}

impl Azimuthal {
    /// Of the cells of a map.
    pub fn of(map: &WorkingMap) -> Self {
        Self::new(map.radiance.view(), &map.grid.phi_edges)
    }

    /// The same map without its bright cells.
    pub fn without_bright(&self, map: &WorkingMap) -> Self {
        self.without(&map.bright, map.radiance.view(), &map.grid.phi_edges)
    }

    /// Of cells of `radiance`, (rows, columns, 3), between meridians.
    pub fn new(radiance: ArrayView3<'_, f32>, edges: &[f64]) -> Self {
        let columns = Columns::between(edges);
        let (rows, count, _) = radiance.dim();
        let samples = radiance.as_standard_layout();
        let samples = samples.as_slice().unwrap_or(&[]).as_chunks::<3>().0; // the standard layout is a slice
        let mut values = vec![[0.0; 8]; rows * ORDERS];
        let tasks = samples.par_chunks(ROWS_OF_A_TASK * count);
        tasks.zip(values.par_chunks_mut(ROWS_OF_A_TASK * ORDERS)).for_each(|(samples, values)| {
            columns.integrate(samples, values);
        });
        Self { values }
    }

    /// The same without the light of some `cells`, as rows and columns.
    fn without(&self, cells: &[(usize, usize)], radiance: ArrayView3<'_, f32>, edges: &[f64]) -> Self {
        let columns = Columns::between(edges);
        let mut values = self.values.clone();
        for &(row, column) in cells {
            let light = [0, 1, 2].map(|channel| f64::from(radiance[[row, column, channel]]));
            let orders = values[row * ORDERS..].iter_mut().zip(&columns.each[column]);
            for (value, [cosine, sine]) in orders {
                for channel in 0..3 {
                    value[channel] -= light[channel] * cosine;
                    value[4 + channel] -= light[channel] * sine;
                }
            }
        }
        Self { values }
    }

    /// The integrals of one order over a row.
    pub fn at(&self, row: usize, order: usize) -> &Rgb2 {
        &self.values[row * ORDERS + order]
    }
}

/// Integrals of cosines and sines over the columns of a map.
struct Columns {
    count: usize,
    /// Whether the quarters of a row mirror each other.
    are_folded: bool,
    /// `integral of cos m phi` and of `sin m phi` over each, for each order m.
    each: Vec<[[f64; 2]; ORDERS]>,
    /// The same by kind: a row for each order, a column for each column of a row, or of its first quarter.
    integrals: [DMatrix<f64>; 4],
}

/// Orders of a kind: cosines of even and of odd order, then sines of even and of odd order.
fn orders(kind: usize) -> impl Iterator<Item = usize> {
    (kind % 2..ORDERS).step_by(2)
}

impl Columns {
    /// Between meridians.
    fn between(edges: &[f64]) -> Arc<Self> {
        static COLUMNS: Kept<Vec<f64>, Columns> = Kept::new();
        COLUMNS.of(&edges.to_vec(), || Self::new(edges))
    }

    fn new(edges: &[f64]) -> Self {
        let count = edges.len() - 1;
        let width = edges[count] / count as f64;
        let are_alike = edges.windows(2).all(|edge| ((edge[1] - edge[0]) / width - 1.0).abs() < 1e-9);
        let are_folded = are_alike && count.is_multiple_of(4);
        let used = if are_folded { count / 4 } else { count };
        let each: Vec<_> = edges.windows(2).map(|edge| integrals(edge[0], edge[1])).collect();
        let of_kind = |kind: usize| {
            let orders: Vec<usize> = orders(kind).collect();
            DMatrix::from_fn(orders.len(), used, |i, x| each[x][orders[i]][kind / 2])
        };
        let integrals = [0, 1, 2, 3].map(of_kind);
        Self { count, are_folded, each, integrals }
    }

    /// The integrals over some rows of `samples`.
    fn integrate(&self, samples: &[[f32; 3]], values: &mut [Rgb2]) {
        let cells = if self.are_folded { self.folded(samples) } else { self.whole(samples) };
        for (kind, (cells, integrals)) in cells.iter().zip(&self.integrals).enumerate() {
            let sums = integrals * cells;
            for (column, sums) in sums.column_iter().enumerate() {
                let (row, place) = (column / 3, 4 * (kind / 2) + column % 3);
                for (order, sum) in orders(kind).zip(sums.iter()) {
                    values[row * ORDERS + order][place] = *sum;
                }
            }
        }
    }

    /// The four quarters of each row laid upon each other, for each kind with the signs that its functions have in them: a
    /// column for each row and channel.
    ///
    /// In the quarters at phi, pi - phi, pi + phi and 2 pi - phi these are `+ + + +`, `+ - - +`, `+ - + -` and `+ + - -`.
    fn folded(&self, samples: &[[f32; 3]]) -> [DMatrix<f64>; 4] {
        let (length, half) = (self.count / 4, self.count / 2);
        let columns = 3 * samples.len() / self.count;
        let mut out = [(); 4].map(|()| DMatrix::zeros(length, columns));
        let mut kinds = out.each_mut().map(|kind| kind.as_mut_slice().chunks_exact_mut(length));
        for column in 0..columns {
            let row = &samples[column / 3 * self.count..][..self.count];
            let quarters = row[..length].iter().zip(row[length..half].iter().rev());
            let others = row[half..half + length].iter().zip(row[half + length..].iter().rev());
            let folded = kinds.each_mut().map(|kind| kind.next().unwrap_or_default());
            for (x, ((a, b), (c, d))) in quarters.zip(others).enumerate() {
                let [a, b, c, d] = [a, b, c, d].map(|sample| f64::from(sample[column % 3]));
                let (sum, difference, other_sum, other_difference) = (a + c, a - c, b + d, b - d);
                folded[0][x] = sum + other_sum;
                folded[1][x] = difference - other_difference;
                folded[2][x] = sum - other_sum;
                folded[3][x] = difference + other_difference;
            }
        }
        out
    }

    /// The rows as they are, for each kind.
    fn whole(&self, samples: &[[f32; 3]]) -> [DMatrix<f64>; 4] {
        let cell = |x: usize, column: usize| f64::from(samples[column / 3 * self.count + x][column % 3]);
        let cells = DMatrix::from_fn(self.count, 3 * samples.len() / self.count, cell);
        [(); 4].map(|()| cells.clone())
    }
}

/// `integral of cos m phi` and of `sin m phi` between two azimuths, for each order m.
fn integrals(low: f64, high: f64) -> [[f64; 2]; ORDERS] {
    let ends = [low, high].map(turns);
    std::array::from_fn(|m| match m {
        0 => [high - low, 0.0],
        _ => [(ends[1][m].im - ends[0][m].im) / m as f64, (ends[0][m].re - ends[1][m].re) / m as f64],
    })
}

/// `exp(i m phi)` for each order m, each from the one before.
fn turns(phi: f64) -> [Complex<f64>; ORDERS] {
    let turn = Complex::from_polar(1.0, phi);
    let mut turns = [Complex::ONE; ORDERS];
    (1..ORDERS).for_each(|m| turns[m] = turns[m - 1] * turn);
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    fn map(columns: usize) -> (Array3<f32>, Vec<f64>) {
        let map = Array3::from_shape_fn((20, columns, 3), |(y, x, c)| ((7 * y + 3 * x + c) % 11) as f32);
        let edge = |x: usize| std::f64::consts::TAU * x as f64 / columns as f64;
        (map, (0..=columns).map(edge).collect())
    }

    fn assert_near(one: &Azimuthal, other: &Azimuthal) {
        for (a, b) in one.values.iter().flatten().zip(other.values.iter().flatten()) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }

    /// Laid upon each other or not, the quarters of a row have the same integrals: those of its cells, one by one.
    #[test]
    fn integrals_are_sums_over_cells() {
        for columns in [64, 30] {
            let (map, edges) = map(columns);
            let all: Vec<(usize, usize)> = (0..20).flat_map(|y| (0..columns).map(move |x| (y, x))).collect();
            let nothing = Azimuthal { values: vec![[0.0; 8]; 20 * ORDERS] };
            assert_near(&Azimuthal::new(map.view(), &edges).without(&all, map.view(), &edges), &nothing);
        }
    }

    #[test]
    fn cells_are_left_out() {
        let (mut map, edges) = map(64);
        let cells = [(0, 3), (17, 63)];
        let left = Azimuthal::new(map.view(), &edges).without(&cells, map.view(), &edges);
        for (row, column) in cells {
            (0..3).for_each(|channel| map[[row, column, channel]] = 0.0);
        }
        assert_near(&left, &Azimuthal::new(map.view(), &edges));
    }
}
