//! Inner products of the ambient columns with lights, as functions of degree 1 in the direction l of a light.
//!
//! ```text
//!   none
//!   constant     A = pi                  <A, a_l> = pi^2 |l|
//!   over a floor A = pi/2 (1 + n_y)      <A, a_l> = pi^2/2 |l| + pi^2/3 l_y
//!   harmonics    A = A_d Y_i             <A, a_l> = A_d^2 |l|^(1 - d) Y_i(l)         A_d: pi, 2 pi/3, pi/4
//! ```
//!
//! A floor hides the lower half of a constant environment. A harmonic of degree d is a polynomial of that degree;
//! for degree 2 it is `l^T B l` with a symmetric matrix B.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::kernels::fit::ambient::Ambient;
use crate::kernels::harmonics::{cosine_lobe, irradiance, irradiance_of_moments};

/// Integrals of the radiance L of one channel of a map: `L dw`, `L w dw` and `L w w^T dw`.
#[derive(Clone, Copy, Debug, Default)]
pub struct RadianceMoments {
    pub whole: f64,
    pub first: DVec3,
    pub second: DMat3,
}

/// The ambient columns, and their inner products over all normals.
#[derive(Clone, Copy, Debug)]
pub struct AmbientColumns {
    pub ambient: Ambient,
    pub has_floor: bool,
}

impl AmbientColumns {
    /// Inner product of two ambient columns.
    pub fn gram(self, i: usize, k: usize) -> f64 {
        match self.ambient {
            _ if i != k => 0.0,
            Ambient::Sh2 => cosine_lobe(i) * cosine_lobe(i),
            _ if self.has_floor => 4.0 / 3.0 * PI.powi(3),
            _ => 4.0 * PI.powi(3),
        }
    }

    /// Inner product with the probe under a map.
    pub fn probe(self, i: usize, map: &RadianceMoments) -> f64 {
        match self.ambient {
            Ambient::Sh2 => cosine_lobe(i) * irradiance_of_moments(map.whole, map.first, map.second)[i],
            _ if self.has_floor => PI * PI * (map.whole / 2.0 + map.first.y / 3.0),
            _ => PI * PI * map.whole,
        }
    }

    /// Derivatives by l of the inner products with a light.
    pub fn gradients(self, l: DVec3, out: &mut Vec<DVec3>) {
        match self.ambient {
            Ambient::None => (),
            Ambient::Constant if self.has_floor => out.push(PI * PI * (l / 2.0 + DVec3::Y / 3.0)),
            Ambient::Constant => out.push(PI * PI * l),
            Ambient::Sh2 => out.extend((0..9).map(|i| cosine_lobe(i) * harmonic_gradient(i, l))),
        }
    }

    /// Second derivative of the weighted sum of the inner products, on the tangent plane of l.
    pub fn second_derivative(self, l: DVec3, weights: &[f64]) -> DMat3 {
        let round = |value: f64| DMat3::from_diagonal(DVec3::splat(value));
        match self.ambient {
            Ambient::None => DMat3::ZERO,
            Ambient::Constant => round(weights[0] * PI * PI * if self.has_floor { 0.5 } else { 1.0 }),
            Ambient::Sh2 => {
                let values = irradiance(l);
                let own = |i: usize| match i {
                    0 => round(values[0]),
                    1..4 => DMat3::ZERO,
                    _ => quadratic(i) * 2.0 - round(values[i]),
                };
                (0..9).fold(DMat3::ZERO, |sum, i| sum + own(i) * (weights[i] * cosine_lobe(i)))
            }
        }
    }
}

/// Derivative of `A_d |l|^(1 - d) Y_i(l)` at a unit vector.
fn harmonic_gradient(i: usize, l: DVec3) -> DVec3 {
    let value = irradiance(l)[i];
    match i {
        0 => value * l,
        1..4 => DVec3::AXES.map(|axis| irradiance(axis)[i]).into(),
        _ => quadratic(i) * l * 2.0 - value * l,
    }
}

/// B of a harmonic of degree 2, with its factor `A_2`.
fn quadratic(i: usize) -> DMat3 {
    let at = |second: DMat3| irradiance_of_moments(0.0, DVec3::ZERO, second)[i];
    let trace = irradiance_of_moments(1.0, DVec3::ZERO, DMat3::ZERO)[i];
    let entry = |j: usize, k: usize| {
        let mut second = DMat3::ZERO;
        second.col_mut(k)[j] = 0.5;
        second.col_mut(j)[k] += 0.5;
        at(second) + if j == k { trace } else { 0.0 }
    };
    DMat3::from_cols_array_2d(&[0, 1, 2].map(|k| [0, 1, 2].map(|j| entry(j, k))))
}
