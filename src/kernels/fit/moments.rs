//! The inner products that a fit needs, of the model's columns and of their derivatives.
//!
//! Equations 4 to 6 of Madsen et al. 2003 in physical scale (the paper's `k_a` is pi, `k_d` and C are 1):
//!
//! ```text
//!   E(n) = sum_i c_i A_i(n) + sum_j E_j max(0, n.l_j)        A: pi, or harmonics (`ambient.rs`)
//! ```
//!
//! For fixed directions this is linear in `c_i` and `E_j`. The columns of the lights, and their
//! derivatives when `l_j` moves along its tangents `s_j`, `t_j`, are
//!
//! ```text
//!   a_j = v_j.l_j      da_j = v_j.s_j, v_j.t_j      v_j(n) = n where n.l_j > 0, else 0
//! ```
//!
//! so all their weighted inner products come from the hemisphere moments of `sums.rs`,
//!
//! ```text
//!   sum w v_j y   for each ambient column and channel y        sum w v_j v_k^T
//! ```
//!
//! turned into the frames (l, s, t).

use glam::DVec3;
use nalgebra::{DMatrix, DVectorViewMut};

use super::probe::Probe;
use super::sums::Sums;
use crate::kernels::sphere::tangents;

/// Inner products of the columns of the model, `[A.., a_1, a_2, ..]`, and the sums that they and their
/// derivatives come from.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Of the columns with each other.
    pub gram: DMatrix<f64>,
    /// Of the columns with the irradiance in each fitted channel.
    pub right: DMatrix<f64>,
    sums: Sums,
}

/// Inner products of the derivatives `[s_1, t_1, s_2, t_2, ..]` of the columns, by which the model changes
/// when a light turns.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// With the columns of the model.
    pub model: DMatrix<f64>,
    /// With each other.
    pub gram: DMatrix<f64>,
    /// With the irradiance in each fitted channel.
    pub right: DMatrix<f64>,
}

