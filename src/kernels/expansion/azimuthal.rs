//! Integrals of the rows of a map over azimuth, times `cos m phi` and `sin m phi`.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix};
use ndarray::ArrayView3;
use rayon::prelude::*;

use super::Rgb2;
use crate::kernels::cache::Cache;

/// Rows that one task integrates; constant, so that sums do not depend on the number of threads.
const TASK_ROWS: usize = 16;

/// Integrals over azimuth, for each row and order.
#[derive(Clone, Debug)]
pub struct Azimuthal {
    /// Number of orders.
    orders: usize,
    values: Vec<Rgb2>,
}

impl Azimuthal {
    /// Integrate cells of `radiance`, (rows, columns, 3), between meridians, for the orders below `orders`.
    pub fn new(radiance: ArrayView3<'_, f32>, edges: &[f64], orders: usize) -> Self {
        static WAVES: Cache<(Vec<f64>, usize), Waves> = Cache::new();
        let waves: Arc<Waves> = WAVES.get(&(edges.to_vec(), orders), || Waves::new(edges, orders));
        let (rows, count, _) = radiance.dim();
        let samples = radiance.as_standard_layout();
        let samples = samples.as_slice().unwrap_or(&[]).as_chunks::<3>().0; // the standard layout is a slice
        let mut values = vec![[0.0; 8]; rows * orders];
        let tasks = samples.par_chunks(TASK_ROWS * count);
        tasks.zip(values.par_chunks_mut(TASK_ROWS * orders)).for_each(|(samples, values)| {
            waves.integrate(samples, values);
        });
        Self { orders, values }
    }

    /// The integrals of one order over a row.
    pub fn at(&self, row: usize, order: usize) -> &Rgb2 {
        &self.values[row * self.orders + order]
    }
}

/// Integrals of cosines and sines over the columns of a map.
struct Waves {
    count: usize,
    /// Number of orders.
    orders: usize,
    /// True if the columns of the 4 quarters of a row mirror each other.
    are_symmetric: bool,
    /// Integrals of each kind, with a row for each order and a column for each column of the map, or of its first quarter.
    integrals: [DMatrix<f64>; 4],
}

/// Orders of a kind below `end`: cosines of even and of odd order, then sines of even and of odd order.
fn orders_of(kind: usize, end: usize) -> impl Iterator<Item = usize> {
    (kind % 2..end).step_by(2)
}

impl Waves {
    /// Integrate between meridians.
    fn new(edges: &[f64], orders: usize) -> Self {
        let count = edges.len() - 1;
        let width = edges[count] / count as f64;
        let are_equal = edges.windows(2).all(|edge| ((edge[1] - edge[0]) / width - 1.0).abs() < 1e-9);
        let are_symmetric = are_equal && count.is_multiple_of(4);
        let used = if are_symmetric { count / 4 } else { count };
        let of_kind = |kind: usize| {
            let of_rows: Vec<usize> = orders_of(kind, orders).collect();
            DMatrix::from_fn(of_rows.len(), used, |i, x| {
                integral(of_rows[i], edges[x], edges[x + 1])[kind / 2]
            })
        };
        Self { count, orders, are_symmetric, integrals: [0, 1, 2, 3].map(of_kind) }
    }

    /// Integrate some rows of `samples`.
    fn integrate(&self, samples: &[[f32; 3]], values: &mut [Rgb2]) {
        let cells = if self.are_symmetric { self.fold(samples) } else { self.repeat(samples) };
        for (kind, (cells, integrals)) in cells.iter().zip(&self.integrals).enumerate() {
            let sums = integrals * cells;
            for (column, sums) in sums.column_iter().enumerate() {
                let (row, slot) = (column / 3, 4 * (kind / 2) + column % 3);
                for (order, sum) in orders_of(kind, self.orders).zip(sums.iter()) {
                    values[row * self.orders + order][slot] = *sum;
                }
            }
        }
    }

    /// Signed sums of the 4 quarters of each row for each kind, with a column for each row and channel.
    ///
    /// At phi, pi - phi, pi + phi and 2 pi - phi the signs of the kinds are `+ + + +`, `+ - - +`, `+ - + -` and `+ + - -`.
    fn fold(&self, samples: &[[f32; 3]]) -> [DMatrix<f64>; 4] {
        let (length, half) = (self.count / 4, self.count / 2);
        let columns = 3 * samples.len() / self.count;
        let mut out = [(); 4].map(|()| DMatrix::zeros(length, columns));
        let mut kinds = out.each_mut().map(|kind| kind.as_mut_slice().chunks_exact_mut(length));
        for column in 0..columns {
            let row = &samples[column / 3 * self.count..][..self.count];
            let quarters = row[..length].iter().zip(row[length..half].iter().rev());
            let others = row[half..half + length].iter().zip(row[half + length..].iter().rev());
            let sums = kinds.each_mut().map(|kind| kind.next().unwrap_or_default());
            for (x, ((a, b), (c, d))) in quarters.zip(others).enumerate() {
                let [a, b, c, d] = [a, b, c, d].map(|sample| f64::from(sample[column % 3]));
                let (sum, difference, other_sum, other_difference) = (a + c, a - c, b + d, b - d);
                sums[0][x] = sum + other_sum;
                sums[1][x] = difference - other_difference;
                sums[2][x] = sum - other_sum;
                sums[3][x] = difference + other_difference;
            }
        }
        out
    }

    /// The whole rows, once for each kind.
    fn repeat(&self, samples: &[[f32; 3]]) -> [DMatrix<f64>; 4] {
        let cell = |x: usize, column: usize| f64::from(samples[column / 3 * self.count + x][column % 3]);
        let cells = DMatrix::from_fn(self.count, 3 * samples.len() / self.count, cell);
        [(); 4].map(|()| cells.clone())
    }
}

/// The integrals of `cos m phi` and of `sin m phi` between two azimuths.
fn integral(m: usize, low: f64, high: f64) -> [f64; 2] {
    if m == 0 {
        return [high - low, 0.0];
    }
    let order = m as f64;
    let difference = Complex::from_polar(1.0, order * high) - Complex::from_polar(1.0, order * low);
    [difference.im / order, -difference.re / order]
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    /// Checks rows with and without folding, in one task and in two.
    #[test]
    fn integrals_are_sums_over_cells() {
        for columns in [64, 30] {
            let map = Array3::from_shape_fn((20, columns, 3), |(y, x, c)| ((7 * y + 3 * x + c) % 11) as f32);
            let edges: Vec<f64> =
                (0..=columns).map(|x| std::f64::consts::TAU * x as f64 / columns as f64).collect();
            let integrals = Azimuthal::new(map.view(), &edges, 41);
            for (row, order, c) in [(0, 0, 0), (3, 1, 2), (17, 40, 1), (19, 7, 0)] {
                let mut expected = [0.0; 2];
                for x in 0..columns {
                    let cell = integral(order, edges[x], edges[x + 1]);
                    (0..2).for_each(|side| expected[side] += cell[side] * f64::from(map[[row, x, c]]));
                }
                let values = integrals.at(row, order);
                assert!(
                    (values[c] - expected[0]).abs() < 1e-11 && (values[4 + c] - expected[1]).abs() < 1e-11
                );
            }
        }
    }
}
