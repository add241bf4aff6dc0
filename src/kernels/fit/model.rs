//! The model, and every sum over the normals that a fit needs.
//!
//! Equations 4 to 6 of Madsen et al. 2003 in physical scale (the paper's `k_a` is pi, `k_d` and C are 1):
//!
//! ```text
//!   E(n) = pi La + sum_j E_j max(0, n.l_j)
//! ```
//!
//! For fixed directions this is linear in the radiances `La` and `E_j`. Its columns, and their
//! derivatives when `l_j` moves along its tangents `s_j`, `t_j`, are
//!
//! ```text
//!   a_0 = pi      a_j = v_j.l_j      da_j = v_j.s_j, v_j.t_j      v_j(n) = n where n.l_j > 0, else 0
//! ```
//!
//! so all their weighted inner products come from the hemisphere moments
//!
//! ```text
//!   sum w v_j        sum w v_j v_k^T  (over the normals that see both lights)        sum w v_j E^T
//! ```
//!
//! turned into the frames (l, s, t). One pass over the normals feeds the radiances, the Jacobian and
//! the gradient alike.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::{Probe, Rig};
use crate::kernels::sphere::tangents;

/// Inner products of the columns `[a_0, a_1, s_1, t_1, a_2, s_2, t_2, ...]`.
pub struct Moments {
    /// The tangents of each light.
    pub tangents: Vec<[DVec3; 2]>,
    /// Of the columns with each other, (1 + 3M, 1 + 3M).
    pub gram: DMatrix<f64>,
    /// Of the columns with the irradiance, (1 + 3M, 3).
    pub right: DMatrix<f64>,
}

/// Number of the column `a_j` of light `j`; its two derivatives follow.
pub fn column(light: usize) -> usize {
    1 + 3 * light
}

/// Irradiance of `rig` at `normal`.
pub fn irradiance(rig: &Rig, normal: DVec3) -> DVec3 {
    let lights = rig.directions.iter().zip(&rig.irradiance);
    lights.fold(rig.ambient * PI, |sum, (direction, irradiance)| {
        sum + irradiance * normal.dot(*direction).max(0.0)
    })
}

/// Weighted sum of squares of what `rig` leaves unexplained.
///
/// Summed from the residuals themselves: from the moments it would be a difference of large numbers.
pub fn cost(probe: &Probe, rig: &Rig) -> f64 {
    residuals(probe, rig).zip(&probe.weights).map(|(r, w)| w * r.length_squared()).sum()
}

/// What `rig` leaves unexplained at each normal.
pub fn residuals<'a>(probe: &'a Probe, rig: &'a Rig) -> impl Iterator<Item = DVec3> + 'a {
    probe.normals.iter().zip(&probe.irradiance).map(|(&n, &e)| e - irradiance(rig, n))
}

impl Moments {
    /// All sums over the normals of `probe` for lights in `directions`.
    pub fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        let tangents: Vec<[DVec3; 2]> = directions.iter().map(|&l| tangents(l)).collect();
        let frames: Vec<DMat3> =
            directions.iter().zip(&tangents).map(|(&l, &[s, t])| DMat3::from_cols(l, s, t)).collect();
        let visible: Vec<Vec<u64>> = directions.iter().map(|&l| visible(probe, l)).collect();
        let size = column(directions.len());
        let mut moments = Self { tangents, gram: DMatrix::zeros(size, size), right: DMatrix::zeros(size, 3) };
        moments.add_ambient(probe);
        for (j, frame) in frames.iter().enumerate() {
            moments.add_light(probe, j, frame, &visible[j]);
            for k in 0..=j {
                let seen_by_both = outer_products(probe, &visible[j], &visible[k]);
                moments.set_pair(j, k, frame.transpose() * seen_by_both * frames[k]);
            }
        }
        moments
    }

    fn add_ambient(&mut self, probe: &Probe) {
        self.gram[(0, 0)] = PI * PI * probe.weights.iter().sum::<f64>();
        let right = probe.irradiance.iter().zip(&probe.weights).fold(DVec3::ZERO, |sum, (e, w)| sum + e * *w);
        for channel in 0..3 {
            self.right[(0, channel)] = PI * right[channel];
        }
    }

    fn add_light(&mut self, probe: &Probe, light: usize, frame: &DMat3, visible: &[u64]) {
        let (mut sum, mut right) = (DVec3::ZERO, [DVec3::ZERO; 3]);
        for i in members(visible) {
            let weighted = probe.normals[i] * probe.weights[i];
            sum += weighted;
            for (channel, right) in right.iter_mut().enumerate() {
                *right += weighted * probe.irradiance[i][channel];
            }
        }
        for axis in 0..3 {
            let (row, along) = (column(light) + axis, frame.col(axis));
            self.gram[(row, 0)] = PI * along.dot(sum);
            self.gram[(0, row)] = PI * along.dot(sum);
            for (channel, right) in right.iter().enumerate() {
                self.right[(row, channel)] = along.dot(*right);
            }
        }
    }

    fn set_pair(&mut self, j: usize, k: usize, products: DMat3) {
        for a in 0..3 {
            for b in 0..3 {
                let value = products.col(b)[a];
                self.gram[(column(j) + a, column(k) + b)] = value;
                self.gram[(column(k) + b, column(j) + a)] = value;
            }
        }
    }
}

/// The normals that see a light in `direction`, as bits.
fn visible(probe: &Probe, direction: DVec3) -> Vec<u64> {
    let word = |normals: &[DVec3]| {
        normals.iter().enumerate().fold(0, |bits, (i, n)| bits | (u64::from(n.dot(direction) > 0.0) << i))
    };
    probe.normals.chunks(64).map(word).collect()
}

/// Positions of the bits that are set.
fn members(bits: &[u64]) -> impl Iterator<Item = usize> + '_ {
    bits.iter().enumerate().flat_map(|(word, &bits)| {
        std::iter::successors((bits != 0).then_some(bits), |rest| {
            let rest = rest & (rest - 1);
            (rest != 0).then_some(rest)
        })
        .map(move |rest| 64 * word + rest.trailing_zeros() as usize)
    })
}

/// `sum w n n^T` over the normals in both sets.
fn outer_products(probe: &Probe, first: &[u64], second: &[u64]) -> DMat3 {
    let both: Vec<u64> = first.iter().zip(second).map(|(a, b)| a & b).collect();
    let (mut diagonal, mut mixed) = (DVec3::ZERO, DVec3::ZERO);
    for i in members(&both) {
        let [squares, products] = probe.outer[i];
        diagonal += squares;
        mixed += products;
    }
    DMat3::from_cols(
        DVec3::new(diagonal.x, mixed.x, mixed.z),
        DVec3::new(mixed.x, diagonal.y, mixed.y),
        DVec3::new(mixed.z, mixed.y, diagonal.z),
    )
}