impl Moments {
    /// All sums over the normals of `probe` for lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        Self::of(probe, Sums::new(probe, directions), directions.to_vec())
    }

    /// The lights `kept`, and others in the directions `new` after them.
    pub fn with(&self, probe: &Probe, kept: &[usize], new: &[DVec3]) -> Self {
        let directions = kept.iter().map(|&j| self.directions[j]).chain(new.iter().copied()).collect();
        Self::of(probe, self.sums.with(probe, kept, new), directions)
    }

    /// The same lights in other `directions`.
    pub fn turned(&self, probe: &Probe, directions: Vec<DVec3>) -> Self {
        Self::of(probe, self.sums.turned(probe, &directions), directions)
    }

    /// Lights, each with a normal whose horizon it crosses on the way to `other` directions.
    pub fn crossed(&self, probe: &Probe, other: &Self) -> Vec<(usize, DVec3)> {
        self.sums.crossed(probe, &other.sums)
    }

    fn of(probe: &Probe, sums: Sums, directions: Vec<DVec3>) -> Self {
        let ambient = probe.ambient.coefficients();
        let size = ambient + directions.len();
        let mut gram = DMatrix::zeros(size, size);
        let mut right = DMatrix::zeros(size, probe.channels.len());
        gram.view_mut((0, 0), (ambient, ambient)).copy_from(&probe.ambient_gram.columns(0, ambient));
        right.rows_mut(0, ambient).copy_from(&probe.ambient_gram.columns_range(ambient..));
        for (j, &l) in directions.iter().enumerate() {
            let row = ambient + j;
            for (side, sum) in sums.lit(probe, j).enumerate() {
                match side.checked_sub(ambient) {
                    Some(channel) => right[(row, channel)] = sum.dot(l),
                    None => gram[(row, side)] = sum.dot(l),
                }
            }
            for (k, &other) in directions[..=j].iter().enumerate() {
                gram[(row, ambient + k)] = (sums.pair(j, k) * other).dot(l);
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        Self { directions, gram, right, sums }
    }

    /// Those of the lights but the first `held`.
    pub fn derivatives(&self, probe: &Probe, held: usize) -> Derivatives {
        let ambient = probe.ambient.coefficients();
        let frames: Vec<[DVec3; 2]> = self.directions[held..].iter().map(|&l| tangents(l)).collect();
        let size = 2 * frames.len();
        let mut model = DMatrix::zeros(size, self.gram.nrows());
        let mut right = DMatrix::zeros(size, probe.channels.len());
        for (j, frame) in frames.iter().enumerate() {
            for (side, sum) in self.sums.lit(probe, held + j).enumerate() {
                let products = match side.checked_sub(ambient) {
                    Some(channel) => right.column_mut(channel),
                    None => model.column_mut(side),
                };
                set(products, j, frame, sum);
            }
            for (k, &other) in self.directions.iter().enumerate() {
                set(model.column_mut(ambient + k), j, frame, self.sums.pair(held + j, k) * other);
            }
        }
        Derivatives { model, gram: self.turning(held, &frames), right }
    }

    /// Inner products of the derivatives with each other.
    fn turning(&self, held: usize, frames: &[[DVec3; 2]]) -> DMatrix<f64> {
        let mut gram = DMatrix::zeros(2 * frames.len(), 2 * frames.len());
        for (k, other) in frames.iter().enumerate() {
            for (j, frame) in frames.iter().enumerate().skip(k) {
                let sums = self.sums.pair(held + j, held + k);
                for (column, &tangent) in other.iter().enumerate() {
                    set(gram.column_mut(2 * k + column), j, frame, sums * tangent);
                }
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        gram
    }
}

/// Of the derivatives of the light j along its tangents, in its two rows.
fn set(mut products: DVectorViewMut<'_, f64>, j: usize, frame: &[DVec3; 2], sum: DVec3) {
    for (row, tangent) in frame.iter().enumerate() {
        products[2 * j + row] = sum.dot(*tangent);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::blocks::TERMINATOR;
    use crate::kernels::fit::{Ambient, Samples};
    use crate::kernels::sampling;
    use crate::kernels::sphere::exponential_map;
    use approx::assert_abs_diff_eq;
    use ndarray::Array2;

    fn probe(ambient: Ambient) -> Probe {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let colour = |i: usize, c: usize| ((7 * i + 3 * c) % 11) as f64;
        let irradiance = Array2::from_shape_fn((320, 3), |(i, c)| colour(i, c));
        Probe::new(Samples::new(normals.view(), weights.view(), irradiance.view()).unwrap(), ambient)
    }

    fn directions() -> Vec<DVec3> {
        [DVec3::Y, DVec3::new(1.0, 2.0, -2.0) / 3.0, DVec3::new(2.0, -6.0, 3.0) / 7.0].to_vec()
    }

    /// Each column at each normal, as the head of this file defines it.
    fn columns(probe: &Probe, moments: &Moments) -> Vec<Vec<f64>> {
        let ambient = |i: usize| {
            let columns = probe.samples.normals.iter().map(move |&n| probe.ambient.irradiance(n)[i]);
            columns.collect::<Vec<f64>>()
        };
        let along = |light: DVec3, axis: DVec3| {
            let seen = probe
                .samples
                .normals
                .iter()
                .map(|n| if n.dot(light) > TERMINATOR { n.dot(axis) } else { 0.0 });
            seen.collect::<Vec<f64>>()
        };
        let lights = moments.directions.iter().map(|&l| along(l, l));
        let derivatives = moments.directions.iter().flat_map(|&l| tangents(l).map(|axis| along(l, axis)));
        (0..probe.ambient.coefficients()).map(ambient).chain(lights).chain(derivatives).collect()
    }

    fn assert_sums(probe: &Probe, moments: &Moments) {
        let columns = columns(probe, moments);
        let (model, turned) = columns.split_at(moments.gram.nrows());
        let irradiance: Vec<Vec<f64>> =
            (0..3).map(|c| probe.samples.irradiance.iter().map(|e| e[c]).collect()).collect();
        let derivatives = moments.derivatives(probe, 0);
        assert_products(probe, &moments.gram, model, model);
        assert_products(probe, &moments.right, model, &irradiance);
        assert_products(probe, &derivatives.model, turned, model);
        assert_products(probe, &derivatives.gram, turned, turned);
        assert_products(probe, &derivatives.right, turned, &irradiance);
        // The derivatives of the lights beyond the first are the last of all.
        let rest = moments.derivatives(probe, 1);
        assert_products(probe, &rest.model, &turned[2..], model);
        assert_products(probe, &rest.gram, &turned[2..], &turned[2..]);
        assert_products(probe, &rest.right, &turned[2..], &irradiance);
    }

    fn assert_products(probe: &Probe, products: &DMatrix<f64>, rows: &[Vec<f64>], columns: &[Vec<f64>]) {
        assert_eq!(products.shape(), (rows.len(), columns.len()));
        let sum = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(&probe.samples.weights).map(|((a, b), w)| w * a * b).sum()
        };
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                assert_abs_diff_eq!(products[(i, j)], sum(a, b), epsilon = 1e-11);
            }
        }
    }

    #[test]
    fn the_moments_are_the_plain_sums() {
        for ambient in [Ambient::None, Ambient::Constant, Ambient::Sh2] {
            let probe = probe(ambient);
            assert_sums(&probe, &Moments::new(&probe, &directions()));
        }
    }

    #[test]
    fn turned_taken_out_and_put_in_they_still_are() {
        let probe = probe(Ambient::Constant);
        let moments = Moments::new(&probe, &directions());
        let turn = |&l: &DVec3| exponential_map(l, tangents(l)[1] * 0.7);
        let turned = moments.turned(&probe, directions().iter().map(turn).collect());
        assert_sums(&probe, &turned);
        let changed = turned.with(&probe, &[0, 2], &[DVec3::NEG_X, DVec3::NEG_Y]);
        assert_eq!(changed.directions[2..], [DVec3::NEG_X, DVec3::NEG_Y]);
        assert_sums(&probe, &changed);
    }
}
